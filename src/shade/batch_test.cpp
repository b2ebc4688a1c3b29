// SPDX-License-Identifier: Apache-2.0
// Batches say what the rules say one by one, for whatever lies in them, and whatever the image
// tile.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "kernel/height.h"
#include "kernel/test_cuts.h"
#include "shade/deferred.h"
#include "shade/ramp_builtin.h"
#include "shade/rules/exp.h"
#include "shade/shade_cache.h"
#include "shade/test_terrain.h"

namespace terray {
namespace {

using test::FunctionSource;
using test::hills;
using test::ShadeScene;

TEST(Rules, ExponentialIsTheLibrarys) {
    for (float x = 0; x > -80; x -= 0.0137f)
        EXPECT_NEAR(rules::expOf(x) / std::exp(x), 1.0f, 4e-7f - 1.5e-7f * x) << x;
    EXPECT_EQ(rules::expOf(0), 1.0f);
    EXPECT_LT(rules::expOf(-1e9f), 1e-37f);
}

/// A place in a cell of a mip, as hits give it: u may be 1.
void setPlace(Places& places, int k, double i, double j, int mip) {
    const int cell = 1 << mip;
    places.x[k] = static_cast<int32_t>(i) / cell * cell;
    places.y[k] = static_cast<int32_t>(j) / cell * cell;
    if (k % 3 == 0 && i == 1099) places.x[k] -= cell;
    places.dx[k] = static_cast<float>(i - places.x[k]);
    places.dy[k] = static_cast<float>(j - places.y[k]);
}

/// Places of a batch over a terrain of 1100 x 700 posts: anywhere, beside tile borders, at the rim.
void randomPlaces(std::mt19937& random, Places& places, Floats& footprint) {
    std::uniform_real_distribution<double> x(0, 1099), y(0, 699), near(-2, 2), width(-2, 6);
    for (int k = 0; k < kBatch; ++k) {
        const double i = k % 4 == 1 ? 512 + near(random) : k % 16 == 2 ? 1099 : x(random);
        const double j = k % 4 == 3 ? 512 + near(random) : k % 16 == 6 ? 0 : y(random);
        setPlace(places, k, i, j, k % 5);
        footprint[k] = static_cast<float>(std::exp2(width(random)));
    }
}

TEST(Batch, GradientsEqualThoseOnePlaceAtATime) {
    for (const bool int16 : {true, false}) {
        test::Heights heights = test::roughTerrain(1100, 700, 400, 9);
        heights.at(300, 300) = heights.at(511, 200) = std::numeric_limits<float>::quiet_NaN();
        const test::TestCut cut(heights, {.int16 = int16});
        const FilteredGradient filtered(cut.cut(), {1100, 700});
        std::mt19937 random(4);
        for (int round = 0; round < 60; ++round) {
            Places places;
            Floats footprint;
            Floats2 gradient;
            randomPlaces(random, places, footprint);
            setPlace(places, 0, 299.5, 299.5, 0);  // a cell that is a hole
            for (int k = 0; k < kBatch; ++k) gradient.x[k] = gradient.y[k] = 7;
            filtered.at(places, footprint, gradient);
            for (int k = 0; k < kBatch; ++k) {
                glm::vec2 one{7, 7};
                filtered.at(places.i(k), places.j(k), footprint[k], one);
                const float slack = 1e-4f * (1 + glm::length(one));
                EXPECT_NEAR(gradient.x[k], one.x, slack) << places.i(k) << " " << places.j(k);
                EXPECT_NEAR(gradient.y[k], one.y, slack) << places.i(k) << " " << places.j(k);
            }
        }
    }
}

TEST(Batch, SkyLightEqualsThatOfOnePlace) {
    const test::TestCut cut(test::roughTerrain(1100, 700, 400, 9), {.int16 = true});
    const Affine2 map{{0, 0}, {10, 0}, {0, -10}};
    const SkyLight sky(makeOverview(cut.cut(), {1100, 700}, 400'000), map, 1.5);
    std::mt19937 random(5);
    for (int round = 0; round < 40; ++round) {
        Places places;
        Floats footprint, open;
        randomPlaces(random, places, footprint);
        sky.at(places, footprint, open);
        for (int k = 0; k < kBatch; ++k)
            EXPECT_NEAR(open[k], sky.at(places.i(k), places.j(k), footprint[k]), 1e-6f);
    }
}

TEST(Batch, TintsEqualTheRamps) {
    HeightSurvey survey;
    survey.minZ = -300;
    survey.maxZ = 2500;
    survey.cumulative = {0, 0.1f, 0.5f, 1};
    survey.sea = true;
    for (const BuiltinRamp& builtin : builtinRamps()) {
        const auto ramp = HeightRamp::make(std::string(builtin.name), survey);
        ASSERT_TRUE(ramp.ok());
        const TintTable table(*ramp, kClay);
        for (float from = -400; from < 2600; from += 64 * 2.1f) {
            Floats height, rock;
            FloatsRgb colour;
            for (int k = 0; k < kBatch; ++k) height[k] = from + static_cast<float>(k) * 2.1f;
            table.at(height, colour, rock);
            for (int k = 0; k < kBatch; ++k) {
                const Tint tint = ramp->at(height[k]);
                EXPECT_NEAR(colour.r[k], tint.colour.r, 3e-5f) << builtin.name << height[k];
                EXPECT_NEAR(colour.g[k], tint.colour.g, 3e-5f);
                EXPECT_NEAR(colour.b[k], tint.colour.b, 3e-5f);
                EXPECT_NEAR(rock[k], tint.rock, 2e-5f);
            }
        }
    }
}

TEST(Batch, GroundStandsWhereTheHitIs) {
    const FunctionSource source(700, 600, 10, hills);
    const ShadeScene scene(source, cameraOver(source, 64, 48), 1.6);
    const GroundSampler sampler(scene.cut.cut(), source.info(), scene.rays, 1.0f, true);
    const auto hits = scene.hits();
    size_t seen = 0;
    for (size_t first = 0; first < hits.size(); first += kBatch) {
        const std::span<const Hit> all(hits);
        const HitBatch batch(all.subspan(first, kBatch));
        if (!batch.some) continue;
        ViewBatch view;
        GroundBatch ground;
        view.setPixels(scene.rays.camera(), scene.tile(), {0.5, 0.5}, first);
        sampler.lookThrough(view);
        sampler.at(batch, view, ground);
        for (int k = 0; k < kBatch; ++k) {
            const Hit& hit = hits[first + static_cast<size_t>(k)];
            if (!isHit(hit)) continue;
            ++seen;
            const LatticePlace place = hitPlace(scene.cut.cut(), hit);
            EXPECT_EQ(ground.place.i(k), place.i);
            EXPECT_EQ(ground.place.j(k), place.j);
            EXPECT_NEAR(ground.height[k], hitHeight(scene.cut.cut(), hit), 1e-3);
            const glm::vec3 look =
                sampler.viewAt(static_cast<double>(k) + 0.5, static_cast<double>(first / 64) + 0.5);
            EXPECT_NEAR(view.direction.x[k], look.x, 1e-5f);
            EXPECT_NEAR(view.direction.z[k], look.z, 1e-5f);
            // A pixel to the right on the ground is a pixel to the right in the picture.
            const Vec2 at = source.info().worldFromLattice.worldFromLattice({place.i, place.j});
            const WorldPoint beside{
                at.x + static_cast<double>(ground.footX.x[k]),
                at.y + static_cast<double>(ground.footX.y[k]),
                1.6 * static_cast<double>(ground.height[k]) -
                    static_cast<double>((ground.normal.x[k] * ground.footX.x[k] +
                                         ground.normal.y[k] * ground.footX.y[k]) /
                                        ground.normal.z[k])};
            const auto seenAt = scene.rays.camera().project(beside);
            ASSERT_TRUE(seenAt);
            const float facing = ground.normal.x[k] * look.x + ground.normal.y[k] * look.y +
                                 ground.normal.z[k] * look.z;
            if (facing > -0.15f) continue;
            EXPECT_NEAR(seenAt->x, static_cast<double>(k) + 1.5, 0.15);
            EXPECT_NEAR(seenAt->y, static_cast<double>(first / 64) + 0.5, 0.15);
        }
    }
    EXPECT_GT(seen, 1000u);
}

TEST(Batch, ColoursDoNotDependOnTheImageTile) {
    const FunctionSource source(300, 280, 10, hills);
    ShadeScene scene(source, cameraOver(source, 97, 61));
    scene.settings.options.contoursM = 20;
    Photo photo;
    photo.width = photo.height = 64;
    photo.rgba.assign(64 * 64 * 4, 255);
    for (size_t k = 0; k < photo.rgba.size(); k += 4)
        photo.rgba[k] = static_cast<uint8_t>(k * 37), photo.rgba[k + 1] = 90;
    photo.worldFromPixel = {source.info().worldFromLattice.origin, {30, 0}, {0, -30}};
    const auto hits = scene.hits();
    for (const Shading shading :
         {Shading::Ramp, Shading::Photo, Shading::Grid, Shading::Hillshade}) {
        scene.settings.shading = shading;
        const auto shader = scene.shader(&photo);
        ASSERT_NE(shader, nullptr);
        ShadeCounters counters;
        std::vector<Colour> all(hits.size());
        shader->shadeTile(scene.tile(), {0.5, 0.5}, hits, 1.0f, all, counters);
        const ImageTile part{13, 7, 41, 30};
        std::vector<Hit> some;
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x)
                some.push_back(hits[static_cast<size_t>((part.y + y) * 97 + part.x + x)]);
        std::vector<Colour> sum(some.size());
        shader->shadeTile(part, {0.5, 0.5}, some, 1.0f, sum, counters);
        for (size_t k = 0; k < sum.size(); ++k) {
            const size_t x = k % 41 + 13, y = k / 41 + 7;
            EXPECT_EQ(sum[k].r, all[y * 97 + x].r) << static_cast<int>(shading) << " " << k;
            EXPECT_EQ(sum[k].b, all[y * 97 + x].b);
        }
    }
}

TEST(ShadeCache, SecondFramesAreAsTheFirstAndMakeNothing) {
    const FunctionSource source(300, 280, 10, hills);
    const ShadeScene scene(source, cameraOver(source, 40, 30)),
        tall(source, cameraOver(source, 40, 30), 3);
    ShadeCache cache;
    const auto shaded = [&](const ShadeScene& of, ShadeCache* from, double& skyMs) {
        auto made = Shader::make(*of.terrain, of.cut.cut(), of.rays, nullptr, of.settings, from);
        EXPECT_TRUE(made.ok());
        skyMs = (*made)->skyMs();
        const auto hits = of.hits();
        std::vector<Colour> sum(hits.size());
        ShadeCounters counters;
        (*made)->shadeTile(of.tile(), {0.5, 0.5}, hits, 1.0f, sum, counters);
        return sum;
    };
    double firstMs = 0, secondMs = 1, tallMs = 0, againMs = 1;
    const auto first = shaded(scene, &cache, firstMs), second = shaded(scene, &cache, secondMs);
    const auto stretched = shaded(tall, &cache, tallMs), again = shaded(scene, &cache, againMs);
    const auto alone = shaded(tall, nullptr, againMs);
    EXPECT_GT(firstMs, 0);
    EXPECT_EQ(secondMs, 0);
    EXPECT_GT(tallMs, 0);
    for (size_t k = 0; k < first.size(); ++k) {
        EXPECT_EQ(first[k].g, second[k].g);
        EXPECT_EQ(first[k].g, again[k].g);
        EXPECT_EQ(stretched[k].g, alone[k].g);
    }
}

}  // namespace
}  // namespace terray
