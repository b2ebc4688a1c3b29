// SPDX-License-Identifier: Apache-2.0
// The arithmetic of lit pixels, batch by batch: rules/ in SIMD loops.
#pragma once

#include <span>

#include "shade/ground.h"
#include "shade/rules/air.h"
#include "shade/rules/light.h"
#include "shade/shade.h"

namespace terray {

/// Light on a batch: what comes anyway, and what the sun adds where it is not in shadow.
struct LightBatch {
    FloatsRgb always, sun;
};
/// Colours of kBatch pixels in the same two parts, and alpha.
struct LitBatch {
    FloatsRgb always, sun;
    Floats alpha;
};

void lightBatch(const rules::Light& light, const Floats& facing, const Floats& openSky,
                const GroundBatch& ground, LightBatch& out);

/// Ramp colours lean to `rock` grey where the ground is steep.
void steepenBatch(const rules::Rgb& grey, const Floats& rock, const GroundBatch& ground,
                  FloatsRgb& colour);

/// Colours of ground: `own` whatever the light, and `albedo` times the light.
void reflectBatch(const FloatsRgb& own, const FloatsRgb& albedo, const LightBatch& light,
                  LitBatch& lit);

/// `line` is drawn on it with a cover 0..1: paint times light if it is lit, else as it is.
void paintBatch(const rules::Rgb& line, const Floats& cover, const LightBatch* light,
                LitBatch& lit);

void hazeBatch(const rules::Air& air, const Floats& distance, LitBatch& lit);

/// The whole of it for ramped ground without lines: light, steepened colours, haze.
struct RampedLight {
    rules::Light light;
    rules::Air air;
    rules::Rgb grey;
};
void rampedBatch(const RampedLight& in, const Floats& facing, const Floats& openSky,
                 const GroundBatch& ground, const FloatsRgb& colour, const Floats& rock,
                 LitBatch& lit);

void skyBatch(const rules::Air& air, const Floats& sine, FloatsRgb& colour);

/// sum += weight * colour, up to kBatch pixels; dark[k] = 1: the sun does not reach the pixel.
void addBatch(const LitBatch& lit, std::span<const uint8_t> dark, float weight,
              std::span<Colour> sum);

}  // namespace terray
