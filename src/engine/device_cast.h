// SPDX-License-Identifier: Apache-2.0
// A terrain's device: opened when a picture first asks for it, kept, opened anew when it was lost.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "technique/technique.h"
#include "terray/options.h"

namespace terray {

/// confined to who holds it.
class DeviceCaster {
public:
    /// The technique on the device that `options` name, with the cut's tiles on it; null: on the
    /// CPU, by choice or because the device is lost again and again. Error Resource if it cannot be
    /// had.
    Result<DeviceTechnique*> prepare(const RenderOptions& options, const TerrainCut& cut,
                                     DeviceFigures& figures);
    /// After an Error of the technique: if the device is lost, says that the CPU goes on with this
    /// picture; passes other Errors on.
    Result<void> giveUpIfLost(const Error& error);

    /// Whoever makes a picture on a device holds it until the last ray.
    std::unique_lock<std::mutex> hold(const RenderOptions& options);

private:
    std::mutex mutex_;
    std::unique_ptr<DeviceTechnique> technique_;
    std::string openedFor_;  ///< technique and device
    int losses_ = 0;  ///< of the device; it is opened anew for the next picture, but not for ever
};

/// Hits of a few image tiles, cast at once on a device before they are shaded one by one. confined
/// while it casts, const-shared then.
class TilesAhead {
public:
    /// Hits are cast for each of these places in a pixel.
    TilesAhead(const TerrainCut& cut, const RayFrame& rays, std::vector<Vec2> offsets)
        : cut_(cut), rays_(rays), offsets_(std::move(offsets)) {}

    /// Image tiles that are worth casting at once.
    size_t tilesAtOnce() const;
    Result<void> cast(DeviceTechnique& technique, std::vector<ImageTile> tiles,
                      TraceCounters& counters, DeviceFigures& figures);
    void clear() { tiles_.clear(); }
    /// Empty if they were not cast.
    std::span<const Hit> hitsOf(const ImageTile& tile, Vec2 offset) const;

private:
    const TerrainCut& cut_;
    const RayFrame& rays_;
    std::vector<Vec2> offsets_;
    std::vector<ImageTile> tiles_;
    std::vector<Hit> hits_;  ///< per offset, then per tile
    size_t perOffset_ = 0;
};

}  // namespace terray
