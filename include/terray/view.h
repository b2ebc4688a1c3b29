// SPDX-License-Identifier: Apache-2.0
// What to look at: the camera in the data's own coordinates.
#pragma once

#include <optional>
#include <string>

#include "terray/export.h"
#include "terray/result.h"

namespace terray {

enum class Projection { Perspective, Panorama, Ortho };

/// X, Y in the data's CRS (degrees longitude, latitude with View::lonLat); Z in metres.
struct Place {
    double x = 0, y = 0;
    std::optional<double> z;   ///< absent: the ground's height
    bool aboveGround = false;  ///< z counts from the ground
};

struct Extent {
    double xMin = 0, yMin = 0, xMax = 0, yMax = 0;
};

/// Without an eye: the whole terrain from the south-south-west, filling the picture.
struct View {
    Projection projection = Projection::Perspective;
    int width = 1920, height = 1080;  ///< pixels, 1..1,000,000 each
    std::optional<Place> eye;
    std::optional<Place> lookAt;       ///< either this or heading and pitch
    std::optional<double> headingDeg;  ///< clockwise from grid north
    std::optional<double> pitchDeg;    ///< down is negative, -90..90
    double rollDeg = 0;                ///< clockwise: right side down
    double fovDeg = 45;                ///< vertical, 0.01..179; perspective only
    std::optional<Extent> extent;      ///< ortho only; data's CRS
    bool lonLat = false;               ///< X, Y of eye, lookAt and extent are degrees
};

/// Reads a camera file: {"eye":[X,Y,Z or "+H"], "look_at":[X,Y(,Z)], "heading":, "pitch":, "roll":,
/// "fov":, "projection":, "size":[W,H], "extent":[...], "lonlat":}. Unknown keys are errors
/// (Input).
TERRAY_API Result<View> readView(const std::string& path, View defaults = {});

}  // namespace terray
