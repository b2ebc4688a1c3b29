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

bool isOpaque(const uint8_t* from, int columns, int rows, ptrdiff_t stride) {
    uint8_t all = 255;
    for (int k = 0; k < rows * columns; ++k)
        all &= from[k / columns * stride + k % columns * 4 + 3];
    return all == 255;
}

/// The general rule below, without the divisions.
void meanOfOpaque(const uint8_t* from, int columns, int rows, ptrdiff_t stride, uint8_t* to) {
    const Tables& table = tables();
    const int count = columns * rows;
    const int shift = count == 4 ? 2 : count - 1;
    for (int c = 0; c < 3; ++c) {
        uint32_t sum = 0;
        for (int k = 0; k < count; ++k)
            sum += table.linear[from[k / columns * stride + k % columns * 4 + c]];
        to[c] = table.code[(sum + (1u << shift) / 2) >> shift];
    }
    to[3] = 255;
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
            if (isOpaque(fine + 2 * y * fineStride + 2 * x * 4, columns, rows, fineStride)) {
                meanOfOpaque(fine + 2 * y * fineStride + 2 * x * 4, columns, rows, fineStride, to);
                continue;
            }
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
