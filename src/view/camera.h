// SPDX-License-Identifier: Apache-2.0
// The camera: pixels to rays in the world. Perspective, cylindrical panorama, orthographic.
#pragma once

#include <optional>
#include <vector>

#include "base/result.h"
#include "math/types.h"
#include "terray/view.h"

namespace terray {

/// A ray in picture space (world metres, z already exaggerated): unit direction.
struct WorldRay {
    WorldPoint origin;
    Vec3 direction{0, 0, -1};
};

/// A camera placed in picture space: like the world, with every z multiplied by the exaggeration.
/// Pixel (0, 0) is the upper left one; pixel centres are at half-integers. const-shared.
struct Camera {
    Projection projection = Projection::Perspective;
    int width = 0, height = 0;  ///< pixels, >= 1
    WorldPoint eye;  ///< ortho: any point of the picture's centre line, above the terrain
    Vec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};  ///< orthonormal
    double tanHalfFovY = 0.41;                            ///< perspective
    double pitch = 0;      ///< panorama: centre of the strip, radians
    double heading = 0;    ///< radians clockwise from grid north; panorama: of the picture's centre
    Vec2 orthoSize{0, 0};  ///< ortho: metres across the picture and from bottom to top
    bool georeferenced = false;  ///< ortho, straight down, north up

    /// The ray through the picture position (px, py), 0..width x 0..height.
    WorldRay rayThrough(double px, double py) const;
    /// Where a point in picture space lands (x, y pixels; z = distance along `forward`, panorama:
    /// horizontal distance); nullopt behind the camera.
    std::optional<Vec3> project(const WorldPoint& p) const;
    /// Focal length in pixels: f of the error selectors. Panorama: width / 2 pi. Ortho: 0.
    double focalPixels() const;
    /// Largest tangent between the axis (panorama: the horizon) and a ray of the picture: s_max.
    /// Ortho: 0.
    double maxTangent() const;
    /// Ortho: metres a pixel; else 0.
    double metresPerPixel() const;
};

/// What framing needs to know of the terrain, in picture space.
struct SceneBox {
    WorldPoint min, max;
    double gridNorthFromTrueNorth = 0;  ///< meridian convergence at the centre, radians
    /// Exaggerated curvature, 1/m: at a horizontal distance r the ground looks bend * r^2 lower.
    double bend = 0;
    /// Points around what there is to see, for terrains with holes; empty: the box itself.
    std::vector<WorldPoint> outline = {};
};

/// Builds the camera of a View. Eye and target are already in world metres (`resolved` fills
/// heights above ground and CRS coordinates before); without an eye, frames the whole box from the
/// south-south-west, 28 to 35 degrees down, filling about 85 % of the width.
Result<Camera> makeCamera(const View& view, const SceneBox& box);

}  // namespace terray
