// SPDX-License-Identifier: Apache-2.0
// B-splines row by row, trees and houses lot by lot.
#include "terabyte_ground.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "raster/synthetic_noise.h"

namespace terray::bench {
namespace {

using synthetic::hashPlace;

constexpr double kLargest = 480,
                 kRoughness = 0.85;  ///< metres; amplitudes halve 0.85 times an octave
constexpr int kSquareLog2 = 6, kLandOctave = 11;
constexpr uint32_t kLandSeed = 77, kTreeSeed = 101, kHouseSeed = 103, kGrassSeed = 107;
constexpr float kGrass = 0.3f;                         ///< metres
constexpr float kForests = 0.08f, kVillages = -0.25f;  ///< of the land's -1 .. 1

float unit(uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }  ///< 0 .. 1

/// Weights of four numbers at a fraction of the way from the second to the third.
std::array<float, 4> weights(float f) {
    const float g = 1 - f;
    return {g * g * g / 6, (3 * f * f * f - 6 * f * f + 4) / 6,
            (-3 * f * f * f + 3 * f * f + 3 * f + 1) / 6, f * f * f / 6};
}

}  // namespace

double amplitude(int octave) {
    return kLargest * std::exp2(kRoughness * (octave - kCoarsestOctave));
}

/// An octave that a mip lacks is off by its amplitude at most. One that it has is off by what is
/// between posts: s^2 / 8 (|fxx| + |fyy|), and the second differences of numbers within -a .. a are
/// 4 a at most.
double hillsError(int mip, int finestMip) {
    double error = 0;
    for (int k = finestMip == 0 ? 0 : finestMip + 1; k <= kCoarsestOctave; ++k) {
        error += amplitude(k) * (k <= mip ? 1.0 : std::exp2(2.0 * (mip - k)));
    }
    return error;
}

double hillsSlope() {
    double slope = 0;
    for (int k = 0; k <= kCoarsestOctave; ++k) slope += 2 * amplitude(k) * std::exp2(-k);
    return slope;
}

HillRows::HillRows(int mip, int firstOctave, int lastOctave, uint32_t seed, int64_t x, int width)
    : x_(x), width_(width) {
    for (int k = lastOctave; k >= firstOctave; --k) {
        Octave octave;
        octave.log2 = k - mip;
        octave.amplitude = static_cast<float>(amplitude(k));
        octave.seed = synthetic::mixBits(seed * 31 + static_cast<uint32_t>(k));
        octave.firstCell = x >> octave.log2;
        octave.cells = ((x + width - 1) >> octave.log2) - octave.firstCell + 1;
        for (auto& row : octave.rows) row.resize(static_cast<size_t>(octave.cells + 3));
        octave.blended.resize(static_cast<size_t>(octave.cells + 3));
        octaves_.push_back(std::move(octave));
    }
}

void HillRows::fill(const Octave& octave, int64_t cellRow, std::vector<float>& out) const {
    for (size_t c = 0; c < out.size(); ++c) {
        const uint32_t hash =
            hashPlace(octave.firstCell - 1 + static_cast<int64_t>(c), cellRow, octave.seed);
        out[c] = (hash & 1) != 0 ? octave.amplitude : -octave.amplitude;
    }
}

void HillRows::hold(Octave& octave, int64_t cellRow) const {
    if (octave.heldCell == cellRow) return;
    if (octave.heldCell + 1 == cellRow) {
        for (int j = 0; j < 3; ++j) octave.rows[j].swap(octave.rows[j + 1]);
        fill(octave, cellRow + 2, octave.rows[3]);
    } else {
        for (int j = 0; j < 4; ++j) fill(octave, cellRow - 1 + j, octave.rows[j]);
    }
    octave.heldCell = cellRow;
}

void HillRows::addRow(int64_t y, float* out) {
    for (Octave& octave : octaves_) {
        const int64_t length = int64_t{1} << octave.log2;
        hold(octave, y >> octave.log2);
        const float share = 1 / static_cast<float>(length);
        const auto wy = weights(static_cast<float>(y & (length - 1)) * share);
        float* const b = octave.blended.data();
        for (size_t c = 0; c < octave.blended.size(); ++c) {
            b[c] = wy[0] * octave.rows[0][c] + wy[1] * octave.rows[1][c] +
                   (wy[2] * octave.rows[2][c] + wy[3] * octave.rows[3][c]);
        }
        if (octave.log2 == 0) {
            for (int i = 0; i < width_; ++i) out[i] += (b[i] + 4 * b[i + 1] + b[i + 2]) / 6;
            continue;
        }
        for (int64_t c = 0; c < octave.cells; ++c) {
            const float p0 = (b[c] + 4 * b[c + 1] + b[c + 2]) / 6, p1 = (b[c + 2] - b[c]) / 2;
            const float p2 = (b[c] - 2 * b[c + 1] + b[c + 2]) / 2;
            const float p3 = (b[c + 3] - 3 * b[c + 2] + 3 * b[c + 1] - b[c]) / 6;
            const int64_t left = ((octave.firstCell + c) << octave.log2) - x_;
            const auto from = static_cast<int>(std::max<int64_t>(left, 0));
            const auto to = static_cast<int>(std::min<int64_t>(left + length, width_));
            const auto offset = static_cast<int>(left);
            for (int i = from; i < to; ++i) {
                const float f = static_cast<float>(i - offset) * share;
                out[i] += p0 + f * (p1 + f * (p2 + f * p3));
            }
        }
    }
}

Clutter::Clutter(int64_t columns, int64_t rows, uint32_t seed, bool isBare)
    : seed_(seed),
      isBare_(isBare),
      squaresX_((columns >> kSquareLog2) + 1),
      squaresY_((rows >> kSquareLog2) + 1),
      heights_(static_cast<size_t>(squaresX_ * squaresY_)),
      kinds_(heights_.size()) {
    if (isBare) return;
    HillRows land(kSquareLog2, kLandOctave, kLandOctave, seed + kLandSeed, 0,
                  static_cast<int>(squaresX_));
    const auto most = static_cast<float>(amplitude(kLandOctave));
    for (int64_t y = 0; y < squaresY_; ++y) {
        float* const out = heights_.data() + y * squaresX_;
        land.addRow(y, out);
        for (int64_t x = 0; x < squaresX_; ++x) {
            const float land01 = out[x] / most;
            const float dice = unit(hashPlace(x, y, seed + kHouseSeed));
            const bool isHouses = land01 < kVillages ? dice < 0.6f : dice < 0.04f;
            Kind& kind = kinds_[static_cast<size_t>(y * squaresX_ + x)];
            if (land01 > kForests) {
                kind = Kind::Forest;
                out[x] = 3 + 5 * std::min((land01 - kForests) / 0.4f, 1.0f);
            } else {
                kind = isHouses ? Kind::Houses : Kind::Meadow;
                out[x] = isHouses ? 4 + 5 * dice : kGrass;
            }
        }
    }
}

size_t Clutter::squareAt(int64_t x, int64_t y) const {
    const int64_t sx = std::min(x >> kSquareLog2, squaresX_ - 1);
    const int64_t sy = std::min(y >> kSquareLog2, squaresY_ - 1);
    return static_cast<size_t>(sy * squaresX_ + sx);
}

float Clutter::squareHeight(int64_t x, int64_t y) const { return heights_[squareAt(x, y)]; }

/// A crown with a sheer side in each lot of 8 m of a forest, a gabled house in each of 32 m of a
/// village, grass everywhere.
void Clutter::addRow(int64_t x, int64_t y, int width, float* out) const {
    if (isBare_) return;
    for (int i = 0; i < width;) {
        const size_t square = squareAt(x + i, y);
        const Kind kind = kinds_[square];
        const int lotLog2 = kind == Kind::Forest ? 3 : 5;
        const auto size = static_cast<float>(1 << lotLog2);
        const int64_t lot = (x + i) >> lotLog2;
        const int end =
            static_cast<int>(std::min<int64_t>(((lot + 1) << lotLog2) - x, int64_t{width}));
        const uint32_t hash = hashPlace(lot, y >> lotLog2, seed_ + kTreeSeed);
        const float tall = (heights_[square] - kGrass) * (0.5f + 0.5f * unit(hash));
        const float halfX = size * (0.2f + 0.2f * unit(synthetic::mixBits(hash + 1)));
        const float halfY = size * (0.2f + 0.2f * unit(synthetic::mixBits(hash + 2)));
        const float dy = static_cast<float>(y & ((int64_t{1} << lotLog2) - 1)) - size / 2;
        const float v = std::abs(dy) / halfY;
        for (; i < end; ++i) {
            const float dx = static_cast<float>(x + i - (lot << lotLog2)) - size / 2;
            const float u = std::abs(dx) / halfX;
            float z = kGrass * unit(hashPlace(x + i, y, seed_ + kGrassSeed));
            if (kind == Kind::Forest && u * u + v * v < 1)
                z += tall * (0.6f + 0.4f * (1 - u * u - v * v));
            else if (kind == Kind::Houses && u < 1 && v < 1)
                z += tall * (0.6f + 0.4f * (1 - v));
            out[i] += z;
        }
    }
}

}  // namespace terray::bench
