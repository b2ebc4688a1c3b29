// SPDX-License-Identifier: Apache-2.0
// Colour scales of the inspection modes, as tables in linear light.
#include "shade/modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace terray {
namespace {

using rules::Rgb;

constexpr size_t kSize = 1024;

struct Codes {
    float r, g, b;
};
constexpr Codes kViridis[] = {{68, 1, 84},    {71, 45, 123},  {59, 82, 139},
                              {44, 114, 142}, {33, 145, 140}, {40, 174, 128},
                              {94, 201, 98},  {173, 220, 48}, {253, 231, 37}};
constexpr Codes kSteep[] = {{244, 241, 230}, {238, 214, 160}, {226, 164, 100}, {200, 100, 74},
                            {150, 52, 72},   {88, 24, 66},    {36, 10, 40}};
constexpr Codes kWork[] = {{10, 12, 40},   {40, 40, 120},  {110, 50, 140}, {190, 70, 110},
                           {235, 120, 70}, {250, 190, 80}, {255, 250, 200}};
constexpr Codes kMips[] = {{222, 222, 216}, {120, 170, 214}, {126, 190, 140}, {236, 200, 110},
                           {224, 140, 100}, {190, 120, 180}, {130, 130, 200}, {150, 110, 90}};

Rgb linear(float r, float g, float b) {
    return {rules::linearFromSrgb(r), rules::linearFromSrgb(g), rules::linearFromSrgb(b)};
}
Rgb linear(const Codes& c) { return linear(c.r / 255, c.g / 255, c.b / 255); }

using Scale = std::array<Rgb, kSize>;
Scale makeScale(std::span<const Codes> stops) {
    Scale scale;
    for (size_t k = 0; k < kSize; ++k) {
        const float x = static_cast<float>(k) / static_cast<float>(kSize - 1) *
                        static_cast<float>(stops.size() - 1);
        const size_t at = std::min(static_cast<size_t>(x), stops.size() - 2);
        const float f = x - static_cast<float>(at);
        const Codes &a = stops[at], &b = stops[at + 1];
        scale[k] = linear({a.r + f * (b.r - a.r), a.g + f * (b.g - a.g), a.b + f * (b.b - a.b)});
    }
    return scale;
}
Rgb look(const Scale& scale, float v) {
    const float x = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(kSize - 1);
    return scale[static_cast<size_t>(x + 0.5f)];
}

}  // namespace

Rgb scaleColour(float v) {
    static const Scale kScale = makeScale(kViridis);
    return look(kScale, v);
}
Rgb slopeColour(float degrees) {
    static const Scale kScale = makeScale(kSteep);
    return look(kScale, degrees / 75.0f);
}
Rgb stepsColour(float steps) {
    static const Scale kScale = makeScale(kWork);
    return look(kScale, std::log2(std::max(steps, 1.0f)) / 10.0f);
}
Rgb mipColour(int mip) { return linear(kMips[static_cast<size_t>(mip) % std::size(kMips)]); }
Rgb grey(float srgb) {
    static const Scale kScale = makeScale(std::array<Codes, 2>{{{0, 0, 0}, {255, 255, 255}}});
    return look(kScale, srgb);
}
Rgb normalColour(const glm::vec3& n) {
    return {grey(0.5f + 0.5f * n.x).r, grey(0.5f + 0.5f * n.y).r, grey(0.5f + 0.5f * n.z).r};
}

}  // namespace terray
