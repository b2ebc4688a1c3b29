// SPDX-License-Identifier: Apache-2.0
// ray_cast answers with the oracle's hits, whatever the image tile, on synthetic terrains.
#include "technique/ray_cast/ray_cast.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernel/scalar/oracle.h"
#include "raster/synthetic.h"
#include "stream/cut.h"

namespace terray {
namespace {

std::unique_ptr<ResidentTerrain> makeTerrain(bool town) {
    SyntheticOptions options;
    options.columns = 700;
    options.rows = 600;
    options.cell = town ? 1 : 10;
    options.format = town ? PostFormat::Float32 : PostFormat::Int16;
    const auto source = town ? makeTown(options) : makeFractal(options);
    BuildStats stats;
    auto terrain = ResidentTerrain::build(*source, uint64_t{1} << 30, stats);
    EXPECT_TRUE(terrain) << (terrain ? "" : terrain.error().message);
    return std::move(*terrain);
}

RayFrame makeFrame(const ResidentTerrain& terrain, double bend) {
    const TerrainInfo& info = terrain.info();
    const Vec2 centre = info.worldFromLattice.worldFromLattice({350, 300});
    View view;
    view.width = 97;
    view.height = 61;
    view.eye = Place{centre.x, centre.y, static_cast<double>(info.maxZ) * 0.7, false};
    view.headingDeg = 37;
    view.pitchDeg = -12;
    const SceneBox box{{centre.x - 1, centre.y - 1, 0}, {centre.x + 1, centre.y + 1, 1}, 0};
    const auto camera = makeCamera(view, box);
    EXPECT_TRUE(camera) << (camera ? "" : camera.error().message);
    return {*camera, info.worldFromLattice, 1.0, bend};
}

void expectOracleHits(bool town) {
    const auto terrain = makeTerrain(town);
    const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
    const RayFrame frame = makeFrame(*terrain, 6.8e-8);
    const ImageTile tile{5, 3, 83, 51};
    std::vector<Hit> hits(tile.pixelCount());
    TraceCounters counters;
    makeRayCast()->castTile(cut.cut(), frame, tile, {0.5, 0.5}, hits, counters);
    EXPECT_EQ(counters.rays, tile.pixelCount());
    size_t found = 0;
    for (int y = 0; y < tile.height; ++y) {
        for (int x = 0; x < tile.width; ++x) {
            const Hit& hit = hits[static_cast<size_t>(y * tile.width + x)];
            const auto exact =
                oracle::firstHit(cut.cut(), frame.rayThrough(tile.x + x + 0.5, tile.y + y + 0.5));
            ASSERT_EQ(isHit(hit), isHit(exact.hit)) << x << " " << y;
            if (!isHit(hit)) continue;
            ++found;
            EXPECT_EQ(hit.tile, exact.hit.tile);
            EXPECT_EQ(hit.cell, exact.hit.cell);
            EXPECT_NEAR(static_cast<double>(hit.t), exact.t, std::max(1e-3, 1e-5 * exact.t));
        }
    }
    EXPECT_EQ(counters.hits, found);
    EXPECT_GT(found, tile.pixelCount() / 4);
}

TEST(RayCast, EqualsTheOracleOnTheFractal) { expectOracleHits(false); }
TEST(RayCast, EqualsTheOracleOnTheTown) { expectOracleHits(true); }

TEST(RayCast, HitsDoNotDependOnTheImageTile) {
    const auto terrain = makeTerrain(false);
    const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
    const RayFrame frame = makeFrame(*terrain, 0.0);
    const auto technique = makeRayCast();
    TraceCounters counters;
    const ImageTile whole{0, 0, 97, 61}, part{17, 11, 5, 30};
    std::vector<Hit> all(whole.pixelCount()), some(part.pixelCount());
    technique->castTile(cut.cut(), frame, whole, {0.25, 0.75}, all, counters);
    technique->castTile(cut.cut(), frame, part, {0.25, 0.75}, some, counters);
    for (int y = 0; y < part.height; ++y) {
        for (int x = 0; x < part.width; ++x) {
            const Hit& a = all[static_cast<size_t>((part.y + y) * whole.width + part.x + x)];
            const Hit& b = some[static_cast<size_t>(y * part.width + x)];
            ASSERT_EQ(a.flags, b.flags);
            if (!isHit(a)) continue;
            ASSERT_NEAR(a.t, b.t, 1e-6f * a.t);
            ASSERT_EQ(a.cell, b.cell);
        }
    }
}

TEST(Technique, UnknownNameIsAUsageErrorThatNamesTheKnown) {
    const auto made = makeTechnique("voxel_magic");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::Usage);
    EXPECT_NE(made.error().message.find("ray_cast"), std::string::npos);
}

}  // namespace
}  // namespace terray
