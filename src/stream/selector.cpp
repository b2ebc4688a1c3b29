// SPDX-License-Identifier: Apache-2.0
// The error selector: image shifts of height, coverage and shadow errors, never underestimated.
#include "stream/selector.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terray {
namespace {

constexpr double kMorphShare = 1.5;        ///< the tolerance's share that is left to morphs
constexpr double kSunDiameter = 0.0093;    ///< radians
constexpr double kPenumbraShare = 0.5;     ///< of the penumbra's width that an edge may move
constexpr double kLeastElevation = 0.005;  ///< radians; below it the sun casts no shadow to see

double orthoPixelsPerMetre(const Camera& camera) {
    if (camera.projection != Projection::Ortho) return 0;
    return std::max(camera.width / camera.orthoSize.x, camera.height / camera.orthoSize.y);
}

}  // namespace

Selector::Selector(const Affine2& worldFromLattice, double minZ, const Camera& camera,
                   const CutOptions& options)
    : worldFromLattice_(worldFromLattice),
      g11_(glm::dot(worldFromLattice.column, worldFromLattice.column)),
      g12_(glm::dot(worldFromLattice.column, worldFromLattice.row)),
      g22_(glm::dot(worldFromLattice.row, worldFromLattice.row)),
      eye_(worldFromLattice.latticeFromWorld({camera.eye.x, camera.eye.y})),
      eyeZ_(camera.eye.z),
      minZ_(minZ),
      focal_(camera.focalPixels() * (1 + camera.maxTangent() * camera.maxTangent())),
      pixelsPerMetre_(orthoPixelsPerMetre(camera)),
      allowed_(options.tolerancePx / kMorphShare),
      allowedShadow_(options.tolerancePx),
      exaggeration_(options.exaggeration),
      bend_(options.bend),
      bilinear_(options.surface == kSurfaceBilinear) {
    if (!options.sun) return;
    const Vec3 sun = glm::normalize(options.sun->towardsSun);
    const double cosine = std::hypot(sun.x, sun.y);
    if (sun.z < kLeastElevation || cosine < 1e-9) return;
    shadows_ = Shadows{Vec2{-sun.x, -sun.y} / cosine, cosine / sun.z,
                       kPenumbraShare * kSunDiameter / (cosine * cosine)};
}

/// Largest image shift of a displacement at a distance from the eye.
double Selector::pixels(double metres, double distance) const {
    if (pixelsPerMetre_ > 0) return metres * pixelsPerMetre_;
    if (metres <= 0) return 0;
    return distance > 0 ? focal_ * metres / distance : std::numeric_limits<double>::infinity();
}

double Selector::errorOf(const BlockBounds& block) const {
    // Nearest posts: each surface strays from its bilinear one by at most the range of a cell.
    return static_cast<double>(block.errorToFinest) +
           (bilinear_ ? 0.0 : 2 * static_cast<double>(block.cellRange));
}

Selector::Heights Selector::trueHeights(const BlockBounds& block) const {
    const double error = errorOf(block);
    return {static_cast<double>(block.minZ) - error, static_cast<double>(block.maxZ) + error};
}

Selector::Heights Selector::pictureHeights(Heights heights, const LatticeBox& box) const {
    const double near = bend_ * distance2(box, eye_), far = bend_ * farthest2(box);
    return {exaggeration_ * (heights.low - std::max(near, far)),
            exaggeration_ * (heights.high - std::min(near, far))};
}

bool Selector::servesInView(const BlockBounds& block, const LatticeBox& box) const {
    return viewShift(block, box) <= allowed_;
}

/// Pixels by which what the block draws may stand elsewhere than mip 0.
double Selector::viewShift(const BlockBounds& block, const LatticeBox& box) const {
    const double error = errorOf(block);
    // A rim that stands elsewhere on the ground stands higher or lower too.
    const double rim = static_cast<double>(block.coverageError) *
                       std::hypot(1.0, exaggeration_ * static_cast<double>(block.maxSlope));
    const double shift = std::max(exaggeration_ * error, rim);
    if (shift <= 0) return 0;
    double distance = 0;
    if (pixelsPerMetre_ <= 0) {
        const double ground2 = distance2(box, eye_);
        double above = 0;
        if (block.minZ <= block.maxZ) {
            const Heights heights = pictureHeights(trueHeights(block), box);
            above = std::max({0.0, heights.low - eyeZ_, eyeZ_ - heights.high});
        }
        distance = std::sqrt(ground2 + above * above);
    }
    return pixels(shift, distance);
}

/// How far from its foot a shadow's edge may show an error; beyond a length that grows with the
/// error the penumbra hides it.
double Selector::shadowLength(double error, double top) const {
    return std::min((top - minZ_) * shadows_->cotangent, error / shadows_->penumbra);
}

/// An error e moves the edge of a shadow by e / tan(elevation) on level ground, wherever between
/// the block and the end of its longest shadow the edge falls.
bool Selector::servesInShadows(const BlockBounds& block, const LatticeBox& box) const {
    const double error = errorOf(block);
    if (!shadows_ || error <= 0 || block.minZ > block.maxZ) return true;
    const double top = static_cast<double>(block.maxZ) + error;
    const double length = shadowLength(error, top);
    const double shift = error * shadows_->cotangent;
    if (pixelsPerMetre_ > 0) return shift * pixelsPerMetre_ <= allowedShadow_;
    const double above = std::max(0.0, eyeZ_ - exaggeration_ * top);
    const double nearest = std::max(0.0, std::sqrt(distance2(box, eye_)) - length);
    if (pixels(shift, std::hypot(nearest, above)) <= allowedShadow_) return true;
    const double ground2 = distanceToSweep2(box, length * shadows_->away);
    return pixels(shift, std::sqrt(ground2 + above * above)) <= allowedShadow_;
}

Selector::Heights Selector::shadowed(const BlockBounds& block, LatticeBox& box) const {
    const Heights heights = trueHeights(block);
    if (!shadows_ || block.minZ > block.maxZ) return {1, 0};
    const double length = shadowLength(errorOf(block), heights.high);
    const LatticePoint step = worldFromLattice_.latticeDirection(length * shadows_->away);
    box.i0 += std::min(step.i, 0.0);
    box.i1 += std::max(step.i, 0.0);
    box.j0 += std::min(step.j, 0.0);
    box.j1 += std::max(step.j, 0.0);
    return {minZ_, heights.high};
}

/// Squared metres from a place to a lattice rectangle (a parallelogram on the ground).
double Selector::distance2(const LatticeBox& box, LatticePoint from) const {
    const bool insideI = from.i >= box.i0 && from.i <= box.i1;
    const bool insideJ = from.j >= box.j0 && from.j <= box.j1;
    if (insideI && insideJ) return 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (const double i : {box.i0, box.i1}) {
        const double di = i - from.i;
        const double j = std::clamp(from.j - g12_ / g22_ * di, box.j0, box.j1);
        nearest = std::min(nearest, length2(di, j - from.j));
    }
    for (const double j : {box.j0, box.j1}) {
        const double dj = j - from.j;
        const double i = std::clamp(from.i - g12_ / g11_ * dj, box.i0, box.i1);
        nearest = std::min(nearest, length2(i - from.i, dj));
    }
    return nearest * (1 - 1e-12);
}

double Selector::farthest2(const LatticeBox& box) const {
    double farthest = 0;
    for (const double i : {box.i0, box.i1}) {
        for (const double j : {box.j0, box.j1}) {
            farthest = std::max(farthest, length2(i - eye_.i, j - eye_.j));
        }
    }
    return farthest;
}

/// Squared metres from the eye to the rectangle swept along a world direction: the same as from the
/// rectangle to the segment [eye, eye - sweep].
double Selector::distanceToSweep2(const LatticeBox& box, Vec2 sweep) const {
    const LatticePoint step = worldFromLattice_.latticeDirection(-sweep);
    double enter = 0, leave = 1;
    const auto clip = [&](double from, double by, double low, double high) {
        if (by == 0) {
            if (from < low || from > high) leave = -1;
            return;
        }
        const double a = (low - from) / by, b = (high - from) / by;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    };
    clip(eye_.i, step.i, box.i0, box.i1);
    clip(eye_.j, step.j, box.j0, box.j1);
    if (enter <= leave) return 0;
    double nearest =
        std::min(distance2(box, eye_), distance2(box, {eye_.i + step.i, eye_.j + step.j}));
    const double length = std::max(length2(step.i, step.j), 1e-300);
    for (const double i : {box.i0, box.i1}) {
        for (const double j : {box.j0, box.j1}) {
            const double di = i - eye_.i, dj = j - eye_.j;
            const double along =
                di * step.i * g11_ + (di * step.j + dj * step.i) * g12_ + dj * step.j * g22_;
            const double t = std::clamp(along / length, 0.0, 1.0);
            nearest = std::min(nearest, length2(di - t * step.i, dj - t * step.j));
        }
    }
    return nearest * (1 - 1e-12);
}

}  // namespace terray
