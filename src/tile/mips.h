// SPDX-License-Identifier: Apache-2.0
// Coarser posts and their errors: pure functions on rows of heights, used by bake and by in-memory
// terrains. Holes are NaN everywhere.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/affine.h"

namespace terray {

/// A rectangle of posts; NaN for holes. stride >= width.
struct PostView {
    const float* posts = nullptr;
    int64_t width = 0, height = 0, stride = 0;
};

/// Full-weighting mean [1 2 1] x [1 2 1] / 16 over the valid fine posts around fine post (2i, 2j);
/// NaN where that post is a hole. Places outside the view repeat its edge.
float coarsePost(const PostView& fine, int64_t i, int64_t j);

/// Decoded posts of one whole mip, asked for in pieces of rows.
class PostRows {
public:
    virtual ~PostRows() = default;
    virtual int64_t columns() const = 0;
    virtual int64_t rows() const = 0;
    /// Posts [column, column + count) of a row inside the mip.
    virtual void read(int64_t row, int64_t column, int64_t count, float* out) const = 0;
};

/// Rounds of fitting after the full-weighting mean. Each moves a post by half of the mid-range of
/// the residuals at the 3 x 3 finer posts around it (docs/lod.md has the measured gain).
constexpr int kFitRounds = 4;

/// Makes coarse posts window by window. A post's value depends on its place alone, not on the
/// window it is made in, so windows may overlap and run on many threads. confined (scratch).
class CoarseFitter {
public:
    explicit CoarseFitter(int rounds = kFitRounds) : rounds_(rounds) {}
    /// Coarse posts [column, column + width) x [row, row + height) of the next mip, into out, row
    /// by row. The window lies inside the coarse lattice, ceil((N - 1) / 2) + 1 posts a side.
    void fit(const PostRows& fine, int64_t column, int64_t row, int width, int height, float* out,
             int64_t stride);

private:
    void load(const PostRows& fine);
    void start();
    void hideRepeated(const PostRows& fine);
    void improve();
    float* coarseRow(int j) { return coarse_.data() + (j + 1) * pitch_ + 1; }
    float* evenRow(int k) { return even_.data() + k * pitch_ + 1; }  ///< fine columns 2I
    float* oddRow(int k) { return odd_.data() + k * pitch_ + 1; }    ///< fine columns 2I + 1

    int rounds_;
    int64_t column0_ = 0, row0_ = 0;  ///< first post of the window with its halo
    int width_ = 0, height_ = 0;
    ptrdiff_t pitch_ = 0;
    std::vector<float> coarse_, even_, odd_, line_, scratch_;
};

/// Compares a coarse surface with the posts of a finer mip. Both are bilinear on nested lattices,
/// so their largest difference is reached at a finer post: exact, no sampling. confined (scratch).
class SurfaceComparer {
public:
    /// Over the coarse cells [column, column + cellsX) x [row, row + cellsY), `shift` mips above
    /// `fine`: largest |coarse surface - fine post| for each fine column, from the first cell's
    /// left to the last one's right edge (or the fine mip's). Fine posts on holes of either surface
    /// count for nothing. Valid until the next call.
    std::span<const float> compare(const PostRows& coarse, const PostRows& fine, int shift,
                                   int64_t column, int64_t row, int cellsX, int cellsY);

private:
    std::vector<float> coarse_, line_, up_, fine_, scratch_, worst_;
};
/// Bound on what rounding may hide in such a difference at heights up to `magnitude`.
float differenceRounding(float magnitude, int shift);

/// Steps of the cells of a block.
struct CellSteps {
    float alongRow = 0, alongColumn = 0;  ///< largest |height difference| along cell edges, metres
    float cellRange = 0;                  ///< largest height range of a cell, metres
    bool hasHoles = false;                ///< some cell is a hole
};
/// For cells [0, cellsX) x [0, cellsY), cellsX <= 64; posts are (cellsX + 1) x (cellsY + 1).
CellSteps measureCells(const float* posts, int64_t stride, int cellsX, int cellsY);

/// Upper bound of the world slope (rise over run) of bilinear cells of a mip with these steps.
float maxWorldSlope(const CellSteps& steps, const Affine2& worldFromLattice, int mip);

}  // namespace terray
