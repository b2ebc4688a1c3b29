// SPDX-License-Identifier: Apache-2.0
// The text format of flights: one key frame a line (docs/flights.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terray/view.h"

namespace terray {

/// One key frame as written.
struct FlightKey {
    int line = 0;
    double seconds = 0;  ///< 0 where a speed makes times needless and none is given
    Place eye;           ///< z is there
    std::optional<Place> target;
    double headingDeg = 0, pitchDeg = 0, rollDeg = 0;
    std::optional<double> fovDeg;  ///< as the last `fov` above says
};

struct FlightFile {
    std::string path;
    std::vector<FlightKey> keys;  ///< at least two
    std::string crs;              ///< of X, Y; empty: the data's
    bool lonLat = false;
    std::optional<double> speed;  ///< metres a second
    double clearance = 0;         ///< metres
};

/// Error Input: one sentence that begins with 'path:line'. `speedGiven`: keys need no times.
Result<FlightFile> parseFlight(const std::string& text, const std::string& path,
                               bool speedGiven = false);

/// The text of a flight file; error Input for what cannot be one (unreadable, too large, binary).
Result<std::string> readFlightText(const std::string& path);

}  // namespace terray
