// SPDX-License-Identifier: Apache-2.0
// The (max, min) pyramid of a tile slot: plain loops over rows of cells, compiled for several SIMD
// levels.
#include "kernel/pyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/simd_clones.h"

namespace terray {
namespace {

constexpr int kCells = 512;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// ---- 16-bit posts ----

/// Max and min of the corners of each cell between two post rows; a hole gives (0, 65535).
inline __attribute__((always_inline)) void cellRow(const uint16_t* upper, const uint16_t* lower,
                                                   int cells, uint16_t* maxOut, uint16_t* minOut) {
    for (int i = 0; i < cells; ++i) {
        const uint16_t maxLeft = std::max(upper[i], lower[i]);
        const uint16_t maxRight = std::max(upper[i + 1], lower[i + 1]);
        const uint16_t minLeft = std::min(upper[i], lower[i]);
        const uint16_t minRight = std::min(upper[i + 1], lower[i + 1]);
        const uint16_t top = std::max(maxLeft, maxRight);
        const uint16_t bottom = std::min(minLeft, minRight);
        const bool hole = top == 0xFFFF;
        maxOut[i] = hole ? uint16_t{0} : top;
        minOut[i] = hole ? uint16_t{0xFFFF} : bottom;
    }
    std::fill(maxOut + cells, maxOut + kCells, uint16_t{0});
    std::fill(minOut + cells, minOut + kCells, uint16_t{0xFFFF});
}

/// Column by column: the largest max - min of the cells seen, and 65535 where one was a hole.
struct ColumnNotes {
    alignas(64) uint16_t delta[kCells] = {}, holes[kCells] = {};
};
inline __attribute__((always_inline)) void noteCells(const uint16_t* maxRow, const uint16_t* minRow,
                                                     int cells, ColumnNotes& notes) {
    for (int i = 0; i < cells; ++i) {
        const uint16_t hole = minRow[i] == 0xFFFF ? uint16_t{0xFFFF} : uint16_t{0};
        const auto difference = static_cast<uint16_t>((maxRow[i] - minRow[i]) & ~hole);
        notes.delta[i] = std::max(notes.delta[i], difference);
        notes.holes[i] = std::max(notes.holes[i], hole);
    }
}

/// Level 1 from two rows of cells.
inline __attribute__((always_inline)) void packRow(const uint16_t* max0, const uint16_t* max1,
                                                   const uint16_t* min0, const uint16_t* min1,
                                                   uint32_t* out) {
    for (int i = 0; i < kCells / 2; ++i) {
        const uint32_t top = std::max(std::max(max0[2 * i], max0[2 * i + 1]),
                                      std::max(max1[2 * i], max1[2 * i + 1]));
        const uint32_t bottom = std::min(std::min(min0[2 * i], min0[2 * i + 1]),
                                         std::min(min1[2 * i], min1[2 * i + 1]));
        out[i] = top << 16 | bottom;
    }
}

struct CodeSummary {
    uint16_t delta = 0;
    bool hasHoles = false;
};

TERRAY_SIMD_CLONES
CodeSummary firstLevel(const uint16_t* posts, int cellsX, int cellsY, uint32_t* out) {
    alignas(64) uint16_t maxRows[2][kCells], minRows[2][kCells];
    ColumnNotes notes;
    for (int y = 0; y < kCells; ++y) {
        uint16_t* maxRow = maxRows[y & 1];
        uint16_t* minRow = minRows[y & 1];
        const int cells = y < cellsY ? cellsX : 0;
        const uint16_t* upper = posts + static_cast<ptrdiff_t>(cells > 0 ? y : 0) * kPostStride;
        cellRow(upper, upper + kPostStride, cells, maxRow, minRow);
        noteCells(maxRow, minRow, cells, notes);
        if ((y & 1) == 1) {
            packRow(maxRows[0], maxRows[1], minRows[0], minRows[1], out + (y >> 1) * (kCells / 2));
        }
    }
    return {*std::max_element(notes.delta, notes.delta + kCells),
            *std::max_element(notes.holes, notes.holes + kCells) != 0};
}

// ---- Levels above the first ----

/// One level from the one below it. Max of packed entries keeps the right upper half; empty
/// entries are neutral.
TERRAY_SIMD_CLONES
void nextLevel(const uint32_t* below, int size, uint32_t* out) {
    for (int y = 0; y < size; ++y) {
        const uint32_t* row0 = below + static_cast<ptrdiff_t>(2 * y) * (2 * size);
        const uint32_t* row1 = row0 + 2 * size;
        for (int x = 0; x < size; ++x) {
            const uint32_t a = row0[2 * x], b = row0[2 * x + 1];
            const uint32_t c = row1[2 * x], d = row1[2 * x + 1];
            const uint32_t top = std::max(std::max(a, b), std::max(c, d)) & 0xFFFF0000u;
            const uint32_t bottom =
                std::min(std::min(a & 0xFFFFu, b & 0xFFFFu), std::min(c & 0xFFFFu, d & 0xFFFFu));
            out[y * size + x] = top | bottom;
        }
    }
}

void upperLevels(uint32_t* bounds) {
    for (int level = 2; level <= kTileLevels; ++level) {
        nextLevel(bounds + levelOffset(level - 1), kCells >> level, bounds + levelOffset(level));
    }
}

// ---- Float posts ----

struct FloatSummary {
    float minZ = kInfinity, maxZ = -kInfinity, delta = 0;
    bool hasHoles = false;
};

/// Max and min of the corners of each cell between two post rows; a hole gives (-inf, inf).
inline __attribute__((always_inline)) void cellRow(const float* upper, const float* lower,
                                                   int cells, float* maxOut, float* minOut) {
    for (int i = 0; i < cells; ++i) {
        const float a = upper[i], b = upper[i + 1], c = lower[i], d = lower[i + 1];
        const float top0 = a > b ? a : b, top1 = c > d ? c : d;
        const float bottom0 = a < b ? a : b, bottom1 = c < d ? c : d;
        const float top = top0 > top1 ? top0 : top1;
        const float bottom = bottom0 < bottom1 ? bottom0 : bottom1;
        const bool hole = (a != a) | (b != b) | (c != c) | (d != d);
        maxOut[i] = hole ? -kInfinity : top;
        minOut[i] = hole ? kInfinity : bottom;
    }
    std::fill(maxOut + cells, maxOut + kCells, -kInfinity);
    std::fill(minOut + cells, minOut + kCells, kInfinity);
}

TERRAY_SIMD_CLONES
FloatSummary summarise(const float* posts, int cellsX, int cellsY) {
    alignas(64) float maxRow[kCells], minRow[kCells];
    alignas(64) float maxSum[kCells], minSum[kCells], deltaSum[kCells], holeSum[kCells];
    std::fill(maxSum, maxSum + kCells, -kInfinity);
    std::fill(minSum, minSum + kCells, kInfinity);
    std::fill(deltaSum, deltaSum + kCells, 0.0f);
    std::fill(holeSum, holeSum + kCells, 0.0f);
    for (int y = 0; y < cellsY; ++y) {
        const float* upper = posts + static_cast<ptrdiff_t>(y) * kPostStride;
        cellRow(upper, upper + kPostStride, cellsX, maxRow, minRow);
        for (int i = 0; i < cellsX; ++i) {
            const float difference = maxRow[i] - minRow[i];  // -inf for a hole
            maxSum[i] = maxRow[i] > maxSum[i] ? maxRow[i] : maxSum[i];
            minSum[i] = minRow[i] < minSum[i] ? minRow[i] : minSum[i];
            deltaSum[i] = difference > deltaSum[i] ? difference : deltaSum[i];
            holeSum[i] = difference < 0 ? 1.0f : holeSum[i];
        }
    }
    FloatSummary summary;
    for (int i = 0; i < cellsX; ++i) {
        summary.maxZ = std::max(summary.maxZ, maxSum[i]);
        summary.minZ = std::min(summary.minZ, minSum[i]);
        summary.delta = std::max(summary.delta, deltaSum[i]);
        summary.hasHoles = summary.hasHoles || holeSum[i] > 0;
    }
    return summary;
}

/// The smallest power of two that is >= value (value > 0).
double powerOfTwoAbove(double value) {
    int exponent = 0;
    const double mantissa = std::frexp(value, &exponent);
    return mantissa == 0.5 ? value : std::ldexp(1.0, exponent);
}

/// Chooses boundsZ0 and boundsStep so that every code's height is a float without rounding: the
/// step is a power of two, z0 a multiple of it, and both stay within the 24 bits of a float. Then
/// all ways to compute z0 + step * code agree.
void chooseQuantiser(const FloatSummary& range, TileDesc& tile) {
    const double low = static_cast<double>(range.minZ), high = static_cast<double>(range.maxZ);
    const double magnitude = std::max(std::max(std::abs(low), std::abs(high)), 1e-30);
    const double step = std::max(powerOfTwoAbove(magnitude) * 0x1p-23,
                                 powerOfTwoAbove(std::max(high - low, 1e-30) / 65532.0));
    tile.boundsStep = static_cast<float>(step);
    tile.boundsZ0 = static_cast<float>(std::floor(low / step) * step);
}

/// Code at or above (below) z: the truncated quotient is at most one short (long) of it, because
/// rounding cannot carry z - z0 across a multiple of the step.
inline __attribute__((always_inline)) int32_t codeAbove(float z, float z0, float step,
                                                        float inverse) {
    const auto code = static_cast<int32_t>((z - z0) * inverse);
    const float height = static_cast<float>(code) * step + z0;
    return code + static_cast<int32_t>(height < z);
}
inline __attribute__((always_inline)) int32_t codeBelow(float z, float z0, float step,
                                                        float inverse) {
    const auto code = static_cast<int32_t>((z - z0) * inverse);
    const float height = static_cast<float>(code) * step + z0;
    return code - static_cast<int32_t>(height > z);
}

TERRAY_SIMD_CLONES
void firstLevel(const float* posts, int cellsX, int cellsY, float z0, float step, uint32_t* out) {
    alignas(64) float maxRows[2][kCells], minRows[2][kCells], top[kCells], bottom[kCells];
    const float inverse = 1.0f / step, highest = z0 + 65534.0f * step;
    for (int y = 0; y < kCells; y += 2) {
        for (int half = 0; half < 2; ++half) {
            const int cells = y + half < cellsY ? cellsX : 0;
            const float* upper =
                posts + static_cast<ptrdiff_t>(cells > 0 ? y + half : 0) * kPostStride;
            cellRow(upper, upper + kPostStride, cells, maxRows[half], minRows[half]);
        }
        for (int i = 0; i < kCells; ++i) {
            top[i] = maxRows[0][i] > maxRows[1][i] ? maxRows[0][i] : maxRows[1][i];
            bottom[i] = minRows[0][i] < minRows[1][i] ? minRows[0][i] : minRows[1][i];
        }
        for (int i = 0; i < kCells / 2; ++i) {
            const float high = top[2 * i] > top[2 * i + 1] ? top[2 * i] : top[2 * i + 1];
            const float low = bottom[2 * i] < bottom[2 * i + 1] ? bottom[2 * i] : bottom[2 * i + 1];
            // An empty block (inf, -inf) is given harmless heights, then masked out.
            const uint32_t empty = low > high ? 0xFFFFFFFFu : 0u;
            const float finiteHigh = high > z0 ? high : z0;
            const float finiteLow = low < highest ? low : highest;
            const int32_t maxCode = codeAbove(finiteHigh, z0, step, inverse);
            const int32_t minCode = codeBelow(finiteLow, z0, step, inverse);
            const uint32_t entry =
                static_cast<uint32_t>(maxCode) << 16 | static_cast<uint32_t>(minCode);
            out[(y >> 1) * (kCells / 2) + i] = (entry & ~empty) | (kEmptyBounds & empty);
        }
    }
}

float roundedUp(float value) { return std::nextafter(value, kInfinity); }

}  // namespace

SlotBounds buildPyramid(const uint16_t* posts, int cellsX, int cellsY, TileDesc& tile,
                        uint32_t* bounds) {
    const CodeSummary summary = firstLevel(posts, cellsX, cellsY, bounds);
    upperLevels(bounds);
    tile.boundsZ0 = tile.z0;
    tile.boundsStep = tile.zStep;
    const uint32_t all = bounds[levelOffset(kTileLevels)];
    SlotBounds result{kInfinity, -kInfinity, 0, summary.hasHoles, 0};
    tile.maxDelta = 0;
    if (all == kEmptyBounds) return result;
    result.maxZ = std::fma(tile.zStep, static_cast<float>(all >> 16), tile.z0);
    result.minZ = std::fma(tile.zStep, static_cast<float>(all & 0xFFFFu), tile.z0);
    // The decoded heights are rounded: each by half an ulp of the larger one.
    if (summary.delta > 0) {
        const float magnitude = std::max(std::abs(result.minZ), std::abs(result.maxZ));
        const float ulp = roundedUp(magnitude) - magnitude;
        result.maxDelta = roundedUp(tile.zStep * static_cast<float>(summary.delta) + ulp);
    }
    tile.maxDelta = result.maxDelta;
    return result;
}

SlotBounds buildPyramid(const float* posts, int cellsX, int cellsY, TileDesc& tile,
                        uint32_t* bounds) {
    const FloatSummary summary = summarise(posts, cellsX, cellsY);
    SlotBounds result{summary.minZ, summary.maxZ, 0, summary.hasHoles, 0};
    if (summary.minZ > summary.maxZ) {
        tile.boundsZ0 = tile.maxDelta = 0;
        tile.boundsStep = 1;
        std::fill(bounds, bounds + kSlotBounds, kEmptyBounds);
        return result;
    }
    chooseQuantiser(summary, tile);
    firstLevel(posts, cellsX, cellsY, tile.boundsZ0, tile.boundsStep, bounds);
    upperLevels(bounds);
    result.maxDelta = summary.delta > 0 ? roundedUp(summary.delta) : 0.0f;
    tile.maxDelta = result.maxDelta;
    return result;
}

}  // namespace terray
