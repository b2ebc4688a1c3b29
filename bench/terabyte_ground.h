// SPDX-License-Identifier: Apache-2.0
// The ground of the simulated terabyte: hills of cubic B-splines under forests, houses and meadows.
// Any post of any mip is made from its place alone, and what coarser mips leave out is bounded by
// theory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace terray::bench {

/// Hills are octaves k = 0 .. kCoarsestOctave: B-spline surfaces over random numbers 2^k metres
/// apart, within -amplitude(k) .. amplitude(k). Mip m has posts 2^m metres apart and the octaves
/// above m (mip 0: all).
constexpr int kCoarsestOctave = 14;
double amplitude(int octave);

/// Largest |hills of mip 0 at a place - bilinear hills of mip m|; of two mips.
double hillsError(int mip, int finestMip);
/// Largest change of all hills over a metre along an axis.
double hillsSlope();

/// Rows of octaves at the posts [x, x + width) of a mip. confined.
class HillRows {
public:
    HillRows(int mip, int firstOctave, int lastOctave, uint32_t seed, int64_t x, int width);
    /// Adds row y to `out`.
    void addRow(int64_t y, float* out);

private:
    struct Octave {
        int log2;  ///< posts between numbers, as a power of two
        float amplitude;
        uint32_t seed;
        int64_t firstCell, cells;
        int64_t heldCell = INT64_MIN;
        std::vector<float> rows[4];  ///< numbers of four rows, from heldCell - 1 on
        std::vector<float> blended;
    };
    void fill(const Octave& octave, int64_t cellRow, std::vector<float>& out) const;
    void hold(Octave& octave, int64_t cellRow) const;

    int64_t x_;
    int width_;
    std::vector<Octave> octaves_;
};

/// What stands on the ground, by squares of 64 m: nothing in it is higher than the square's height,
/// and all of it stands on the hills.
class Clutter {
public:
    /// Metres. Bare: nothing stands anywhere.
    Clutter(int64_t columns, int64_t rows, uint32_t seed, bool isBare);
    /// Metres, of the square of a place in metres.
    float squareHeight(int64_t x, int64_t y) const;
    /// Adds it to the posts of mip 0.
    void addRow(int64_t x, int64_t y, int width, float* out) const;
    int64_t squaresX() const { return squaresX_; }
    int64_t squaresY() const { return squaresY_; }
    const std::vector<float>& heights() const { return heights_; }  ///< of the squares, row by row

private:
    enum class Kind : uint8_t { Meadow, Forest, Houses };
    size_t squareAt(int64_t x, int64_t y) const;

    uint32_t seed_;
    bool isBare_;
    int64_t squaresX_, squaresY_;
    std::vector<float> heights_;
    std::vector<Kind> kinds_;
};

/// Heights are whole multiples of this, as a survey's.
constexpr float kHeightStep = 1.0f / 64;

}  // namespace terray::bench
