// SPDX-License-Identifier: Apache-2.0
// The display table and its loop over pixels.
#include "shade/display.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

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

/// Table places of pixels, and their alpha.
struct DisplayPlaces {
    int32_t r[kBatch], g[kBatch], b[kBatch], a[kBatch];
};

namespace {

/// Places of scene values in a table.
struct Scale {
    float perScene, last;
    int32_t place(float scene) const {
        float x = scene * perScene;
        x = x > 0.0f ? x : 0.0f;
        x = x < last ? x : last;
        return static_cast<int32_t>(x + 0.5f);
    }
};

TERRAY_SIMD_CLONES
void placeColours(const Colour* in, int count, Scale scale, DisplayPlaces& places) {
    for (int k = 0; k < count; ++k) {
        const float alpha = in[k].a;
        const float straight = alpha > 0 ? 1.0f / alpha : 0.0f;
        places.r[k] = scale.place(in[k].r * straight);
        places.g[k] = scale.place(in[k].g * straight);
        places.b[k] = scale.place(in[k].b * straight);
        const float kept = alpha > 0 ? alpha : 0.0f;
        places.a[k] = static_cast<int32_t>((kept < 1.0f ? kept : 1.0f) * 255.0f + 0.5f);
    }
}

/// Pixels that are not there are black as they come.
TERRAY_SIMD_CLONES
void placeLit(const LitBatch& lit, const uint8_t* dark, int count, Scale scale,
              DisplayPlaces& places) {
    for (int k = 0; k < count; ++k) {
        const float sunlit = 1.0f - static_cast<float>(dark[k]);
        places.r[k] = scale.place(lit.always.r[k] + sunlit * lit.sun.r[k]);
        places.g[k] = scale.place(lit.always.g[k] + sunlit * lit.sun.g[k]);
        places.b[k] = scale.place(lit.always.b[k] + sunlit * lit.sun.b[k]);
        places.a[k] = lit.alpha[k] > 0 ? 255 : 0;
    }
}

}  // namespace

void DisplayCurve::lookUp(const DisplayPlaces& places, std::span<uint8_t> out) const {
    static_assert(std::endian::native == std::endian::little);
    const auto count = static_cast<int>(out.size() / 4);
    uint8_t* pixel = out.data();
    const auto code = [&](int32_t place) { return uint32_t{codes_[static_cast<size_t>(place)]}; };
    for (int k = 0; k < count; ++k, pixel += 4) {  // one store each: stores are what takes time
        const uint32_t rgba = code(places.r[k]) | code(places.g[k]) << 8 | code(places.b[k]) << 16 |
                              static_cast<uint32_t>(places.a[k]) << 24;
        std::memcpy(pixel, &rgba, sizeof rgba);
    }
}

void DisplayCurve::apply(std::span<const Colour> in, std::span<uint8_t> out) const {
    TERRAY_ASSERT(out.size() == in.size() * 4);
    DisplayPlaces places;
    for (size_t first = 0; first < in.size(); first += kBatch) {
        const size_t count = std::min<size_t>(kBatch, in.size() - first);
        placeColours(&in[first], static_cast<int>(count),
                     Scale{static_cast<float>(kSize) / kMost, static_cast<float>(kSize)}, places);
        lookUp(places, out.subspan(4 * first, 4 * count));
    }
}

void DisplayCurve::show(const LitBatch& lit, std::span<const uint8_t> dark,
                        std::span<uint8_t> out) const {
    TERRAY_ASSERT(out.size() == dark.size() * 4 && dark.size() <= kBatch);
    DisplayPlaces places;
    placeLit(lit, dark.data(), static_cast<int>(dark.size()),
             Scale{static_cast<float>(kSize) / kMost, static_cast<float>(kSize)}, places);
    lookUp(places, out);
}

}  // namespace terray
