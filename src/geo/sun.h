// SPDX-License-Identifier: Apache-2.0
// Where the sun is for a moment and a place: a published low-precision algorithm good to 0.01
// degree from 1950 to 2050 (named, with its source, in sun.cpp), without refraction.
#pragma once

#include <string>

#include "base/result.h"

namespace terray {

struct SunPosition {
    double azimuthDeg = 0;    ///< clockwise from true north, 0..360
    double elevationDeg = 0;  ///< above the horizon, geometric
};

/// Julian day (UT) of an ISO 8601 moment: "2024-06-21T12:00:00Z", "...+02:00", "2024-06-21 12:00"
/// (UTC). Anything else is a Usage error that names --time.
struct Moment {
    double julianDay = 0;
    bool hadOffset = false;  ///< the text named Z or an offset
    std::string utcText;     ///< "2024-06-21T10:00:00Z"
};
Result<Moment> parseIsoTime(const std::string& text);

SunPosition sunPosition(double julianDay, double longitudeDeg, double latitudeDeg);

}  // namespace terray
