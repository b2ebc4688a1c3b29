// SPDX-License-Identifier: Apache-2.0
// What an open Terrain holds.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/device_cast.h"
#include "engine/motion.h"
#include "engine/residency.h"
#include "geo/frame.h"
#include "kernel/sweep/sun_cache.h"
#include "raster/photo.h"
#include "shade/shade.h"
#include "shade/shade_cache.h"
#include "stream/cut.h"
#include "stream/photo_pages.h"
#include "stream/resident.h"
#include "terray/terrain.h"

namespace terray {

/// const-shared, but for arena and cache, which are synchronised by themselves, and for resident,
/// ground and storedPhoto where tiles and blocks come and go, which `tiles` guards, and for the
/// caster, which has to be held.
struct Terrain::State {
    SourceInfo facts;
    std::string dataCrsWkt;
    std::unique_ptr<ResidentTerrain> resident;
    std::unique_ptr<FinestGround> ground;
    /// Held by whoever traces a terrain whose tiles come and go, from bringing them to the last
    /// ray.
    mutable std::mutex tiles;
    mutable DeviceCaster caster;
    std::optional<Photo> photo;
    std::unique_ptr<ResidentPhoto> storedPhoto;  ///< instead: of a store, in blocks
    /// What a picture leaves for the next one; `tiles` guards it.
    mutable std::vector<uint32_t> lastPhotoBlocks;
    mutable Motion motion;
    mutable int reduction = 0;      ///< bringTiles(): steps
    BuildStats build;               ///< loadMs: with header and photo
    int threads = 0;                ///< cores that work uses
    mutable ShadeCache shadeCache;  ///< what pictures share
    /// Shadows of the last suns, for as long as the same tiles are drawn.
    std::shared_ptr<SunSweepCache> sunSweeps;
    mutable tbb::task_arena arena;  ///< all parallel work of this terrain runs in here

    /// Maps between the data's CRS, degrees and world; one for each caller (confined).
    Result<GeoFrame> makeGeoFrame() const;
    /// Locks `tiles` where they, or blocks of a photo, come and go.
    std::unique_lock<std::mutex> holdTiles() const {
        return resident->streamer() != nullptr || storedPhoto ? std::unique_lock(tiles)
                                                              : std::unique_lock<std::mutex>();
    }
    DrapedPhoto drapedPhoto() const {
        return storedPhoto ? DrapedPhoto(storedPhoto.get())
                           : DrapedPhoto(photo ? &*photo : nullptr);
    }
    /// No sample has a height.
    bool isEmpty() const;
    /// World rectangle of all posts, metres.
    Vec2 worldMin() const;
    Vec2 worldMax() const;
    Vec2 worldCentre() const { return 0.5 * (worldMin() + worldMax()); }
};

}  // namespace terray
