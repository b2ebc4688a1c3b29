// SPDX-License-Identifier: Apache-2.0
// A flight through key frames.
#pragma once

#include <memory>
#include <vector>

#include "base/result.h"
#include "flight/path.h"

namespace terray {

struct PathKey {
    double seconds = 0;  ///< increasing; not used at constant speed
    WorldPoint eye;
    std::optional<WorldPoint> target;
    double headingDeg = 0, pitchDeg = 0, rollDeg = 0;  ///< those towards the target if there is one
    double fovDeg = 45;
    std::string name;  ///< for errors: "file:12"
};

struct KeyPathOptions {
    std::optional<double> speed;  ///< metres a second: the keys' times follow from the way
    double clearance = 0;         ///< metres above the ground to be lifted to; 0: never lifted
    Ground ground;                ///< needed for a clearance
    double spacing = 1;           ///< metres between looks at the ground
};

/// Through all keys: the eye on a smooth curve, turns by the shorter way without overshoot; between
/// two keys with targets the target moves smoothly too and is looked at. At least two keys.
/// Errors: Input (keys that constant speed cannot join).
Result<std::unique_ptr<FlightPath>> makeKeyPath(std::vector<PathKey> keys,
                                                const KeyPathOptions& options);

}  // namespace terray
