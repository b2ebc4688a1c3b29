// SPDX-License-Identifier: Apache-2.0
// Loops over the lanes of a batch, one rule each.
#include "shade/lit_loops.h"

#include <cmath>

#include "base/simd_clones.h"
#include "shade/rules/lines.h"

namespace terray {

using rules::Rgb;

namespace {

void setLane(FloatsRgb& colours, int k, const Rgb& c) {
    colours.r[k] = c.r;
    colours.g[k] = c.g;
    colours.b[k] = c.b;
}
Rgb laneOf(const FloatsRgb& colours, int k) { return {colours.r[k], colours.g[k], colours.b[k]}; }

/// Light on a pixel, in the two parts of a LightBatch.
struct LightParts {
    Rgb always, sun;
};
[[gnu::always_inline]] inline LightParts lightAt(const rules::Light& light, float facing,
                                                 float openSky, float up) {
    return {rules::shadeLight(light, rules::openShare(openSky, up)),
            light.sun * rules::sunShare(facing, openSky)};
}

[[gnu::always_inline]] inline Rgb steepen(const Rgb& colour, const Rgb& grey, float rock, float x,
                                          float y) {
    const float steep = rock * rules::smoothStep(0.55f, 1.30f, std::sqrt(x * x + y * y));
    return glm::mix(colour, grey, steep);
}

}  // namespace

TERRAY_SIMD_CLONES
void lightBatch(const rules::Light& light, const Floats& facing, const Floats& openSky,
                const GroundBatch& ground, LightBatch& out) {
    for (int k = 0; k < kBatch; ++k) {
        const LightParts parts = lightAt(light, facing[k], openSky[k], ground.normal.z[k]);
        setLane(out.always, k, parts.always);
        setLane(out.sun, k, parts.sun);
    }
}

TERRAY_SIMD_CLONES
void steepenBatch(const Rgb& grey, const Floats& rock, const GroundBatch& ground,
                  FloatsRgb& colour) {
    for (int k = 0; k < kBatch; ++k) {
        setLane(
            colour, k,
            steepen(laneOf(colour, k), grey, rock[k], ground.gradient.x[k], ground.gradient.y[k]));
    }
}

TERRAY_SIMD_CLONES
void reflectBatch(const FloatsRgb& own, const FloatsRgb& albedo, const LightBatch& light,
                  LitBatch& lit) {
    for (int k = 0; k < kBatch; ++k) {
        const Rgb a = laneOf(albedo, k);
        setLane(lit.always, k, laneOf(own, k) + a * laneOf(light.always, k));
        setLane(lit.sun, k, a * laneOf(light.sun, k));
    }
}

void paintBatch(const Rgb& line, const Floats& cover, const LightBatch* light, LitBatch& lit) {
    for (int k = 0; k < kBatch; ++k) {
        const Rgb always = light ? line * laneOf(light->always, k) : line;
        const Rgb sun = light ? line * laneOf(light->sun, k) : Rgb{0.0f};
        setLane(lit.always, k, glm::mix(laneOf(lit.always, k), always, cover[k]));
        setLane(lit.sun, k, glm::mix(laneOf(lit.sun, k), sun, cover[k]));
    }
}

TERRAY_SIMD_CLONES
void hazeBatch(const rules::Air& air, const Floats& distance, LitBatch& lit) {
    for (int k = 0; k < kBatch; ++k) {
        const float clear = rules::clearness(air, distance[k]);
        setLane(lit.always, k, laneOf(lit.always, k) * clear + rules::hazeLight(air, clear));
        setLane(lit.sun, k, laneOf(lit.sun, k) * clear);
    }
}

TERRAY_SIMD_CLONES
void rampedBatch(const RampedLight& in, const Floats& facing, const Floats& openSky,
                 const GroundBatch& ground, const FloatsRgb& colour, const Floats& rock,
                 LitBatch& lit) {
    const RampedLight c = in;
#if !defined(__clang__)
#pragma GCC ivdep
#endif
    for (int k = 0; k < kBatch; ++k) {
        const LightParts parts = lightAt(c.light, facing[k], openSky[k], ground.normal.z[k]);
        const Rgb albedo =
            steepen(laneOf(colour, k), c.grey, rock[k], ground.gradient.x[k], ground.gradient.y[k]);
        const float clear = rules::clearness(c.air, ground.distance[k]);
        setLane(lit.always, k, albedo * parts.always * clear + rules::hazeLight(c.air, clear));
        setLane(lit.sun, k, albedo * parts.sun * clear);
        lit.alpha[k] = 1.0f;
    }
}

TERRAY_SIMD_CLONES
void skyBatch(const rules::Air& air, const Floats& sine, FloatsRgb& colour) {
    for (int k = 0; k < kBatch; ++k) setLane(colour, k, rules::skyColour(air, sine[k]));
}

namespace {

TERRAY_SIMD_CLONES
void addLanes(const LitBatch& lit, const uint8_t* dark, float weight, int count,
              Colour* __restrict out) {
    for (int k = 0; k < count; ++k) {
        const float sunlit = 1.0f - static_cast<float>(dark[k]);
        out[k].r += weight * (lit.always.r[k] + sunlit * lit.sun.r[k]);
        out[k].g += weight * (lit.always.g[k] + sunlit * lit.sun.g[k]);
        out[k].b += weight * (lit.always.b[k] + sunlit * lit.sun.b[k]);
        out[k].a += weight * lit.alpha[k];
    }
}

}  // namespace

void addBatch(const LitBatch& lit, std::span<const uint8_t> dark, float weight,
              std::span<Colour> sum) {
    addLanes(lit, dark.data(), weight, static_cast<int>(sum.size()), sum.data());
}

}  // namespace terray
