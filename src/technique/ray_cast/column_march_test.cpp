// SPDX-License-Identifier: Apache-2.0
// Columns march to the oracle's hits: every projection, roll, looks from straight down to straight
// up, holes, cliffs, unlike mips, eyes outside and below, on every SIMD target.
#include "technique/ray_cast/column_march.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kernel/scalar/judge.h"
#include "raster/synthetic.h"
#include "stream/cut.h"
#include "stream/test_source.h"
#include "technique/ray_cast/march_view.h"
#include "technique/ray_cast/neighbours.h"

namespace terray {
namespace {

/// Rough hills at 10 m with cliffs, and holes if asked.
std::unique_ptr<ResidentTerrain> makeGround(PostFormat format, bool holes) {
    const test::ArraySource source(700, 600, format, [holes](int64_t i, int64_t j) {
        const float hill = test::hills(7, holes)(i, j);
        return (i / 40 + j / 50) % 5 == 0 ? hill + 60 : hill;
    });
    return test::built(source);
}

struct Look {
    std::string name;
    View view;
};

/// Eyes relative to the middle of the ground at world (4500, -1000).
Look lookAt(const std::string& name, double east, double north, double z, double heading,
            double pitch, double roll = 0, Projection projection = Projection::Perspective) {
    Look look{name, {}};
    look.view.width = 53;
    look.view.height = 43;
    if (projection == Projection::Perspective) look.view.fovDeg = 50;
    look.view.projection = projection;
    look.view.eye = Place{4500 + east, -1000 + north, z, false};
    look.view.headingDeg = heading;
    look.view.pitchDeg = pitch;
    if (roll != 0) look.view.rollDeg = roll;
    return look;
}

std::vector<Look> looks() {
    std::vector<Look> all{lookAt("level", 0, 0, 640, 20, 0),
                          lookAt("down 15", 300, 500, 900, 140, -15),
                          lookAt("down 45", 0, 0, 1500, 300, -45),
                          lookAt("straight down", 0, 0, 2500, 0, -90),
                          lookAt("straight up", 0, 0, 0, 0, 90),
                          lookAt("rolled", 0, 0, 800, 75, -12, 30),
                          lookAt("upside down", 0, 0, 800, 75, -12, 170),
                          lookAt("on its side", 0, 0, 800, 75, -12, 90),
                          lookAt("from outside", -6000, 1000, 1300, 95, -9),
                          lookAt("from beside, low", -4000, 0, 150, 90, 2),
                          lookAt("from below", 0, 0, -300, 45, 12),
                          lookAt("panorama", 0, 0, 640, 0, -8, 0, Projection::Panorama),
                          lookAt("map", 0, 0, 3000, 0, -90, 0, Projection::Ortho),
                          lookAt("oblique map", 0, 0, 3000, 30, -40, 0, Projection::Ortho)};
    for (Look& look : all)
        if (look.view.projection == Projection::Ortho) {
            look.view.eye.reset();
            look.view.extent = Extent{2000, -3500, 7000, 1500};
        }
    return all;
}

/// Casts the picture in one image tile and holds every pixel against the oracle.
uint64_t expectLikeOracle(const ResidentTerrain& terrain, const Look& look, double tolerance,
                          SurfaceKind surface) {
    SCOPED_TRACE(look.name);
    const SceneBox box{{1000, -4000, 0}, {8000, 2000, 700}, 0};
    const auto camera = makeCamera(look.view, box);
    EXPECT_TRUE(camera) << (camera ? "" : camera.error().message);
    if (!camera) return 0;
    CutOptions options;
    options.tolerancePx = tolerance;
    options.bend = 6.8e-8;
    options.surface = surface;
    const FrameCut cut = selectCut(terrain, *camera, options);
    const RayFrame frame(*camera, terrain.info().worldFromLattice, 1.5, 6.8e-8);
    const ImageTile tile{0, 0, camera->width, camera->height};
    std::vector<Hit> hits(tile.pixelCount());
    TraceCounters counters;
    marchTile(cut.cut(), frame, tile, {0.5, 0.5}, hits, static_cast<size_t>(tile.width), counters);
    EXPECT_EQ(counters.rays, tile.pixelCount());
    uint64_t found = 0;
    int faults = 0;
    for (int y = 0; y < tile.height; ++y) {
        for (int x = 0; x < tile.width; ++x) {
            const Hit& hit = hits[static_cast<size_t>(y * tile.width + x)];
            const Ray ray = frame.rayThrough(x + 0.5, y + 0.5);
            const oracle::ExactHit exact = oracle::firstHit(cut.cut(), ray);
            found += isHit(hit) ? 1 : 0;
            const oracle::Fault fault = oracle::judge(cut.cut(), ray, hit, exact);
            if (oracle::isViolation(fault) && ++faults <= 3)
                ADD_FAILURE() << x << "," << y << " " << oracle::describe(fault, ray, hit, exact);
        }
    }
    EXPECT_EQ(faults, 0);
    EXPECT_EQ(counters.hits, found);
    return counters.columns;
}

class Targets : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override { ASSERT_TRUE(setSimdTarget(GetParam())); }
    void TearDown() override { setSimdTarget(""); }
};

TEST_P(Targets, HitWhatTheOracleHits) {
    const auto terrain = makeGround(PostFormat::Int16, false);
    uint64_t columns = 0;
    for (const Look& look : looks())
        columns += expectLikeOracle(*terrain, look, 0, kSurfaceBilinear);
    EXPECT_GT(columns, looks().size() * 53 * 43 / 2) << "too few rays are shared";
}

TEST_P(Targets, HitWhatTheOracleHitsBesideHoles) {
    const auto terrain = makeGround(PostFormat::Float32, true);
    for (const Look& look : looks()) expectLikeOracle(*terrain, look, 0, kSurfaceBilinear);
}

TEST_P(Targets, HitWhatTheOracleHitsOnUnlikeMips) {
    const auto terrain = makeGround(PostFormat::Int16, false);
    for (const Look& look : looks()) expectLikeOracle(*terrain, look, 12, kSurfaceBilinear);
}

TEST_P(Targets, HitWhatTheOracleHitsOnTriangles) {
    const auto terrain = makeGround(PostFormat::Int16, false);
    for (const Look& look : looks()) expectLikeOracle(*terrain, look, 0, kSurfaceTriangles);
    const auto holey = makeGround(PostFormat::Int16, true);
    for (const Look& look : looks()) expectLikeOracle(*holey, look, 0, kSurfaceTriangles);
}

INSTANTIATE_TEST_SUITE_P(ColumnMarch, Targets, testing::ValuesIn(simdTargets()),
                         [](const auto& target) { return target.param; });

TEST(ColumnMarch, MarchesMostOfAViewOverSmoothGround) {
    SyntheticOptions options;
    options.columns = options.rows = 700;
    options.cell = 10;
    const test::ArraySource source(700, 600, PostFormat::Int16, [](int64_t i, int64_t j) {
        return static_cast<float>(300 + 150 * std::sin(0.02 * static_cast<double>(i)) *
                                            std::cos(0.015 * static_cast<double>(j)));
    });
    const auto terrain = test::built(source);
    const uint64_t pixels = 53 * 43;
    for (const Look& look : {looks()[0], looks()[1], looks()[2], looks()[5]})
        EXPECT_GT(expectLikeOracle(*terrain, look, 0, kSurfaceBilinear), pixels * 9 / 10);
}

RayFrame frameOf(const Look& look) {
    const SceneBox box{{1000, -4000, 0}, {8000, 2000, 700}, 0};
    const auto camera = makeCamera(look.view, box);
    EXPECT_TRUE(camera) << (camera ? "" : camera.error().message);
    return {*camera, {{1000, 2000}, {10, 0}, {0, -10}}, 1.0, 0.0};
}

TEST(Neighbours, StandOneOverTheOtherWhereTheViewIsLevelOrAPanorama) {
    for (const Look& look : {looks()[0], looks()[11]}) {
        const auto n = neighboursOf(frameOf(look), {0.5, 20.5, 52.5, 35.5}, 1, 1);
        ASSERT_TRUE(n);
        EXPECT_TRUE(n->upwards);
        EXPECT_EQ(n->first + n->last, 0);
        EXPECT_TRUE(std::isinf(n->sharp.at));
    }
}

TEST(Neighbours, StandAsideWhereTheViewIsRolled) {
    const auto right =
        neighboursOf(frameOf(lookAt("", 0, 0, 800, 75, 0, 30)), {0.5, 0.5, 52.5, 42.5}, 1, 1);
    const auto left =
        neighboursOf(frameOf(lookAt("", 0, 0, 800, 75, 0, -30)), {0.5, 0.5, 52.5, 42.5}, 1, 1);
    ASSERT_TRUE(right && left);
    EXPECT_EQ(right->left() + right->right(), 1);
    EXPECT_EQ(right->left(), left->right());
    EXPECT_EQ(right->right(), left->left());
    EXPECT_FALSE(std::isinf(right->sharp.at));
}

TEST(Neighbours, TakeSharperGroundToHideAboveRowsFartherBelow) {
    const RayFrame frame = frameOf(looks()[2]);
    const PixelBlock left{0.5, 20.5, 8.5, 30.5};
    const auto next = neighboursOf(frame, left, 1, 1), second = neighboursOf(frame, left, 1, 2);
    ASSERT_TRUE(next && second);
    EXPECT_EQ(second->rows, 2);
    EXPECT_GT(second->last - second->first, 0);
    EXPECT_GT(second->sharp.at, 1.9 * next->sharp.at);
}

TEST(MarchView, GoesSidewaysWhereRowsStandAside) {
    const ImageTile right{40, 18, 12, 8}, above{22, 2, 10, 8};
    const RayFrame down = frameOf(looks()[3]), level = frameOf(looks()[0]);
    EXPECT_TRUE(viewFor(down, right, {0.5, 0.5}).turned);
    EXPECT_FALSE(viewFor(down, above, {0.5, 0.5}).turned);
    EXPECT_FALSE(viewFor(level, right, {0.5, 0.5}).turned);
    EXPECT_TRUE(viewFor(frameOf(looks()[7]), above, {0.5, 0.5}).turned);
}

TEST(MarchView, HasTheSameRays) {
    const RayFrame frame = frameOf(looks()[3]);
    const MarchView view = viewFor(frame, {40, 18, 12, 8}, {0.25, 0.75});
    ASSERT_TRUE(view.turned);
    const Ray a = frame.rayThrough(43.25, 20.75), b = view.rays.rayThrough(view.px(2), view.py(3));
    EXPECT_DOUBLE_EQ(a.dx, b.dx);
    EXPECT_DOUBLE_EQ(a.dy, b.dy);
    EXPECT_DOUBLE_EQ(a.dz, b.dz);
    EXPECT_EQ(view.indexOf(3, 2, 100), size_t{203});
}

TEST(Neighbours, AreNoneWhereTheViewLiesOnItsSide) {
    EXPECT_FALSE(neighboursOf(frameOf(looks()[7]), {0.5, 20.5, 52.5, 35.5}, 1, 1));
}

}  // namespace
}  // namespace terray
