// SPDX-License-Identifier: Apache-2.0
// Scene-linear sums to 8-bit sRGB by table.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "shade/lit_loops.h"
#include "shade/shade.h"

namespace terray {

struct DisplayPlaces;

/// const-shared.
class DisplayCurve {
public:
    /// With the shoulder for lit pictures, without it for inspection modes.
    explicit DisplayCurve(bool shoulder);
    /// The one that is made once and shared.
    static const DisplayCurve& forPictures(bool shoulder);
    void apply(std::span<const Colour> in, std::span<uint8_t> out) const;
    /// Up to kBatch lit pixels of one sample each: there, or not (alpha 1 or 0); dark[k] = 1: the
    /// sun does not reach the pixel.
    void show(const LitBatch& lit, std::span<const uint8_t> dark, std::span<uint8_t> out) const;

private:
    void lookUp(const DisplayPlaces& places, std::span<uint8_t> out) const;

    static constexpr float kMost = 4.0f;  ///< scene value of the table's end
    static constexpr size_t kSize = 1 << 15;

    std::array<uint8_t, kSize + 1> codes_{};
};

}  // namespace terray
