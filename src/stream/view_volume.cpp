// SPDX-License-Identifier: Apache-2.0
// Planes of the picture's edges, and footprints by the least distance.
#include "stream/view_volume.h"

#include <algorithm>
#include <cmath>

namespace terray {
namespace {

constexpr int kUnseen = 1000;

}  // namespace

ViewVolume::ViewVolume(const Selector& selector, const Affine2& worldFromLattice,
                       const Camera& camera, const CutOptions& options)
    : selector_(selector),
      map_(worldFromLattice),
      eye_(camera.eye),
      cellMetres_(std::max(map_.columnLength(), map_.rowLength())),
      pixelAngle_(0),
      sampleMetres_(camera.metresPerPixel() * options.sampleShare) {
    const double across = camera.maxTangent();
    if (camera.projection != Projection::Ortho)
        pixelAngle_ = options.sampleShare / (camera.focalPixels() * (1 + across * across));
    if (camera.projection == Projection::Panorama) return;
    const double aspect = static_cast<double>(camera.width) / camera.height;
    const bool isOrtho = camera.projection == Projection::Ortho;
    // A pixel more on each side, for filters and rounding.
    const double moreX = 1 + 2.0 / camera.width, moreY = 1 + 2.0 / camera.height;
    const double halfX = moreX * (isOrtho ? 0.5 * camera.orthoSize.x : camera.tanHalfFovY * aspect);
    const double halfY = moreY * (isOrtho ? 0.5 * camera.orthoSize.y : camera.tanHalfFovY);
    const auto add = [&](const Vec3& side, double half) {
        if (isOrtho)
            planes_.push_back({side, half});
        else
            planes_.push_back({half * camera.forward + side, 0});
    };
    add(camera.right, halfX);
    add(-camera.right, halfX);
    add(camera.up, halfY);
    add(-camera.up, halfY);
}

bool ViewVolume::mayShow(const LatticeBox& box, Selector::Heights heights) const {
    if (!(heights.low <= heights.high)) return false;
    const auto [low, high] = selector_.pictureHeights(heights, box);
    Vec3 corners[8];
    for (int k = 0; k < 8; ++k) {
        const Vec2 ground =
            map_.worldFromLattice({k & 1 ? box.i1 : box.i0, k & 2 ? box.j1 : box.j0});
        corners[k] = Vec3{ground.x - eye_.x, ground.y - eye_.y, (k & 4 ? high : low) - eye_.z};
    }
    return std::none_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
        return std::all_of(std::begin(corners), std::end(corners), [&](const Vec3& corner) {
            return glm::dot(plane.normal, corner) + plane.offset < 0;
        });
    });
}

int ViewVolume::finestMip(const LatticeBox& box, const BlockBounds& block) const {
    const Selector::Heights heights = selector_.trueHeights(block);
    if (!mayShow(box, heights)) return kUnseen;
    const auto [low, high] = selector_.pictureHeights(heights, box);
    double metres = sampleMetres_;
    if (pixelAngle_ > 0) {
        const double above = std::max({0.0, low - eye_.z, eye_.z - high});
        metres = pixelAngle_ * std::sqrt(selector_.groundDistance2(box) + above * above);
    }
    // Half of a footprint, in cells (shade/normals.h); a rough look at its logarithm is 0.01 off.
    const double cells = 0.5 * metres / cellMetres_;
    return cells > 1 ? static_cast<int>(std::floor(std::log2(cells) - 0.01)) : 0;
}

}  // namespace terray
