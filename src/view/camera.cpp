// SPDX-License-Identifier: Apache-2.0
// Pixels to rays and back, for the three projections.
#include "view/camera.h"

#include <algorithm>
#include <cmath>

namespace terray {
namespace {

double halfWidth(const Camera& camera) { return 0.5 * camera.width; }
double halfHeight(const Camera& camera) { return 0.5 * camera.height; }

WorldRay perspectiveRay(const Camera& camera, double px, double py) {
    const double f = camera.focalPixels();
    const double x = (px - halfWidth(camera)) / f;
    const double y = (halfHeight(camera) - py) / f;
    return {camera.eye, glm::normalize(camera.forward + x * camera.right + y * camera.up)};
}

WorldRay panoramaRay(const Camera& camera, double px, double py) {
    const double radius = camera.focalPixels();
    const double azimuth = camera.heading + (px - halfWidth(camera)) / radius;
    const double tangent = std::tan(camera.pitch) + (halfHeight(camera) - py) / radius;
    return {camera.eye, glm::normalize(Vec3{std::sin(azimuth), std::cos(azimuth), tangent})};
}

WorldRay orthoRay(const Camera& camera, double px, double py) {
    const double x = (px - halfWidth(camera)) / camera.width * camera.orthoSize.x;
    const double y = (halfHeight(camera) - py) / camera.height * camera.orthoSize.y;
    return {camera.eye + (x * camera.right + y * camera.up), camera.forward};
}

std::optional<Vec3> projectOnCylinder(const Camera& camera, const Vec3& fromEye) {
    const double distance = std::hypot(fromEye.x, fromEye.y);
    if (!(distance > 0)) return std::nullopt;
    const double radius = camera.focalPixels();
    const double azimuth = std::atan2(fromEye.x, fromEye.y);
    const double offset = std::remainder(azimuth - camera.heading, 2 * kPi);
    const double tangent = fromEye.z / distance - std::tan(camera.pitch);
    return Vec3{halfWidth(camera) + offset * radius, halfHeight(camera) - tangent * radius,
                distance};
}

}  // namespace

WorldRay Camera::rayThrough(double px, double py) const {
    switch (projection) {
        case Projection::Perspective: return perspectiveRay(*this, px, py);
        case Projection::Panorama: return panoramaRay(*this, px, py);
        case Projection::Ortho: break;
    }
    return orthoRay(*this, px, py);
}

std::optional<Vec3> Camera::project(const WorldPoint& p) const {
    const Vec3 fromEye = p - eye;
    if (projection == Projection::Panorama) return projectOnCylinder(*this, fromEye);
    const double x = glm::dot(fromEye, right);
    const double y = glm::dot(fromEye, up);
    const double depth = glm::dot(fromEye, forward);
    if (projection == Projection::Ortho) {
        return Vec3{halfWidth(*this) + x / orthoSize.x * width,
                    halfHeight(*this) - y / orthoSize.y * height, depth};
    }
    if (!(depth > 0)) return std::nullopt;
    const double scale = focalPixels() / depth;
    return Vec3{halfWidth(*this) + x * scale, halfHeight(*this) - y * scale, depth};
}

double Camera::focalPixels() const {
    switch (projection) {
        case Projection::Perspective: return halfHeight(*this) / tanHalfFovY;
        case Projection::Panorama: return width / (2 * kPi);
        case Projection::Ortho: break;
    }
    return 0;
}

double Camera::maxTangent() const {
    switch (projection) {
        case Projection::Perspective: return tanHalfFovY * std::hypot(1.0, double(width) / height);
        case Projection::Panorama:
            return std::abs(std::tan(pitch)) + halfHeight(*this) / focalPixels();
        case Projection::Ortho: break;
    }
    return 0;
}

double Camera::metresPerPixel() const {
    return projection == Projection::Ortho ? orthoSize.x / width : 0;
}

}  // namespace terray
