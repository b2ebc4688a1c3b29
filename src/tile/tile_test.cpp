// SPDX-License-Identifier: Apache-2.0
// Tests of the tiling scheme: sizes of the nested lattices.
#include <gtest/gtest.h>

#include "tile/tile_id.h"

namespace terray {
namespace {

TEST(TilingScheme, SmallestTerrainIsOneTile) {
    const TilingScheme scheme{2, 2};
    EXPECT_EQ(scheme.mipCount(), 1);
    EXPECT_EQ(scheme.tileCount(0), 1);
}

TEST(TilingScheme, OneTileHolds513Posts) {
    EXPECT_EQ((TilingScheme{513, 513}).mipCount(), 1);
    const TilingScheme scheme{514, 513};
    EXPECT_EQ(scheme.tilesX(0), 2);
    EXPECT_EQ(scheme.tilesY(0), 1);
    EXPECT_EQ(scheme.mipCount(), 2);
    EXPECT_EQ(scheme.columnsAt(1), 258);
    EXPECT_EQ(scheme.rowsAt(1), 257);
}

TEST(TilingScheme, EveryCoarserLatticeCoversTheFinerOne) {
    for (const int64_t columns : {2, 3, 257, 512, 513, 514, 1021, 1025, 4096, 16384, 99991}) {
        const TilingScheme scheme{columns, 2};
        for (int mip = 0; mip + 1 < scheme.mipCount(); ++mip) {
            const int64_t fine = scheme.columnsAt(mip), coarse = scheme.columnsAt(mip + 1);
            EXPECT_GE(2 * (coarse - 1), fine - 1) << columns << ' ' << mip;
            EXPECT_LE(2 * (coarse - 1), fine) << columns << ' ' << mip;
            EXPECT_EQ(coarse, fine / 2 + 1);
            // Each tile has a parent, and each parent a child.
            EXPECT_EQ(scheme.tilesX(mip + 1), (scheme.tilesX(mip) + 1) / 2);
        }
        EXPECT_EQ(scheme.tileCount(scheme.mipCount() - 1), 1);
    }
}

}  // namespace
}  // namespace terray
