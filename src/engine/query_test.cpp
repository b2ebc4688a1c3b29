// SPDX-License-Identifier: Apache-2.0
// Queries on surfaces whose answers are known: planes, a wall, the bulge of the earth.
#include "terray/query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

namespace terray {
namespace {

namespace fs = std::filesystem;

/// Opens an ASCII grid with posts at (left + column * cell, row * cell), rows counted from the
/// south. z takes metres from the lower left post.
Terrain makeTerrain(int columns, int rows, double cell,
                    const std::function<double(double, double)>& z, const OpenOptions& options = {},
                    double left = 0) {
    const fs::path path = fs::temp_directory_path() /
                          (std::string("terray_query_") +
                           testing::UnitTest::GetInstance()->current_test_info()->name() + ".asc");
    {
        std::ofstream out(path);
        out.precision(12);
        out << "ncols " << columns << "\nnrows " << rows << "\nxllcenter " << left
            << "\nyllcenter 0\ncellsize " << cell << "\nNODATA_value -9999\n";
        for (int row = rows - 1; row >= 0; --row) {
            for (int column = 0; column < columns; ++column)
                out << z(column * cell, row * cell) << ' ';
            out << '\n';
        }
    }
    auto terrain = Terrain::open(path.string(), options);
    fs::remove(path);
    EXPECT_TRUE(terrain.ok()) << terrain.error().message;
    return std::move(terrain).value();
}

double slope(double x, double y) { return 100 + 0.25 * x - 0.125 * y; }

TEST(Query, HeightsOnAPlaneAreThePlane) {
    const Terrain terrain = makeTerrain(65, 33, 8, slope);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> x(0, 512), y(0, 256);
    std::vector<Place> places;
    for (int k = 0; k < 200; ++k) places.push_back({x(random), y(random), {}, false});
    const auto heights = queryHeights(terrain, places);
    ASSERT_TRUE(heights.ok());
    for (size_t k = 0; k < places.size(); ++k)
        EXPECT_NEAR((*heights)[k], slope(places[k].x, places[k].y), 1e-4);
}

TEST(Query, NoGroundIsNaN) {
    const Terrain terrain =
        makeTerrain(9, 9, 1, [](double x, double y) { return x == 4 && y == 4 ? -9999 : 5; });
    const std::vector<Place> places{
        {-1, 3, {}, false}, {3.5, 3.5, {}, false}, {1, 1, {}, false}, {8.1, 8, {}, false}};
    const auto heights = queryHeights(terrain, places);
    ASSERT_TRUE(heights.ok());
    EXPECT_TRUE(std::isnan((*heights)[0]));
    EXPECT_TRUE(std::isnan((*heights)[1]));
    EXPECT_EQ((*heights)[2], 5);
    EXPECT_TRUE(std::isnan((*heights)[3]));
}

TEST(Query, RaysMeetAPlaneWhereTheyShould) {
    const Terrain terrain = makeTerrain(65, 33, 8, slope);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> x(100, 400), y(50, 200), heading(0, 360),
        pitch(-89, -60);
    std::vector<QueryRay> rays;
    for (int k = 0; k < 200; ++k)
        rays.push_back({{x(random), y(random), 20.0, true}, heading(random), pitch(random)});
    const auto hits = queryRays(terrain, rays);
    ASSERT_TRUE(hits.ok()) << hits.error().message;
    const double length = std::sqrt(1 + 0.25 * 0.25 + 0.125 * 0.125);
    for (size_t k = 0; k < rays.size(); ++k) {
        const QueryHit& hit = (*hits)[k];
        ASSERT_TRUE(hit.hit);
        const Place& from = rays[k].origin;
        const double h = rays[k].headingDeg * M_PI / 180, p = rays[k].pitchDeg * M_PI / 180;
        const double dx = std::sin(h) * std::cos(p), dy = std::cos(h) * std::cos(p);
        const double distance = 20 / (0.25 * dx - 0.125 * dy - std::sin(p));
        EXPECT_NEAR(hit.distance, distance, 1e-3);
        EXPECT_NEAR(hit.x, from.x + dx * distance, 1e-3);
        EXPECT_NEAR(hit.y, from.y + dy * distance, 1e-3);
        EXPECT_NEAR(hit.z, slope(hit.x, hit.y), 1e-3);
        EXPECT_NEAR(hit.normalX, -0.25 / length, 1e-5);
        EXPECT_NEAR(hit.normalY, 0.125 / length, 1e-5);
        EXPECT_NEAR(hit.normalZ, 1 / length, 1e-5);
        EXPECT_FALSE(hit.fromBelow);
    }
}

TEST(Query, RaysFromBelowAreMarked) {
    const Terrain terrain = makeTerrain(9, 9, 10, [](double, double) { return 50; });
    const std::vector<QueryRay> rays{{{41, 42, 10.0, false}, 0, 90},
                                     {{41, 42, 60.0, false}, 0, 90}};
    const auto hits = queryRays(terrain, rays);
    ASSERT_TRUE(hits.ok());
    EXPECT_TRUE((*hits)[0].hit && (*hits)[0].fromBelow);
    EXPECT_NEAR((*hits)[0].distance, 40, 1e-3);
    EXPECT_FALSE((*hits)[1].hit);
}

TEST(Query, AWallBlocksUnlessSeenOver) {
    const Terrain terrain =
        makeTerrain(101, 11, 1, [](double x, double) { return x == 50 ? 10 : 0; });
    const std::vector<Place> from{{10, 5, 2.0, true}, {10, 5, 11.0, true}, {10, 5, {}, false}};
    const std::vector<Place> to{{90, 5, 2.0, true}, {90, 5, 11.0, true}, {40, 5, {}, false}};
    for (const bool back : {false, true}) {
        const auto lines =
            back ? queryLinesOfSight(terrain, to, from) : queryLinesOfSight(terrain, from, to);
        ASSERT_TRUE(lines.ok()) << lines.error().message;
        EXPECT_FALSE((*lines)[0].visible);
        EXPECT_NEAR((*lines)[0].distance, 80, 1e-9);
        EXPECT_NEAR((*lines)[0].blockedAt.x, back ? 50.8 : 49.2, 1e-3);
        EXPECT_TRUE((*lines)[1].visible);
        EXPECT_TRUE((*lines)[2].visible) << "level ground does not block itself";
    }
}

TEST(Query, TheEarthBulgesBetweenFarPlaces) {
    // 40 km over a sea: with k = 0 the bulge hides what is below d^2 / 2R on each side of the
    // middle.
    OpenOptions open;
    open.assignCrs = "EPSG:32631";
    const Terrain terrain = makeTerrain(
        101, 11, 400, [](double, double) { return 0; }, open, 480'000);
    const double radius = 6.37e6, half = 20'000;
    const double horizon = half * half / (2 * radius);  // 31.4 m
    QueryOptions options;
    options.refraction = 0;
    for (const auto& [height, visible] :
         {std::pair{horizon * 0.98, false}, std::pair{horizon * 1.02, true}}) {
        const std::vector<Place> a{{480'000, 2000, height, true}}, b{{520'000, 2000, height, true}};
        const auto lines = queryLinesOfSight(terrain, a, b, options);
        ASSERT_TRUE(lines.ok()) << lines.error().message;
        EXPECT_EQ((*lines)[0].visible, visible) << height;
        options.curvature = false;
        const auto flat = queryLinesOfSight(terrain, a, b, options);
        ASSERT_TRUE(flat.ok());
        EXPECT_TRUE((*flat)[0].visible);
        options.curvature = std::nullopt;
    }
}

TEST(Query, ConstantCellsHaveTheirPostsHeight) {
    const Terrain terrain = makeTerrain(9, 9, 10, [](double x, double) { return x; });
    QueryOptions options;
    options.surface = Surface::Constant;
    const std::vector<Place> places{{24.9, 40, {}, false}, {25.1, 40, {}, false}};
    const auto heights = queryHeights(terrain, places, options);
    ASSERT_TRUE(heights.ok());
    EXPECT_EQ((*heights)[0], 20);
    EXPECT_EQ((*heights)[1], 30);
    const std::vector<QueryRay> level{{{11, 40, 25.0, false}, 90, 0}};
    const auto hits = queryRays(terrain, level, options);
    ASSERT_TRUE(hits.ok());
    ASSERT_TRUE((*hits)[0].hit);
    EXPECT_NEAR((*hits)[0].x, 25, 1e-3);
    EXPECT_NEAR((*hits)[0].z, 25, 1e-3);
    EXPECT_NEAR((*hits)[0].normalX, -1, 1e-6);
}

TEST(Query, WrongQuestionsAreUsage) {
    const Terrain terrain = makeTerrain(9, 9, 10, [](double, double) { return 1; });
    const std::vector<Place> one{{10, 10, 1.0, true}}, outside{{-500, 10, 1.0, true}};
    QueryOptions options;
    EXPECT_FALSE(queryLinesOfSight(terrain, one, {}, options).ok());
    EXPECT_FALSE(queryLinesOfSight(terrain, one, outside, options).ok());
    EXPECT_FALSE(queryLinesOfSight(terrain, one, one, options).ok());
    const std::vector<QueryRay> steep{{one[0], 0, 91}};
    EXPECT_FALSE(queryRays(terrain, steep, options).ok());
    options.lonLat = true;
    const auto noCrs = queryHeights(terrain, one, options);
    ASSERT_FALSE(noCrs.ok());
    EXPECT_EQ(noCrs.error().code, ErrorCode::Usage);
    options = {};
    options.curvature = true;
    EXPECT_FALSE(queryHeights(terrain, one, options).ok());
}

}  // namespace
}  // namespace terray
