// SPDX-License-Identifier: Apache-2.0
// Muted hypsometric tints after Imhof and Patterson, and plain ramps for measuring eyes.
#include "shade/ramp_builtin.h"

#include <array>

namespace terray {
namespace {

constexpr RampStop kNatural[] = {{0.00f, 122, 140, 112, 0.45f}, {0.16f, 153, 163, 126, 0.50f},
                                 {0.32f, 192, 186, 146, 0.55f}, {0.48f, 206, 184, 143, 0.60f},
                                 {0.64f, 186, 159, 125, 0.65f}, {0.78f, 168, 152, 132, 0.72f},
                                 {0.88f, 198, 191, 177, 0.80f}, {1.00f, 241, 242, 244, 0.90f}};
constexpr RampStop kAtlas[] = {{0.00f, 128, 152, 124, 0.30f}, {0.20f, 168, 180, 142, 0.35f},
                               {0.40f, 212, 206, 166, 0.40f}, {0.58f, 216, 190, 152, 0.45f},
                               {0.75f, 194, 164, 142, 0.50f}, {0.90f, 214, 206, 202, 0.70f},
                               {1.00f, 240, 240, 241, 0.80f}};
constexpr RampStop kAlpine[] = {{0.00f, 104, 124, 94, 0.55f},  {0.22f, 134, 144, 112, 0.60f},
                                {0.42f, 154, 146, 124, 0.70f}, {0.58f, 146, 141, 136, 0.75f},
                                {0.70f, 196, 198, 201, 0.90f}, {0.85f, 228, 231, 235, 0.90f},
                                {1.00f, 242, 244, 247, 0.90f}};
constexpr RampStop kDesert[] = {{0.00f, 170, 140, 112, 0.25f}, {0.20f, 196, 158, 122, 0.25f},
                                {0.42f, 214, 180, 140, 0.25f}, {0.60f, 196, 148, 112, 0.25f},
                                {0.78f, 170, 122, 98, 0.25f},  {0.92f, 186, 158, 136, 0.30f},
                                {1.00f, 222, 208, 190, 0.40f}};
constexpr RampStop kIce[] = {{0.00f, 128, 156, 176, 0.60f},
                             {0.30f, 174, 198, 212, 0.70f},
                             {0.65f, 214, 226, 233, 0.75f},
                             {1.00f, 242, 245, 247, 0.80f}};
constexpr RampStop kPaper[] = {{0.00f, 206, 203, 190, 0.15f},
                               {0.30f, 222, 216, 203, 0.15f},
                               {0.65f, 231, 221, 206, 0.15f},
                               {1.00f, 238, 231, 222, 0.15f}};
constexpr RampStop kGrey[] = {{0.00f, 96, 96, 96, 0}, {1.00f, 236, 236, 236, 0}};
constexpr RampStop kViridis[] = {
    {0.000f, 68, 1, 84, 0},    {0.125f, 71, 45, 123, 0},  {0.250f, 59, 82, 139, 0},
    {0.375f, 44, 114, 142, 0}, {0.500f, 33, 145, 140, 0}, {0.625f, 40, 174, 128, 0},
    {0.750f, 94, 201, 98, 0},  {0.875f, 173, 220, 48, 0}, {1.000f, 253, 231, 37, 0}};

// From the deepest place to the shore.
constexpr RampStop kSea[] = {{0.00f, 46, 72, 104, 0.10f},
                             {0.35f, 66, 100, 134, 0.10f},
                             {0.65f, 96, 134, 162, 0.10f},
                             {0.88f, 128, 164, 184, 0.10f},
                             {1.00f, 150, 183, 197, 0.10f}};

constexpr std::array<BuiltinRamp, 9> kRamps{{
    {"natural", "grey-green lowland, beige, warm brown, grey rock, near-white tops (default)",
     kNatural, kSea, 0.5f, true, false},
    {"atlas", "lighter, cross-blended hypsometric tints of atlases", kAtlas, kSea, 0.5f, true,
     false},
    {"alpine", "dark valleys, grey rock and much snow", kAlpine, kSea, 0.4f, false, false},
    {"desert", "sand, ochre and red rock", kDesert, kSea, 0.5f, false, false},
    {"ice", "blue-grey to white, for glaciers and polar land", kIce, kSea, 0.5f, false, false},
    {"sea", "sea floor in blues below 0, natural tints above", kNatural, kSea, 0.5f, true, true},
    {"paper", "warm off-white, lets the light speak: cities, models", kPaper, kSea, 0.5f, false,
     false},
    {"grey", "linear greys", kGrey, {}, 0.0f, false, false},
    {"viridis", "linear, perceptually even: for reading values", kViridis, {}, 0.0f, false, false},
}};

}  // namespace

std::span<const BuiltinRamp> builtinRamps() { return kRamps; }

const BuiltinRamp* findBuiltinRamp(std::string_view name) {
    for (const BuiltinRamp& ramp : kRamps)
        if (ramp.name == name) return &ramp;
    return nullptr;
}

}  // namespace terray
