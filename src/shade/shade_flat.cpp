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

void DeferredShader::shadeFlat(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                               float weight, std::span<Colour> sum, ShadeCounters& counters) const {
    size_t k = 0;
    for (int y = 0; y < tile.height; ++y) {
        const double py = tile.y + y + offset.y;
        for (int x = 0; x < tile.width; ++x, ++k) {
            const double px = tile.x + x + offset.x;
            Colour add;
            if (isHit(hits[k])) {
                const Rgb c = flatColour(hits[k], px, py, counters);
                add = {c.r, c.g, c.b, 1.0f};
            } else {
                add = missColour(ground_.viewAt(px, py));
            }
            sum[k].r += weight * add.r;
            sum[k].g += weight * add.g;
            sum[k].b += weight * add.b;
            sum[k].a += weight * add.a;
        }
    }
}

Rgb DeferredShader::flatColour(const Hit& hit, double px, double py,
                               ShadeCounters& counters) const {
    const auto far01 = [&](float metres) {
        return (metres - reach_.nearest) / std::max(reach_.farthest - reach_.nearest, 1e-3f);
    };
    Rgb colour{0.0f};
    Ground ground;
    const bool contours = settings_.options.contoursM > 0;
    if (contours || settings_.shading == Shading::Hillshade ||
        settings_.shading == Shading::Slope || settings_.shading == Shading::Normal ||
        settings_.shading == Shading::Height)
        ground = ground_.at(hit, px, py);
    switch (settings_.shading) {
        case Shading::Hillshade:
            colour = grey(std::min(1.0f, 0.08f + 1.36f * rules::multiHillshade(ground.normal)));
            break;
        case Shading::Slope:
            colour = slopeColour(
                static_cast<float>(degFromRad(static_cast<double>(std::atan(ground.slope())))));
            break;
        case Shading::Normal: colour = normalColour(ground.normal); break;
        case Shading::Height: {
            const TerrainInfo& info = terrain_.info();
            colour =
                scaleColour((ground.height - info.minZ) / std::max(info.maxZ - info.minZ, 1e-3f));
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
    if (contours) {
        const float perPixel = glm::length(glm::vec2{glm::dot(ground.gradient, ground.footX),
                                                     glm::dot(ground.gradient, ground.footY)});
        colour *=
            1.0f - 0.8f * rules::contourCover(ground.height, perPixel,
                                              static_cast<float>(settings_.options.contoursM));
    }
    return colour;
}

Rgb DeferredShader::shadowStepsColour(const Hit& hit, double px, double py,
                                      ShadeCounters& counters) const {
    const LatticePlace place = hitPlace(cut_, hit);
    const Ray ray = sunRays_.from(place.i, place.j, heightOf(hit, px, py));
    uint8_t dark = 0;
    TraceCounters traced;
    occluded(cut_, {&hit, 1}, {&ray, 1}, {&dark, 1}, traced);
    counters.shadowRays += traced.rays;
    const Rgb colour = stepsColour(static_cast<float>(traced.steps));
    return dark ? colour * 0.45f : glm::mix(colour, Rgb{1.0f}, 0.25f);
}

}  // namespace terray
