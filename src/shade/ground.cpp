// SPDX-License-Identifier: Apache-2.0
// Ray differentials on the tangent plane, and normals filtered to what they cover.
#include "shade/ground.h"

#include <algorithm>
#include <cmath>

#include "kernel/height.h"
#include "shade/rules/lines.h"

namespace terray {

CellPosts cellPosts(const TerrainCut& cut, const Hit& hit) {
    const TileDesc& tile = cut.tiles[hit.tile];
    const int x = static_cast<int>(cellX(hit)), y = static_cast<int>(cellY(hit));
    return {postHeight(cut, tile, x, y), postHeight(cut, tile, x + 1, y),
            postHeight(cut, tile, x, y + 1), postHeight(cut, tile, x + 1, y + 1)};
}

GroundSampler::GroundSampler(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays,
                             float footprintShare, bool withFeet)
    : cut_(cut),
      rays_(rays),
      camera_(rays.camera()),
      filtered_(cut, info.scheme),
      footprintShare_(footprintShare),
      exaggeration_(static_cast<float>(rays.exaggeration())),
      withFeet_(withFeet),
      right_(camera_.right),
      up_(camera_.up),
      forward_(camera_.forward) {
    const Vec2 perI = info.worldFromLattice.worldGradient(1, 0);
    const Vec2 perJ = info.worldFromLattice.worldGradient(0, 1);
    gradientXi_ = static_cast<float>(perI.x), gradientYi_ = static_cast<float>(perI.y);
    gradientXj_ = static_cast<float>(perJ.x), gradientYj_ = static_cast<float>(perJ.y);
    perCellArea_ = static_cast<float>(1.0 / std::abs(info.worldFromLattice.det()));
    if (camera_.projection == Projection::Ortho) {
        perPixelX_ = static_cast<float>(camera_.orthoSize.x / camera_.width);
        perPixelY_ = static_cast<float>(camera_.orthoSize.y / camera_.height);
    } else {
        perPixelX_ = perPixelY_ = static_cast<float>(1.0 / camera_.focalPixels());
    }
}

GroundSampler::PixelRay GroundSampler::pixelRay(double px, double py, float t) const {
    const auto fromCentreX = static_cast<float>(px - 0.5 * camera_.width) * perPixelX_;
    const auto fromCentreY = static_cast<float>(0.5 * camera_.height - py) * perPixelY_;
    switch (camera_.projection) {
        case Projection::Ortho:
            return {forward_, right_ * perPixelX_, up_ * -perPixelY_, perPixelX_ * perPixelY_};
        case Projection::Panorama: {
            const float azimuth = static_cast<float>(camera_.heading) + fromCentreX;
            const float s = std::sin(azimuth), c = std::cos(azimuth);
            const glm::vec3 ray{s, c, static_cast<float>(std::tan(camera_.pitch)) + fromCentreY};
            const float perUnit = 1.0f / glm::length(ray), step = t * perPixelX_ * perUnit;
            return {ray * perUnit, glm::vec3{c, -s, 0} * step, glm::vec3{0, 0, -step}, step * step};
        }
        case Projection::Perspective: break;
    }
    const glm::vec3 ray = forward_ + right_ * fromCentreX + up_ * fromCentreY;
    const float perUnit = 1.0f / glm::length(ray), step = t * perPixelX_ * perUnit;
    return {ray * perUnit, right_ * step, up_ * -step, step * step};
}

glm::vec3 GroundSampler::viewAt(double px, double py) const {
    return pixelRay(px, py, 0).direction;
}

glm::vec2 GroundSampler::onGround(const PixelRay& ray, const glm::vec3& normal,
                                  const glm::vec3& move) {
    constexpr float kGrazing = 0.06f;  // a flatter look covers no more ground than this one
    float facing = glm::dot(normal, ray.direction);
    if (std::abs(facing) < kGrazing) facing = facing < 0 ? -kGrazing : kGrazing;
    const glm::vec3 slid = move - ray.direction * (glm::dot(normal, move) / facing);
    return {slid.x, slid.y};
}

/// Constant cells are blocks with flat tops and upright walls, as far as they can be told apart:
/// where a sample covers more than one, their mean slope shows.
void GroundSampler::asBlock(const Hit& hit, const PixelRay& ray, double px, double py,
                            Ground& ground) const {
    const bool wall = (hit.flags & kHitStrip) != 0;
    if (wall)
        ground.height = static_cast<float>(
            RayFrame::heightAt(rays_.rayThrough(px, py), static_cast<double>(hit.t)));
    const auto size = static_cast<float>(1u << hit.mip);
    const float mean = rules::smoothStep(0.5f, 1.5f, ground.footprint / size);
    const glm::vec3 own =
        wall ? glm::vec3(rays_.wallNormal(hit, Vec3(ray.direction))) : glm::vec3{0, 0, 1};
    ground.gradient *= mean;
    ground.normal = glm::normalize(glm::mix(own, ground.normal, mean));
}

Ground GroundSampler::at(const Hit& hit, double px, double py) const {
    const TileDesc& tile = cut_.tiles[hit.tile];
    const auto size = static_cast<double>(1u << hit.mip);
    Ground ground;
    ground.i = tile.x + (static_cast<double>(cellX(hit)) + static_cast<double>(hit.u)) * size;
    ground.j = tile.y + (static_cast<double>(cellY(hit)) + static_cast<double>(hit.v)) * size;
    ground.distance = hit.t;
    const CellPosts posts = cellPosts(cut_, hit);
    ground.height = cut_.surface == kSurfaceConstant ? posts.nearest(hit.u, hit.v)
                                                     : posts.heightAt(hit.u, hit.v);
    const PixelRay ray = pixelRay(px, py, hit.t);

    // How wide to filter: the ground that a sample covers, seen against the drawn cell's own plane,
    // not wider than a few pixels where the look is grazing.
    glm::vec2 lattice = posts.gradientAt(hit.u, hit.v) / static_cast<float>(size);
    const glm::vec2 plane = exaggeration_ * worldGradient(lattice);
    const float down =
        std::abs(ray.direction.z - plane.x * ray.direction.x - plane.y * ray.direction.y);
    const float least = 0.15f * (1.0f + std::max(std::abs(plane.x), std::abs(plane.y)));
    const float covered = ray.area / std::max(down, least);
    ground.footprint = footprintShare_ * std::sqrt(covered * perCellArea_);
    filtered_.at(ground.i, ground.j, ground.footprint, lattice);

    ground.gradient = worldGradient(lattice);
    ground.normal = pictureNormal(ground.gradient);
    if (cut_.surface == kSurfaceConstant) asBlock(hit, ray, px, py, ground);
    if (!withFeet_) return ground;
    ground.footX = onGround(ray, ground.normal, ray.right);
    ground.footY = onGround(ray, ground.normal, ray.down);
    return ground;
}

}  // namespace terray
