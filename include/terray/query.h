// SPDX-License-Identifier: Apache-2.0
// Numbers from the same surface that pictures show: heights, rays, lines of sight. Tolerance 0.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "terray/export.h"
#include "terray/result.h"
#include "terray/terrain.h"
#include "terray/view.h"

namespace terray {

struct QueryOptions {
    Surface surface = Surface::Bilinear;
    std::optional<bool> curvature;  ///< default: on when there is a CRS
    double refraction = 0.13;
    bool lonLat = false;  ///< X, Y are degrees
};

/// Heights in metres at places (data's CRS, or degrees); NaN outside and in holes.
TERRAY_API Result<std::vector<double>> queryHeights(const Terrain& terrain,
                                                    std::span<const Place> places,
                                                    const QueryOptions& options = {});

/// A ray: from a place along heading and pitch (degrees; heading from grid north, pitch up
/// positive).
struct QueryRay {
    Place origin;
    double headingDeg = 0, pitchDeg = 0;
};
struct QueryHit {
    bool hit = false;
    double distance = 0;                           ///< metres along the ray
    double x = 0, y = 0, z = 0;                    ///< data's CRS (or degrees), metres
    double normalX = 0, normalY = 0, normalZ = 0;  ///< unit, of the exact surface; world axes
    bool fromBelow = false;
};
TERRAY_API Result<std::vector<QueryHit>> queryRays(const Terrain& terrain,
                                                   std::span<const QueryRay> rays,
                                                   const QueryOptions& options = {});

struct LineOfSight {
    bool visible = false;
    double distance = 0;  ///< metres between the two points
    QueryHit blockedAt;   ///< valid when not visible
};
/// Straight (bent by curvature and refraction) line between each pair of places.
TERRAY_API Result<std::vector<LineOfSight>> queryLinesOfSight(const Terrain& terrain,
                                                              std::span<const Place> from,
                                                              std::span<const Place> to,
                                                              const QueryOptions& options = {});

}  // namespace terray
