// SPDX-License-Identifier: Apache-2.0
// Fits cameras to boxes. With the axes fixed, the picture's half-width shrinks monotonically with
// the distance, and each edge moves monotonically with the shift: bisections find both.
#include "view/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace terray {
namespace {

constexpr double kWidthShare = 0.85;   // of the picture's width
constexpr double kHeightShare = 0.90;  // at most, of the picture's height
constexpr int kBisections = 44;        // of a range of about 30: beyond a millionth
constexpr double kTopShare = 0.245;    // the box's top is not further down than this

using Points = std::vector<Vec3>;  // camera axes: right, up, forward; in box radii

Vec3 centreOf(const SceneBox& box) { return 0.5 * (box.min.vec() + box.max.vec()); }

/// The outline; or the box's corners, edge middles and face centres: over a curved earth the
/// middles stand out.
std::vector<Vec3> outlineOf(const SceneBox& box) {
    std::vector<Vec3> points;
    for (const WorldPoint& p : box.outline) points.push_back(p.vec());
    if (!points.empty()) return points;
    const Vec3 half = 0.5 * (box.max - box.min);
    for (int z = -1; z <= 1; z += 2)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) points.push_back(centreOf(box) + half * Vec3{x, y, z});
    return points;
}

/// The outline relative to the box's centre, each point lowered by the curvature seen from `eye`.
Points pointsInAxes(const Camera& camera, const SceneBox& box, const std::vector<Vec3>& outline,
                    const Vec3& eye, double radius) {
    const Vec3 centre = centreOf(box);
    Points points;
    for (const Vec3& place : outline) {
        const Vec3 fromEye = place - eye;
        Vec3 p = place - centre;
        p.z -= box.bend * (fromEye.x * fromEye.x + fromEye.y * fromEye.y);
        points.push_back(
            Vec3{glm::dot(p, camera.right), glm::dot(p, camera.up), glm::dot(p, camera.forward)} /
            radius);
    }
    return points;
}

struct Range {
    double min = std::numeric_limits<double>::infinity();
    double max = -std::numeric_limits<double>::infinity();
    double size() const { return max - min; }
    void add(double value) {
        min = std::min(min, value);
        max = std::max(max, value);
    }
};

/// Tangents of the points along axis 0 or 1, seen from `shift` along it and `distance` behind.
Range tangents(const Points& points, int axis, double shift, double distance) {
    Range range;
    for (const Vec3& p : points) range.add((p[axis] - shift) / (p.z + distance));
    return range;
}

/// Root of a function that falls from positive to not positive between low and high.
template <class F>
double bisect(double low, double high, F&& f) {
    for (int k = 0; k < kBisections; ++k) {
        const double middle = 0.5 * (low + high);
        (f(middle) > 0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// The shift that puts the points evenly on both sides of the axis.
double centredShift(const Points& points, int axis, double distance) {
    return bisect(-4.0, 4.0, [&](double shift) {
        const Range range = tangents(points, axis, shift, distance);
        return range.max + range.min;
    });
}

struct Fit {
    double x = 0, y = 0, distance = 0;  // box radii
    double height = 0;                  // share of the picture's height
};

/// `tanX`, `tanY`: half-width and half-height of the picture at distance 1.
Fit fitPoints(const Points& points, double tanX, double tanY) {
    double nearest = 0;
    for (const Vec3& p : points) nearest = std::max(nearest, -p.z);
    Fit fit;
    const double excess = bisect(std::log(1e-3), std::log(1e9), [&](double logExcess) {
        const double d = nearest + std::exp(logExcess);
        const Range x = tangents(points, 0, centredShift(points, 0, d), d);
        const Range y = tangents(points, 1, centredShift(points, 1, d), d);
        return std::max(x.size() / (2 * tanX * kWidthShare), y.size() / (2 * tanY * kHeightShare)) -
               1;
    });
    fit.distance = nearest + std::exp(excess);
    fit.x = centredShift(points, 0, fit.distance);
    fit.y = centredShift(points, 1, fit.distance);
    const double lowestTop = (1 - 2 * kTopShare) * tanY;
    if (tangents(points, 1, fit.y, fit.distance).max < lowestTop) {
        const double farBelow = fit.y - 4 * lowestTop * fit.distance - 4;
        fit.y = bisect(farBelow, fit.y, [&](double shift) {
            return tangents(points, 1, shift, fit.distance).max - lowestTop;
        });
    }
    fit.height = tangents(points, 1, fit.y, fit.distance).size() / (2 * tanY);
    return fit;
}

}  // namespace

double frameBox(Camera& camera, const SceneBox& box) {
    const Vec3 centre = centreOf(box);
    const double radius = std::max(0.5 * glm::length(box.max - box.min), 1e-6);
    const double tanX = camera.tanHalfFovY * camera.width / camera.height;
    Vec3 eye = centre;
    const std::vector<Vec3> outline = outlineOf(box);
    double height = 0;
    const int rounds = box.bend > 0 ? 6 : 1;
    for (int round = 0; round < rounds; ++round) {
        const Points points = pointsInAxes(camera, box, outline, eye, radius);
        const Fit fit = fitPoints(points, tanX, camera.tanHalfFovY);
        height = fit.height;
        eye = centre +
              radius * (fit.x * camera.right + fit.y * camera.up - fit.distance * camera.forward);
    }
    camera.eye = WorldPoint::fromVec(eye);
    return height;
}

void frameOrtho(Camera& camera, const SceneBox& box) {
    Range x, y, depth;
    const Vec3 half = 0.5 * (box.max - box.min);
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p = half * Vec3{corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1};
        x.add(glm::dot(p, camera.right));
        y.add(glm::dot(p, camera.up));
        depth.add(glm::dot(p, camera.forward));
    }
    const double perPixelX = x.size() / camera.width;
    const double perPixelY = y.size() / camera.height;
    camera.orthoSize = {x.size(), y.size()};
    constexpr double kSame = 1e-12;  // relative: keeps an extent of the picture's shape as given
    if (perPixelX > perPixelY * (1 + kSame)) camera.orthoSize.y = perPixelX * camera.height;
    if (perPixelY > perPixelX * (1 + kSame)) camera.orthoSize.x = perPixelY * camera.width;
    const double clearance = depth.size() + 0.01 * std::max(x.size(), y.size()) + 1;
    camera.eye = WorldPoint::fromVec(centreOf(box) + (depth.min - clearance) * camera.forward);
}

}  // namespace terray
