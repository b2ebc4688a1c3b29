// SPDX-License-Identifier: Apache-2.0
// A flight along a line on the ground, such as a GPS track.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "flight/path.h"

namespace terray {

struct TrackPathOptions {
    std::optional<double> speed;     ///< metres a second; else the track's own times count
    double heightAboveGround = 200;  ///< metres, > 0
    double pitchDeg = -10, fovDeg = 45;
    double spacing = 1;  ///< metres between looks at the ground
};

/// The camera looks along the track; way, heading and height are smoothed over a few seconds.
/// `times`: as many as places and never decreasing, or none (a speed is needed then). `name` is for
/// errors. Errors: Input (a track that does not move, or has no terrain below).
Result<std::unique_ptr<FlightPath>> makeTrackPath(const std::vector<Vec2>& places,
                                                  const std::vector<double>& times,
                                                  const Ground& ground,
                                                  const TrackPathOptions& options,
                                                  const std::string& name);

}  // namespace terray
