// SPDX-License-Identifier: Apache-2.0
// Tracks: one line of a GPX or KML file, with its times if it has them.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "math/types.h"

namespace terray {

struct Track {
    std::vector<Vec2> lonLats;    ///< degrees (WGS 84); at least two, each unlike the one before
    std::vector<double> seconds;  ///< as many, increasing; empty if the file has none
    int rests = 0;                ///< places left out because they repeated the one before
};

/// The file begins as XML does, so it is no flight file.
bool looksLikeTrack(const std::string& path);

/// GPX: the track, or the route if there is no track. KML: the line string. Errors: Input
/// (unreadable, no line or several, times that run backwards, absurd sizes).
Result<Track> readTrack(const std::string& path);

}  // namespace terray
