// SPDX-License-Identifier: Apache-2.0
// From what users write (data's CRS or degrees, heights above ground) to world metres.
#pragma once

#include <optional>

#include "engine/terrain_state.h"
#include "terray/view.h"

namespace terray {

/// confined (holds a GeoFrame). Where tiles come and go its user holds them.
class PlaceResolver {
public:
    static Result<PlaceResolver> make(const Terrain::State& state, bool lonLat, Surface surface);

    /// World metres, true heights. `what` names the place in errors ("--eye", "point 3").
    Result<WorldPoint> resolve(const Place& place, const std::string& what) const;
    Result<Vec2> resolveHorizontal(Vec2 xy, const std::string& what) const;
    /// Back to what the user writes.
    Result<Vec2> dataFromWorld(Vec2 world) const;
    /// Height of the finest surface; nullopt outside and in holes.
    std::optional<double> groundHeight(Vec2 world) const;

    const GeoFrame& frame() const { return frame_; }

private:
    PlaceResolver(const Terrain::State& state, GeoFrame frame, bool lonLat, Surface surface)
        : state_(&state), frame_(std::move(frame)), lonLat_(lonLat), surface_(surface) {}

    const Terrain::State* state_;
    GeoFrame frame_;
    bool lonLat_;
    Surface surface_;
};

/// The view in picture space: places in world metres with z times the exaggeration, and an
/// eye for panoramas that have none.
Result<View> resolveView(const Terrain::State& state, const PlaceResolver& places, const View& view,
                         double exaggeration);

}  // namespace terray
