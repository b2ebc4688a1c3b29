// SPDX-License-Identifier: Apache-2.0
// Arbitrary outputs: plain numbers of the drawn surface, exact, unfiltered, in true metres.
#include <algorithm>
#include <limits>

#include "base/assert.h"
#include "kernel/height.h"
#include "shade/deferred.h"

namespace terray {
namespace {

constexpr float kMiss = std::numeric_limits<float>::quiet_NaN();

}  // namespace

void DeferredShader::fillAov(Aov aov, const ImageTile& tile, std::span<const Hit> hits,
                             std::span<float> out) const {
    TERRAY_ASSERT(out.size() == hits.size() * static_cast<size_t>(aovChannels(aov)));
    if (aov == Aov::Shadow) return shadowAov(tile, hits, out);
    if (aovChannels(aov) == 3) return vectorAov(aov, tile, hits, out);
    size_t k = 0;
    for (int y = 0; y < tile.height; ++y) {
        for (int x = 0; x < tile.width; ++x, ++k) {
            if (!isHit(hits[k])) {
                out[k] = kMiss;
                continue;
            }
            out[k] = aovValue(aov, hits[k], tile.x + x + 0.5, tile.y + y + 0.5);
        }
    }
}

double DeferredShader::heightOf(const Hit& hit, double px, double py) const {
    if (!(hit.flags & kHitStrip)) return hitHeight(cut_, hit);
    return RayFrame::heightAt(rays_.rayThrough(px, py), static_cast<double>(hit.t));
}

Vec3 DeferredShader::normalOf(const Hit& hit, double px, double py) const {
    if (cut_.surface == kSurfaceConstant) {
        if (!(hit.flags & kHitStrip)) return {0, 0, 1};
        return rays_.wallNormal(hit, rays_.camera().rayThrough(px, py).direction);
    }
    const glm::vec2 perCell = cellPosts(cut_, hit).gradientAt(hit.u, hit.v);
    const double size = static_cast<double>(1u << hit.mip);
    const Vec2 slope = rays_.worldFromLattice().worldGradient(
        static_cast<double>(perCell.x) / size, static_cast<double>(perCell.y) / size);
    return glm::normalize(Vec3{-slope.x, -slope.y, 1});
}

float DeferredShader::aovValue(Aov aov, const Hit& hit, double px, double py) const {
    switch (aov) {
        case Aov::Distance: return hit.t;
        case Aov::Depth: {
            const Camera& camera = rays_.camera();
            const WorldRay ray = camera.rayThrough(px, py);
            if (camera.projection == Projection::Panorama)  // its axis is the horizon
                return static_cast<float>(hit.t * std::hypot(ray.direction.x, ray.direction.y));
            return static_cast<float>(hit.t * glm::dot(ray.direction, camera.forward));
        }
        case Aov::Height: return static_cast<float>(heightOf(hit, px, py));
        case Aov::Mip: return hit.mip;
        case Aov::Steps: return hit.steps;
        case Aov::Error: {
            const uint32_t column = cellX(hit) / kBlockCells, row = cellY(hit) / kBlockCells;
            return terrain_.blocks(hit.tile)[row * kTileBlocks + column].errorToFinest;
        }
        default: break;
    }
    return kMiss;
}

void DeferredShader::vectorAov(Aov aov, const ImageTile& tile, std::span<const Hit> hits,
                               std::span<float> out) const {
    const Affine2& map = rays_.worldFromLattice();
    size_t k = 0;
    for (int y = 0; y < tile.height; ++y) {
        for (int x = 0; x < tile.width; ++x, ++k) {
            const Hit& hit = hits[k];
            const double px = tile.x + x + 0.5, py = tile.y + y + 0.5;
            Vec3 value(std::numeric_limits<double>::quiet_NaN());
            if (isHit(hit) && aov == Aov::Position) {
                const LatticePlace place = hitPlace(cut_, hit);
                const Vec2 world = map.worldFromLattice({place.i, place.j});
                value = {world.x, world.y, heightOf(hit, px, py)};
            } else if (isHit(hit)) {
                value = normalOf(hit, px, py);
            }
            for (int c = 0; c < 3; ++c)
                out[3 * k + static_cast<size_t>(c)] = static_cast<float>(value[c]);
        }
    }
}

void DeferredShader::shadowAov(const ImageTile& tile, std::span<const Hit> hits,
                               std::span<float> out) const {
    std::vector<Ray> rays(hits.size());
    std::vector<uint8_t> dark(hits.size(), 0);
    const SunDirection sun = sunRays_.direction();
    for (size_t k = 0; k < hits.size(); ++k) {
        if (!isHit(hits[k])) continue;
        const LatticePlace place = hitPlace(cut_, hits[k]);
        const auto x = static_cast<int>(k) % tile.width, y = static_cast<int>(k) / tile.width;
        rays[k] =
            sun.rayFrom(place.i, place.j, heightOf(hits[k], tile.x + x + 0.5, tile.y + y + 0.5));
    }
    TraceCounters traced;
    occluded(cut_, hits, rays, dark, traced);
    for (size_t k = 0; k < hits.size(); ++k)
        out[k] = !isHit(hits[k]) ? kMiss : dark[k] || settings_.sun.belowHorizon ? 0.0f : 1.0f;
}

}  // namespace terray
