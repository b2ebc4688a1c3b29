// SPDX-License-Identifier: Apache-2.0
// The display table and its loop over pixels.
#include "shade/display.h"

#include <cmath>

#include "base/assert.h"
#include "shade/rules/colour.h"

namespace terray {

DisplayCurve::DisplayCurve(bool shoulder) {
    for (size_t k = 0; k <= kSize; ++k) {
        const float scene = kMost * static_cast<float>(k) / static_cast<float>(kSize);
        const float shown = shoulder ? rules::displayFromScene(scene) : std::min(scene, 1.0f);
        codes_[k] = static_cast<uint8_t>(std::lround(255.0f * rules::srgbFromLinear(shown)));
    }
}

const DisplayCurve& DisplayCurve::forPictures(bool shoulder) {
    if (shoulder) {
        static const DisplayCurve kLit(true);
        return kLit;
    }
    static const DisplayCurve kFlat(false);
    return kFlat;
}

uint8_t DisplayCurve::code(float scene) const {
    const float x =
        std::clamp(scene * (static_cast<float>(kSize) / kMost), 0.0f, static_cast<float>(kSize));
    return codes_[static_cast<size_t>(x + 0.5f)];
}

void DisplayCurve::apply(std::span<const Colour> in, std::span<uint8_t> out) const {
    TERRAY_ASSERT(out.size() == in.size() * 4);
    for (size_t k = 0; k < in.size(); ++k) {
        const Colour& c = in[k];
        uint8_t* pixel = &out[4 * k];
        const float straight = c.a > 0 ? 1.0f / c.a : 0.0f;
        pixel[0] = code(c.r * straight);
        pixel[1] = code(c.g * straight);
        pixel[2] = code(c.b * straight);
        pixel[3] = static_cast<uint8_t>(std::clamp(c.a, 0.0f, 1.0f) * 255.0f + 0.5f);
    }
}

}  // namespace terray
