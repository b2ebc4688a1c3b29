// SPDX-License-Identifier: Apache-2.0
// Inspection modes: one value of a hit as an unlit colour.
#include <algorithm>
#include <cmath>

#include "kernel/height.h"
#include "shade/deferred.h"
#include "shade/modes.h"
#include "shade/rules/lines.h"

namespace terray {

using rules::Rgb;

bool DeferredShader::flatNeedsGround() const {
    switch (settings_.shading) {
        case Shading::Hillshade:
        case Shading::Slope:
        case Shading::Normal:
        case Shading::Height: return true;
        default: return settings_.options.contoursM > 0;
    }
}

void DeferredShader::shadeFlat(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                               float weight, std::span<Colour> sum, ShadeCounters& counters) const {
    const auto width = static_cast<size_t>(tile.width);
    GroundBatch ground{};
    for (size_t first = 0; first < hits.size(); first += kBatch) {
        const size_t count = std::min<size_t>(kBatch, hits.size() - first);
        const HitBatch batch(hits.subspan(first, count));
        const auto pixelOf = [&](size_t k) {
            const size_t at = first + std::min(k, count - 1);
            return Vec2{tile.x + static_cast<double>(at % width) + offset.x,
                        tile.y + static_cast<double>(at / width) + offset.y};
        };
        if (batch.some && flatNeedsGround()) {
            ViewBatch view;
            view.setPixels(rays_.camera(), tile, offset, first);
            ground_.lookThrough(view);
            ground_.at(batch, view, ground);
        }
        for (size_t k = 0; k < count; ++k) {
            const Vec2 pixel = pixelOf(k);
            const Hit& hit = hits[first + k];
            Colour add;
            if (isHit(hit)) {
                const Rgb c =
                    flatColour(hit, pixel.x, pixel.y, ground, static_cast<int>(k), counters);
                add = {c.r, c.g, c.b, 1.0f};
            } else {
                add = missColour(ground_.viewAt(pixel.x, pixel.y));
            }
            Colour& out = sum[first + k];
            out.r += weight * add.r;
            out.g += weight * add.g;
            out.b += weight * add.b;
            out.a += weight * add.a;
        }
    }
}

/// `ground` holds the hit in lane k if flatNeedsGround().
Rgb DeferredShader::flatColour(const Hit& hit, double px, double py, const GroundBatch& ground,
                               int k, ShadeCounters& counters) const {
    const auto far01 = [&](float metres) {
        return (metres - reach_.nearest) / std::max(reach_.farthest - reach_.nearest, 1e-3f);
    };
    Rgb colour{0.0f};
    const glm::vec3 normal{ground.normal.x[k], ground.normal.y[k], ground.normal.z[k]};
    const glm::vec2 gradient{ground.gradient.x[k], ground.gradient.y[k]};
    switch (settings_.shading) {
        case Shading::Hillshade:
            colour = grey(std::min(1.0f, 0.08f + 1.36f * rules::multiHillshade(normal)));
            break;
        case Shading::Slope:
            colour = slopeColour(static_cast<float>(
                degFromRad(static_cast<double>(std::atan(glm::length(gradient))))));
            break;
        case Shading::Normal: colour = normalColour(normal); break;
        case Shading::Height: {
            const TerrainInfo& info = terrain_.info();
            colour = scaleColour((ground.height[k] - info.minZ) /
                                 std::max(info.maxZ - info.minZ, 1e-3f));
            break;
        }
        case Shading::Depth: {
            const float forward =
                glm::dot(ground_.viewAt(px, py), glm::vec3(rays_.camera().forward));
            colour = grey(0.95f - 0.85f * std::clamp(far01(hit.t * forward), 0.0f, 1.0f));
            break;
        }
        case Shading::Distance:
            colour = grey(0.95f - 0.85f * std::clamp(far01(hit.t), 0.0f, 1.0f));
            break;
        case Shading::Mip: colour = mipColour(hit.mip); break;
        case Shading::Steps: colour = stepsColour(hit.steps); break;
        case Shading::Shadow: colour = shadowStepsColour(hit, px, py, counters); break;
        default: break;
    }
    if (settings_.options.contoursM > 0) {
        Floats cover;
        contourBatch(ground, cover);
        colour *= 1.0f - 0.8f * cover[k];
    }
    return colour;
}

Rgb DeferredShader::shadowStepsColour(const Hit& hit, double px, double py,
                                      ShadeCounters& counters) const {
    const LatticePlace place = hitPlace(cut_, hit);
    const Ray ray = sunRays_.direction().rayFrom(place.i, place.j, heightOf(hit, px, py));
    uint8_t dark = 0;
    TraceCounters traced;
    occluded(cut_, {&hit, 1}, {&ray, 1}, {&dark, 1}, traced);
    counters.shadowRays += traced.rays;
    const Rgb colour = stepsColour(static_cast<float>(traced.steps));
    return dark ? colour * 0.45f : glm::mix(colour, Rgb{1.0f}, 0.25f);
}

}  // namespace terray
