// SPDX-License-Identifier: Apache-2.0
// Copies one mip's tiles into a grid.
#include "shade/overview.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/height.h"

namespace terray {

int overviewMip(const TilingScheme& scheme, int64_t mostPosts) {
    int mip = 0;
    while (mip + 1 < scheme.mipCount() && scheme.columnsAt(mip) * scheme.rowsAt(mip) > mostPosts)
        ++mip;
    return mip;
}

Overview makeOverview(const TerrainCut& cut, const TilingScheme& scheme, int64_t mostPosts) {
    Overview view;
    view.mip = overviewMip(scheme, mostPosts);
    view.width = static_cast<int>(scheme.columnsAt(view.mip));
    view.height = static_cast<int>(scheme.rowsAt(view.mip));
    const auto stride = static_cast<size_t>(view.width);
    view.heights.assign(stride * static_cast<size_t>(view.height),
                        std::numeric_limits<float>::quiet_NaN());
    oneapi::tbb::parallel_for(0, scheme.tilesY(view.mip), [&](int tileY) {
        for (int tileX = 0; tileX < scheme.tilesX(view.mip); ++tileX) {
            const int column = tileX * kTileCells, row = tileY * kTileCells;
            const uint32_t slot =
                slotAt(cut, view.mip, int64_t{column} << view.mip, int64_t{row} << view.mip);
            if (slot == kNoSlot) continue;
            const TileDesc& tile = cut.tiles[slot];
            // The last post of a tile is the next one's first; only the last tile writes it.
            const int posts = tileX + 1 == scheme.tilesX(view.mip) ? kTilePosts : kTileCells;
            const int lines = tileY + 1 == scheme.tilesY(view.mip) ? kTilePosts : kTileCells;
            for (int y = 0; y < std::min(lines, view.height - row); ++y) {
                float* out = &view.heights[static_cast<size_t>(row + y) * stride +
                                           static_cast<size_t>(column)];
                for (int x = 0; x < std::min(posts, view.width - column); ++x)
                    out[x] = postHeight(cut, tile, x, y);
            }
        }
    });
    return view;
}

double meanSlope(const Overview& view, const Affine2& worldFromLattice) {
    const double size = static_cast<double>(1 << view.mip);
    const auto perX = static_cast<float>(1.0 / (worldFromLattice.columnLength() * size));
    const auto perY = static_cast<float>(1.0 / (worldFromLattice.rowLength() * size));
    const auto width = static_cast<size_t>(view.width);
    double sum = 0, count = 0;
    for (size_t k = width + 1; k < view.heights.size(); ++k) {
        const float across = (view.heights[k] - view.heights[k - 1]) * perX;
        const float down = (view.heights[k] - view.heights[k - width]) * perY;
        const float slope = std::hypot(across, down);
        if (std::isnan(slope) || k % width == 0) continue;
        sum += static_cast<double>(slope);
        count += 1;
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace terray
