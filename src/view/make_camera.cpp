// SPDX-License-Identifier: Apache-2.0
// From a View (degrees, options) to a Camera: checks, directions, placement.
#include <cmath>
#include <string_view>

#include "base/assert.h"
#include "view/camera.h"
#include "view/framing.h"

namespace terray {
namespace {

constexpr double kFramingHeadingDeg = 22.5;  // from the south-south-west
constexpr double kFramingPitchDeg = -28;
constexpr double kSteepestFramingPitchDeg = -35;
constexpr int kMaxSize = 1'000'000;
constexpr double kMaxPanoramaPitchDeg = 89;

struct Direction {
    double headingDeg = 0, pitchDeg = 0;
};

struct SinCos {
    double sin = 0, cos = 1;
};

/// Exact at multiples of 90 degrees, so that "straight down, north up" is exactly that.
SinCos sinCosDeg(double deg) {
    const double turn = std::fmod(deg, 360.0);
    const double quarters = turn / 90.0;
    if (quarters == std::floor(quarters)) {
        constexpr SinCos kTable[4] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
        return kTable[(static_cast<int>(quarters) + 4) % 4];
    }
    return {std::sin(radFromDeg(turn)), std::cos(radFromDeg(turn))};
}

void setAxes(Camera& camera, const Direction& direction, double rollDeg) {
    const SinCos h = sinCosDeg(direction.headingDeg);
    const SinCos p = sinCosDeg(direction.pitchDeg);
    const SinCos r = sinCosDeg(rollDeg);
    const Vec3 level{h.cos, -h.sin, 0};
    const Vec3 upright{-h.sin * p.sin, -h.cos * p.sin, p.cos};
    camera.forward = {h.sin * p.cos, h.cos * p.cos, p.sin};
    camera.right = r.cos * level - r.sin * upright;
    camera.up = r.cos * upright + r.sin * level;
    camera.heading = radFromDeg(direction.headingDeg);
    camera.pitch = radFromDeg(direction.pitchDeg);
}

bool isFinite(const std::optional<Place>& place) {
    return !place || (std::isfinite(place->x) && std::isfinite(place->y) &&
                      std::isfinite(place->z.value_or(0)));
}

bool isFinite(const std::optional<double>& value) { return std::isfinite(value.value_or(0)); }

Result<void> checkNumbers(const View& view) {
    const auto notFinite = [](std::string_view option) {
        return makeError(ErrorCode::Usage, "{} is not a finite number; give one", option);
    };
    if (!isFinite(view.eye)) return notFinite("--eye");
    if (!isFinite(view.lookAt)) return notFinite("--look-at");
    if (!isFinite(view.headingDeg)) return notFinite("--heading");
    if (!isFinite(view.pitchDeg)) return notFinite("--pitch");
    if (!std::isfinite(view.rollDeg)) return notFinite("--roll");
    if (!std::isfinite(view.fovDeg)) return notFinite("--fov");
    if (view.extent && !(std::isfinite(view.extent->xMin) && std::isfinite(view.extent->yMin) &&
                         std::isfinite(view.extent->xMax) && std::isfinite(view.extent->yMax))) {
        return notFinite("--extent");
    }
    return {};
}

Result<void> checkRanges(const View& view) {
    if (view.width < 1 || view.width > kMaxSize || view.height < 1 || view.height > kMaxSize) {
        return makeError(ErrorCode::Usage,
                         "--size {}x{} is out of range; give 1 to 1000000 pixels each way",
                         view.width, view.height);
    }
    if (view.pitchDeg && std::abs(*view.pitchDeg) > 90) {
        return makeError(ErrorCode::Usage,
                         "--pitch {} is out of range; give -90 (straight down) to 90",
                         *view.pitchDeg);
    }
    if (view.fovDeg < 0.01 || view.fovDeg > 179) {
        return makeError(ErrorCode::Usage, "--fov {} is out of range; give 0.01 to 179 degrees",
                         view.fovDeg);
    }
    if (view.extent &&
        !(view.extent->xMin < view.extent->xMax && view.extent->yMin < view.extent->yMax)) {
        return makeError(ErrorCode::Usage,
                         "--extent {},{},{},{} is empty; give XMIN,YMIN,XMAX,YMAX with XMIN < XMAX "
                         "and YMIN < YMAX",
                         view.extent->xMin, view.extent->yMin, view.extent->xMax,
                         view.extent->yMax);
    }
    return {};
}

/// Options that the projection has no use for are refused rather than ignored.
Result<void> checkCombination(const View& view) {
    const bool perspective = view.projection == Projection::Perspective;
    const bool ortho = view.projection == Projection::Ortho;
    const std::string_view name = ortho ? "ortho" : "panorama";
    if (!perspective && view.fovDeg != View{}.fovDeg) {
        return makeError(ErrorCode::Usage, "--fov does not go with --projection {}; leave it out",
                         name);
    }
    if (view.projection == Projection::Panorama && view.rollDeg != 0) {
        return makeError(ErrorCode::Usage,
                         "--roll does not go with --projection panorama; leave it out");
    }
    if (!ortho && view.extent) {
        return makeError(ErrorCode::Usage, "--extent is for --projection ortho; leave it out");
    }
    if (ortho && (view.eye || view.lookAt)) {
        return makeError(ErrorCode::Usage,
                         "--eye and --look-at do not go with --projection ortho; give --extent, "
                         "--heading and --pitch");
    }
    if (view.lookAt && (view.headingDeg || view.pitchDeg)) {
        return makeError(ErrorCode::Usage,
                         "--look-at does not go with --heading and --pitch; give one or the other");
    }
    if (view.lookAt && !view.eye) {
        return makeError(ErrorCode::Usage, "--look-at needs a place to look from; add --eye");
    }
    if (view.projection == Projection::Panorama && !view.eye) {
        return makeError(ErrorCode::Usage,
                         "--projection panorama needs a place to stand; add --eye X,Y,+H");
    }
    return {};
}

WorldPoint worldPoint(const Place& place) {
    TERRAY_ASSERT(place.z && !place.aboveGround);
    return {place.x, place.y, place.z.value_or(0)};
}

/// Heading and pitch from the eye to a target, which looks bend * r^2 lower; straight up or down
/// keeps north up.
Direction directionTo(const WorldPoint& eye, const WorldPoint& target, double bend) {
    const Vec3 d = target - eye;
    const double horizontal = std::hypot(d.x, d.y);
    const double rise = d.z - bend * horizontal * horizontal;
    if (horizontal <= 1e-12 * std::abs(rise)) return {0, rise > 0 ? 90.0 : -90.0};
    return {degFromRad(std::atan2(d.x, d.y)), degFromRad(std::atan2(rise, horizontal))};
}

Result<Direction> directionFromEye(const View& view, const WorldPoint& eye, const SceneBox& box) {
    const WorldPoint centre = WorldPoint::fromVec(0.5 * (box.min.vec() + box.max.vec()));
    if (view.lookAt) {
        const WorldPoint target = worldPoint(*view.lookAt);
        if (target.vec() == eye.vec()) {
            return makeError(ErrorCode::Usage,
                             "--eye and --look-at are the same place; move one of them");
        }
        return directionTo(eye, target, box.bend);
    }
    if (view.headingDeg || view.projection == Projection::Panorama) {
        return Direction{view.headingDeg.value_or(0), view.pitchDeg.value_or(0)};
    }
    if (centre.vec() == eye.vec()) return Direction{0, view.pitchDeg.value_or(0)};
    Direction towardsCentre = directionTo(eye, centre, box.bend);
    if (view.pitchDeg) towardsCentre.pitchDeg = *view.pitchDeg;
    return towardsCentre;
}

Result<Camera> makePanorama(Camera camera, Direction direction) {
    if (std::abs(direction.pitchDeg) > kMaxPanoramaPitchDeg) {
        return makeError(ErrorCode::Usage,
                         "a panorama cannot be centred {:.4g} degrees above the horizon; give "
                         "--pitch -{} to {}",
                         direction.pitchDeg, kMaxPanoramaPitchDeg, kMaxPanoramaPitchDeg);
    }
    setAxes(camera, {direction.headingDeg, 0}, 0);
    camera.pitch = radFromDeg(direction.pitchDeg);
    return camera;
}

Camera makeOrtho(Camera camera, const View& view, const SceneBox& box) {
    const Direction direction{view.headingDeg.value_or(0), view.pitchDeg.value_or(-90)};
    setAxes(camera, direction, view.rollDeg);
    SceneBox seen = box;
    if (view.extent) {
        seen.min = {view.extent->xMin, view.extent->yMin, box.min.z};
        seen.max = {view.extent->xMax, view.extent->yMax, box.max.z};
    }
    frameOrtho(camera, seen);
    camera.georeferenced = camera.forward == Vec3{0, 0, -1} && camera.up == Vec3{0, 1, 0};
    return camera;
}

/// Wide flat terrains are looked at more steeply, so that they fill more of the height.
void frameWhole(Camera& camera, const View& view, const SceneBox& box) {
    constexpr double kStepDeg = 1, kWellFilled = 0.6;
    const double heading = view.headingDeg.value_or(kFramingHeadingDeg);
    double pitch = view.pitchDeg.value_or(kFramingPitchDeg);
    const double steepest = view.pitchDeg.value_or(kSteepestFramingPitchDeg);
    for (;; pitch -= kStepDeg) {
        setAxes(camera, {heading, pitch}, view.rollDeg);
        if (frameBox(camera, box) >= kWellFilled || pitch <= steepest) return;
    }
}

}  // namespace

Result<Camera> makeCamera(const View& view, const SceneBox& box) {
    TERRAY_TRY(checkNumbers(view));
    TERRAY_TRY(checkRanges(view));
    TERRAY_TRY(checkCombination(view));
    Camera camera;
    camera.projection = view.projection;
    camera.width = view.width;
    camera.height = view.height;
    camera.tanHalfFovY = std::tan(0.5 * radFromDeg(view.fovDeg));
    if (view.projection == Projection::Ortho) return makeOrtho(camera, view, box);
    if (!view.eye) {
        frameWhole(camera, view, box);
        return camera;
    }
    camera.eye = worldPoint(*view.eye);
    const Result<Direction> direction = directionFromEye(view, camera.eye, box);
    if (!direction) return direction.error();
    if (view.projection == Projection::Panorama) return makePanorama(camera, *direction);
    setAxes(camera, *direction, view.rollDeg);
    return camera;
}

}  // namespace terray
