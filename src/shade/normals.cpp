// SPDX-License-Identifier: Apache-2.0
// Gathers 4 x 4 posts of a mip, across tile borders where needed, and weighs them by the spline.
#include "shade/normals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/height.h"
#include "shade/rules/filter.h"
#include "shade/rules/spline.h"

namespace terray {
namespace {

/// 4 x 4 posts inside one tile; false if one of them is a hole.
bool loadPosts(const TerrainCut& cut, const TileDesc& tile, int x, int y, float (&z)[4][4]) {
    const uint64_t first =
        tile.posts + static_cast<uint64_t>(y) * kPostStride + static_cast<uint64_t>(x);
    if (cut.format == 1) {
        const float* posts = static_cast<const float*>(cut.posts) + first;
        float sum = 0;
        for (int r = 0; r < 4; ++r, posts += kPostStride)
            for (int c = 0; c < 4; ++c) sum += z[r][c] = posts[c];
        return !std::isnan(sum);
    }
    const uint16_t* codes = static_cast<const uint16_t*>(cut.posts) + first;
    unsigned holes = 0;
    for (int r = 0; r < 4; ++r, codes += kPostStride)
        for (int c = 0; c < 4; ++c) {
            holes |= codes[c] == 0xFFFFu;
            z[r][c] = static_cast<float>(codes[c]) * tile.zStep;  // z0 drops out of gradients
        }
    return holes == 0;
}

/// Continues the surface straight on where an outer post is missing; false if an inner one is.
bool fillOuter(float (&z)[4][4]) {
    if (std::isnan(z[1][1] + z[1][2] + z[2][1] + z[2][2])) return false;
    for (int r = 1; r <= 2; ++r) {
        if (std::isnan(z[r][0])) z[r][0] = 2 * z[r][1] - z[r][2];
        if (std::isnan(z[r][3])) z[r][3] = 2 * z[r][2] - z[r][1];
    }
    for (int c = 0; c < 4; ++c) {
        if (std::isnan(z[0][c])) z[0][c] = 2 * z[1][c] - z[2][c];
        if (std::isnan(z[3][c])) z[3][c] = 2 * z[2][c] - z[1][c];
    }
    return true;
}

}  // namespace

FilteredGradient::FilteredGradient(const TerrainCut& cut, const TilingScheme& scheme) : cut_(cut) {
    maxMip_ = scheme.mipCount() - 1;
    for (int mip = 0; mip <= maxMip_; ++mip) {
        columns_[mip] = scheme.columnsAt(mip);
        rows_[mip] = scheme.rowsAt(mip);
        cellsAcross_[mip] = std::ldexp(1.0, -mip);
    }
}

float FilteredGradient::postAt(int mip, int64_t i, int64_t j) const {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    if (i < 0 || j < 0 || i >= columns_[mip] || j >= rows_[mip]) return kNone;
    const int64_t cellI = std::min(i, columns_[mip] - 2), cellJ = std::min(j, rows_[mip] - 2);
    const uint32_t slot = slotAt(cut_, mip, cellI << mip, cellJ << mip);
    if (slot == kNoSlot) return kNone;
    const int x = static_cast<int>(i - (cellI & ~int64_t{kTileCells - 1}));
    const int y = static_cast<int>(j - (cellJ & ~int64_t{kTileCells - 1}));
    return postHeight(cut_, cut_.tiles[slot], x, y);
}

bool FilteredGradient::gather(int mip, int64_t column, int64_t row, float (&z)[4][4]) const {
    const int x = static_cast<int>(column & (kTileCells - 1));
    const int y = static_cast<int>(row & (kTileCells - 1));
    if (x >= 1 && y >= 1 && x <= kTileCells - 2 && y <= kTileCells - 2 &&
        column + 2 < columns_[mip] && row + 2 < rows_[mip]) {
        const uint32_t slot = slotAt(cut_, mip, column << mip, row << mip);
        if (slot == kNoSlot) return false;
        if (loadPosts(cut_, cut_.tiles[slot], x - 1, y - 1, z)) return true;
    }
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) z[r][c] = postAt(mip, column + c - 1, row + r - 1);
    return fillOuter(z);
}

bool FilteredGradient::ofMip(int mip, double i, double j, glm::vec2& gradient) const {
    const double x = i * cellsAcross_[mip], y = j * cellsAcross_[mip];
    const int64_t column = std::clamp<int64_t>(static_cast<int64_t>(x), 0, columns_[mip] - 2);
    const int64_t row = std::clamp<int64_t>(static_cast<int64_t>(y), 0, rows_[mip] - 2);
    float z[4][4];
    if (!gather(mip, column, row, z)) return false;
    const auto across = rules::splineWeights(static_cast<float>(x - static_cast<double>(column)));
    const auto down = rules::splineWeights(static_cast<float>(y - static_cast<double>(row)));
    float dzdi = 0, dzdj = 0;
    for (int r = 0; r < 4; ++r) {
        float value = 0, slope = 0;
        for (int c = 0; c < 4; ++c) {
            value += across.value[c] * z[r][c];
            slope += across.slope[c] * z[r][c];
        }
        dzdi += down.value[r] * slope;
        dzdj += down.slope[r] * value;
    }
    const float perCell = static_cast<float>(cellsAcross_[mip]);
    gradient = {dzdi * perCell, dzdj * perCell};
    return true;
}

bool FilteredGradient::at(double i, double j, float footprint, glm::vec2& gradient) const {
    // The spline itself averages over about two cells, so the mip of half the footprint fits.
    const rules::MipBlend blend = rules::mipBlend(0.5f * footprint, maxMip_);
    glm::vec2 fine{}, coarse{};
    const bool hasFine = blend.coarser < 1.0f && ofMip(blend.mip, i, j, fine);
    const bool hasCoarse = blend.coarser > 0.0f && ofMip(blend.mip + 1, i, j, coarse);
    if (hasFine && hasCoarse) {
        gradient = fine * (1.0f - blend.coarser) + coarse * blend.coarser;
        return true;
    }
    if (hasFine || hasCoarse) {
        gradient = hasFine ? fine : coarse;
        return true;
    }
    int mip = blend.mip;
    while (--mip >= 0)  // beside a hole a finer mip may still have a cell
        if (ofMip(mip, i, j, gradient)) return true;
    return atLate(blend.mip, i, j, gradient);
}

/// Where the tile of a mip has not arrived, a coarser one must do.
bool FilteredGradient::atLate(int mip, double i, double j, glm::vec2& gradient) const {
    const auto column = static_cast<int64_t>(std::clamp<double>(i, 0, cut_.cellsX - 1));
    const auto row = static_cast<int64_t>(std::clamp<double>(j, 0, cut_.cellsY - 1));
    while (mip < maxMip_ && slotAt(cut_, mip, column, row) == kNoSlot)
        if (ofMip(++mip, i, j, gradient)) return true;
    return false;
}

}  // namespace terray
