// SPDX-License-Identifier: Apache-2.0
// Where the camera is, and where it looks, at any moment of a flight.
#pragma once

#include <functional>
#include <optional>

#include "math/types.h"

namespace terray {

/// The camera of a moment; world metres, true heights.
struct Pose {
    WorldPoint eye;
    std::optional<WorldPoint> target;  ///< looked at, instead of heading and pitch
    double headingDeg = 0;             ///< clockwise from grid north, 0..360
    double pitchDeg = 0, rollDeg = 0;
    double fovDeg = 45;
};

/// Height of the ground at a world place; nothing outside and in holes.
using Ground = std::function<std::optional<double>(Vec2)>;

/// const-shared.
class FlightPath {
public:
    virtual ~FlightPath() = default;
    /// Seconds; begin() < end().
    virtual double begin() const = 0;
    virtual double end() const = 0;
    /// Moments before the beginning and after the end count as these.
    virtual Pose at(double seconds) const = 0;
};

/// In 0..360.
double normalHeadingDeg(double deg);
/// Each angle plus full turns, so that it is at most half a turn from the one before.
double nearestTurnDeg(double deg, double before);

}  // namespace terray
