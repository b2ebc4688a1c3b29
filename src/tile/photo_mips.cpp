// SPDX-License-Identifier: Apache-2.0
// Means of up to four pixels in linear light, by tables.
#include "tile/photo_mips.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terray {
namespace {

constexpr uint32_t kFull = 65535;  ///< of linear light

double linearOf(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}
double codeOf(double linear) {
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

struct Tables {
    std::array<uint32_t, 256> linear{};
    std::array<uint8_t, kFull + 1> code{};
    Tables() {
        for (size_t k = 0; k < linear.size(); ++k) {
            linear[k] =
                static_cast<uint32_t>(std::lround(kFull * linearOf(static_cast<double>(k) / 255)));
        }
        for (size_t k = 0; k < code.size(); ++k) {
            code[k] =
                static_cast<uint8_t>(std::lround(255 * codeOf(static_cast<double>(k) / kFull)));
        }
    }
};

const Tables& tables() {
    static const Tables made;
    return made;
}

}  // namespace

void halvePhoto(const uint8_t* fine, int width, int height, ptrdiff_t fineStride, uint8_t* out,
                ptrdiff_t stride) {
    const Tables& table = tables();
    for (int y = 0; 2 * y < height; ++y) {
        uint8_t* to = out + y * stride;
        const int rows = std::min(2, height - 2 * y);
        for (int x = 0; 2 * x < width; ++x, to += 4) {
            const int columns = std::min(2, width - 2 * x);
            std::array<uint64_t, 4> sum{};
            for (int k = 0; k < rows * columns; ++k) {
                const uint8_t* from =
                    fine + (2 * y + k / columns) * fineStride + (2 * x + k % columns) * 4;
                for (size_t c = 0; c < 3; ++c) sum[c] += table.linear[from[c]] * uint64_t{from[3]};
                sum[3] += from[3];
            }
            for (size_t c = 0; c < 3; ++c) {
                to[c] = sum[3] == 0 ? uint8_t{0} : table.code[(sum[c] + sum[3] / 2) / sum[3]];
            }
            const auto count = static_cast<uint64_t>(rows * columns);
            to[3] = static_cast<uint8_t>((sum[3] + count / 2) / count);
        }
    }
}

}  // namespace terray
