// SPDX-License-Identifier: Apache-2.0
// Everything that is settled once for a picture, before the first ray.
#pragma once

#include <memory>

#include "engine/device_cast.h"
#include "engine/frame_photo.h"
#include "engine/places.h"
#include "engine/terrain_state.h"
#include "image/writer.h"
#include "shade/annotate.h"
#include "shade/shade.h"
#include "stream/cut.h"
#include "technique/technique.h"
#include "terray/options.h"
#include "view/ray_frame.h"

namespace terray {

/// const-shared once made. Not movable: the shader borrows cut and rays.
struct Frame {
    Frame(const Camera& camera, const Affine2& worldFromLattice, double exaggeration, double bend)
        : rays(camera, worldFromLattice, exaggeration, bend) {}
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

    RayFrame rays;
    FrameCut cut;
    std::unique_ptr<Technique> technique;
    DeviceCaster* caster = nullptr;       ///< the terrain's, held by who makes the picture
    DeviceTechnique* onDevice = nullptr;  ///< null: on the CPU
    std::string device = "cpu";           ///< in words
    DeviceFigures deviceFigures;          ///< of bringing tiles
    std::unique_ptr<Shader> shader;
    std::unique_ptr<FramePhoto> photo;         ///< null if it shows none that comes in blocks
    std::unique_ptr<Annotations> annotations;  ///< null if there are none
    RenderOptions options;
    double tolerancePx = 0;  ///< of the cut
    TileFigures tiles;
    double setupMs = 0;

    const Camera& camera() const { return rays.camera(); }
    /// Alpha is less than 1 somewhere.
    bool hasAlpha() const { return options.background == "transparent"; }
    /// For ortho pictures straight down with north up.
    std::optional<GeoReference> georeference(const TerrainInfo& info) const;
};

/// A view as the terrain's world has it.
struct PlacedView {
    PlaceResolver places;
    View resolved;    ///< picture space
    double bend = 0;  ///< c of the bent rays: (1 - k) / 2R, or 0
    Camera camera;
};
Result<PlacedView> placeView(const Terrain::State& state, const View& view,
                             const RenderOptions& options);

/// Where tiles come and go, they are held (Terrain::State) as long as the frame is used.
Result<std::unique_ptr<Frame>> makeFrame(const Terrain::State& state, const View& view,
                                         const RenderOptions& options);

}  // namespace terray
