// SPDX-License-Identifier: Apache-2.0
// The display table and its loop over pixels.
#include "shade/display.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"
#include "base/simd_clones.h"
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

namespace {

constexpr size_t kPixels = 64;

/// Table places of pixels, and their alpha.
struct Places {
    int32_t r[kPixels], g[kPixels], b[kPixels], a[kPixels];
};

TERRAY_SIMD_CLONES
void placeColours(const Colour* in, size_t count, float perScene, float last, Places& places) {
    const auto place = [=](float scene) {
        float x = scene * perScene;
        x = x > 0.0f ? x : 0.0f;
        x = x < last ? x : last;
        return static_cast<int32_t>(x + 0.5f);
    };
    for (size_t k = 0; k < count; ++k) {
        const float alpha = in[k].a;
        const float straight = alpha > 0 ? 1.0f / alpha : 0.0f;
        places.r[k] = place(in[k].r * straight);
        places.g[k] = place(in[k].g * straight);
        places.b[k] = place(in[k].b * straight);
        const float kept = alpha > 0 ? alpha : 0.0f;
        places.a[k] = static_cast<int32_t>((kept < 1.0f ? kept : 1.0f) * 255.0f + 0.5f);
    }
}

}  // namespace

void DisplayCurve::apply(std::span<const Colour> in, std::span<uint8_t> out) const {
    TERRAY_ASSERT(out.size() == in.size() * 4);
    Places places;
    for (size_t first = 0; first < in.size(); first += kPixels) {
        const size_t count = std::min(kPixels, in.size() - first);
        placeColours(&in[first], count, static_cast<float>(kSize) / kMost,
                     static_cast<float>(kSize), places);
        uint8_t* pixel = &out[4 * first];
        for (size_t k = 0; k < count; ++k, pixel += 4) {
            pixel[0] = codes_[static_cast<size_t>(places.r[k])];
            pixel[1] = codes_[static_cast<size_t>(places.g[k])];
            pixel[2] = codes_[static_cast<size_t>(places.b[k])];
            pixel[3] = static_cast<uint8_t>(places.a[k]);
        }
    }
}

}  // namespace terray
