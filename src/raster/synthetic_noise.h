// SPDX-License-Identifier: Apache-2.0
// Gradient noise over the post lattice, row by row: integer hashes and plain float arithmetic, so
// the same bits on every machine. Internal to the synthetic sources.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace terray::synthetic {

/// Mixes 32 bits (the finaliser of MurmurHash3, Appleby 2011).
inline uint32_t mixBits(uint32_t h) {
    h ^= h >> 16;
    h *= 0x85ebca6bu;
    h ^= h >> 13;
    h *= 0xc2b2ae35u;
    return h ^ (h >> 16);
}

inline uint32_t hashPlace(int64_t x, int64_t y, uint32_t seed) {
    const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
    return mixBits(column * 0x9e3779b1u + mixBits(row * 0x85ebca77u + seed));
}

/// One octave of Perlin's gradient noise (2002, quintic fade) with a wavelength of 2^log2Length
/// posts, for the columns of one window. Rows are asked for one after the other; values lie within
/// -1..1. The lattice is shifted at random, so that octaves do not vanish at common places.
class NoiseOctave {
public:
    NoiseOctave(int log2Length, uint32_t seed, int64_t column, int64_t width)
        : log2_(log2Length),
          seed_(mixBits(seed ^ (0x9e3779b9u * static_cast<uint32_t>(log2Length + 1)))),
          width_(width) {
        const int64_t mask = (int64_t{1} << log2_) - 1;
        const int64_t start = column + (mixBits(seed_ + 1) & mask);
        shiftY_ = mixBits(seed_ + 2) & mask;
        firstCell_ = start >> log2_;
        firstOffset_ = start & mask;
        const auto corners = static_cast<size_t>(((start + width - 1) >> log2_) - firstCell_ + 2);
        for (auto* array : {&upperX_, &upperY_, &lowerX_, &lowerY_, &slope_, &value_}) {
            array->resize(corners);
        }
        fillTables();
        out_.resize((corners - 1) << log2_);
    }

    /// The noise at the window's columns in one row; valid until the next call.
    const float* row(int64_t rowIndex) {
        prepareRow(rowIndex + shiftY_);
        switch (log2_) {
            case 1: interpolateSmall<2>(); break;
            case 2: interpolateSmall<4>(); break;
            default: interpolate(); break;
        }
        return out_.data() + firstOffset_;
    }

private:
    /// Weights of both corners' slopes and values at each offset inside a cell.
    void fillTables() {
        const int length = 1 << log2_;
        for (int k = 0; k < length; ++k) {
            const float f = static_cast<float>(k) / static_cast<float>(length);
            const float w = f * f * f * (f * (f * 6 - 15) + 10);
            fade_.push_back(w);
            leftSlope_.push_back((1 - w) * f);
            rightSlope_.push_back(w * (f - 1));
        }
    }

    void hashCorners(int64_t cornerRow, std::vector<float>& gx, std::vector<float>& gy) const {
        float* const x = gx.data();
        float* const y = gy.data();
        const auto count = static_cast<int64_t>(gx.size());
        for (int64_t c = 0; c < count; ++c) {
            const uint32_t h = hashPlace(firstCell_ + c, cornerRow, seed_);
            x[c] = static_cast<float>(static_cast<int32_t>(h & 0xffffu) - 32768) * (1.0f / 32768);
            y[c] = static_cast<float>(static_cast<int32_t>(h >> 16) - 32768) * (1.0f / 32768);
        }
    }

    /// Blends the gradients of the corner rows above and below: noise near corner c is
    /// slope_[c] * dx + value_[c] before the fade along x.
    void prepareRow(int64_t y) {
        const int64_t cornerRow = y >> log2_;
        if (!hasRows_ || cornerRow != cornerRow_) {
            if (hasRows_ && cornerRow == cornerRow_ + 1) {
                std::swap(upperX_, lowerX_);
                std::swap(upperY_, lowerY_);
            } else {
                hashCorners(cornerRow, upperX_, upperY_);
            }
            hashCorners(cornerRow + 1, lowerX_, lowerY_);
            cornerRow_ = cornerRow;
            hasRows_ = true;
        }
        const auto k = static_cast<size_t>(y & ((int64_t{1} << log2_) - 1));
        const float w = fade_[k], up = leftSlope_[k], down = rightSlope_[k];
        const size_t count = slope_.size();
        const float* const ax = upperX_.data();
        const float* const ay = upperY_.data();
        const float* const bx = lowerX_.data();
        const float* const by = lowerY_.data();
        float* const slope = slope_.data();
        float* const value = value_.data();
        for (size_t c = 0; c < count; ++c) {
            slope[c] = ax[c] + (bx[c] - ax[c]) * w;
            value[c] = ay[c] * up + by[c] * down;
        }
    }

    template <int kLength>
    void interpolateSmall() {
        const size_t cells = slope_.size() - 1;
        float* out = out_.data();
        for (size_t c = 0; c < cells; ++c, out += kLength) {
            blend(c, 0, kLength, out);
        }
    }

    void interpolate() {
        const int64_t length = int64_t{1} << log2_;
        const int64_t end = firstOffset_ + width_;
        for (int64_t c = 0; c * length < end; ++c) {
            const int64_t from = c == 0 ? firstOffset_ : 0;
            const int64_t to = std::min(length, end - c * length);
            blend(static_cast<size_t>(c), from, to, out_.data() + c * length);
        }
    }

    void blend(size_t cell, int64_t from, int64_t to, float* __restrict out) const {
        const float p0 = slope_[cell], p1 = slope_[cell + 1];
        const float q0 = value_[cell], q1 = value_[cell + 1];
        const float* const left = leftSlope_.data();
        const float* const right = rightSlope_.data();
        const float* const fade = fade_.data();
        for (int64_t k = from; k < to; ++k) {
            out[k] = p0 * left[k] + p1 * right[k] + (q0 + (q1 - q0) * fade[k]);
        }
    }

    int log2_;
    uint32_t seed_;
    int64_t width_, shiftY_ = 0, firstCell_ = 0, firstOffset_ = 0, cornerRow_ = 0;
    bool hasRows_ = false;
    std::vector<float> upperX_, upperY_, lowerX_, lowerY_;  // gradients at the corner rows
    std::vector<float> slope_, value_;                      // blended for the current row
    std::vector<float> fade_, leftSlope_, rightSlope_;      // per offset inside a cell
    std::vector<float> out_;
};

}  // namespace terray::synthetic
