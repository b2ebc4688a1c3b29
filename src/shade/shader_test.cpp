// SPDX-License-Identifier: Apache-2.0
// The shader as a whole: shadows as the oracle sees them, numbers as the surface has them, every
// mode on every pixel, and calm pictures.
#include "shade/shade.h"

#include <gtest/gtest.h>

#include <random>

#include "kernel/height.h"
#include "kernel/scalar/oracle.h"
#include "shade/sun_rays.h"
#include "shade/test_terrain.h"

namespace terray {
namespace {

using test::FunctionSource;
using test::hills;
using test::ShadeScene;

std::vector<Colour> shadedOnce(const ShadeScene& scene, const Shader& shader, Vec2 offset) {
    const auto hits = scene.hits(offset);
    std::vector<Colour> sum(hits.size());
    ShadeCounters counters;
    shader.shadeTile(scene.tile(), offset, hits, 1.0f, sum, counters);
    return sum;
}

std::vector<float> aovOf(const ShadeScene& scene, Aov aov) {
    const auto hits = scene.hits();
    std::vector<float> out(hits.size() * static_cast<size_t>(aovChannels(aov)));
    scene.shader()->fillAov(aov, scene.tile(), hits, out);
    return out;
}

TEST(ShaderAov, ShadowIsWhatTheOracleSays) {
    const FunctionSource source(700, 600, 30, hills);
    ShadeScene scene(source, cameraOver(source, 96, 64), 1.7, 6.8e-8);
    const auto hits = scene.hits();
    const auto shadow = aovOf(scene, Aov::Shadow);
    const SunDirection sun = SunRays(scene.settings.sun, scene.rays).direction();
    size_t dark = 0, lit = 0;
    for (size_t k = 0; k < hits.size(); ++k) {
        if (!isHit(hits[k])) {
            EXPECT_TRUE(std::isnan(shadow[k]));
            continue;
        }
        const auto place = hitPlace(scene.cut.cut(), hits[k]);
        const Ray ray = sun.rayFrom(place.i, place.j, hitHeight(scene.cut.cut(), hits[k]));
        EXPECT_EQ(shadow[k] == 0.0f, oracle::occluded(scene.cut.cut(), hits[k], ray)) << k;
        (shadow[k] == 0.0f ? dark : lit) += 1;
    }
    EXPECT_GT(dark, 100u);
    EXPECT_GT(lit, 1000u);
}

TEST(ShaderAov, NumbersAgreeWithTheSurface) {
    const FunctionSource source(300, 280, 10, hills);
    ShadeScene scene(source, cameraOver(source, 64, 48), 2.0);
    const auto hits = scene.hits();
    const auto position = aovOf(scene, Aov::Position), normal = aovOf(scene, Aov::Normal);
    const auto height = aovOf(scene, Aov::Height), distance = aovOf(scene, Aov::Distance);
    const auto depth = aovOf(scene, Aov::Depth), error = aovOf(scene, Aov::Error);
    size_t seen = 0;
    for (size_t k = 0; k < hits.size(); ++k) {
        if (!isHit(hits[k])) {
            EXPECT_TRUE(std::isnan(position[3 * k]) && std::isnan(normal[3 * k + 2]) &&
                        std::isnan(height[k]) && std::isnan(depth[k]));
            continue;
        }
        ++seen;
        EXPECT_FLOAT_EQ(position[3 * k + 2], height[k]);
        const Vec3 eye = scene.rays.camera().eye.vec();
        const Vec3 seenAt{position[3 * k], position[3 * k + 1], 2.0 * position[3 * k + 2]};
        EXPECT_NEAR(glm::length(seenAt - eye), distance[k], 1.0);
        EXPECT_NEAR(glm::dot(seenAt - eye, scene.rays.camera().forward), depth[k], 1.0);
        EXPECT_EQ(error[k], 0.0f);
        const double length = std::hypot(normal[3 * k], normal[3 * k + 1], normal[3 * k + 2]);
        EXPECT_NEAR(length, 1, 1e-5);
    }
    EXPECT_GT(seen, 1000u);
}

TEST(ShaderAov, ConstantCellsAreBlocksWithUprightWalls) {
    const FunctionSource source(120, 110, 10, hills);
    ShadeScene scene(source, cameraOver(source, 96, 64));
    scene.cut = finestCut(*scene.terrain, kSurfaceConstant);
    const auto hits = scene.hits();
    const auto position = aovOf(scene, Aov::Position), normal = aovOf(scene, Aov::Normal);
    const auto height = aovOf(scene, Aov::Height), distance = aovOf(scene, Aov::Distance);
    const Camera& camera = scene.rays.camera();
    size_t walls = 0, tops = 0;
    for (size_t k = 0; k < hits.size(); ++k) {
        if (!isHit(hits[k])) continue;
        const auto x = static_cast<int>(k) % camera.width, y = static_cast<int>(k) / camera.width;
        const WorldRay ray = camera.rayThrough(x + 0.5, y + 0.5);
        const Vec3 at = ray.origin.vec() + static_cast<double>(distance[k]) * ray.direction;
        EXPECT_NEAR(height[k], at.z, 0.01);
        EXPECT_EQ(position[3 * k + 2], height[k]);
        const Vec3 n{normal[3 * k], normal[3 * k + 1], normal[3 * k + 2]};
        EXPECT_NEAR(glm::length(n), 1, 1e-6);
        if (hits[k].flags & kHitStrip) {
            ++walls;
            EXPECT_EQ(n.z, 0);
            EXPECT_LT(glm::dot(n, ray.direction), 0);
        } else {
            ++tops;
            EXPECT_EQ(n.z, 1);
        }
    }
    EXPECT_GT(walls, 200u);
    EXPECT_GT(tops, 1000u);
}

TEST(Shader, EveryModeColoursEveryPixel) {
    const FunctionSource source(300, 280, 10, hills);
    ShadeScene scene(source, cameraOver(source, 40, 30));
    scene.settings.options.contoursM = 20;
    Photo photo;
    photo.width = photo.height = 2;
    photo.rgba.assign(16, 200);
    photo.worldFromPixel = {source.info().worldFromLattice.origin, {1000, 0}, {0, -1000}};
    for (int mode = 0; mode <= static_cast<int>(Shading::Light); ++mode) {
        scene.settings.shading = static_cast<Shading>(mode);
        const auto shader = scene.shader(&photo);
        ASSERT_NE(shader, nullptr);
        for (const Colour& c : shadedOnce(scene, *shader, {0.5, 0.5})) {
            EXPECT_TRUE(c.r >= 0 && c.g >= 0 && c.b >= 0) << mode;
            EXPECT_EQ(c.a, 1.0f);
        }
    }
}

TEST(Shader, PhotoWithoutAPhotoIsAUsageError) {
    const FunctionSource source(20, 20, 10, hills);
    ShadeScene scene(source, cameraOver(source, 4, 4));
    scene.settings.shading = Shading::Photo;
    const auto made =
        Shader::make(*scene.terrain, scene.cut.cut(), scene.rays, nullptr, scene.settings);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::Usage);
}

TEST(Shader, TransparentBackgroundIsNothingAndAColourIsThatColour) {
    const FunctionSource source(20, 20, 10, hills);
    Camera up = cameraOver(source, 8, 8);
    up.forward = {0, 0, 1};
    up.up = {0, -1, 0};
    ShadeScene scene(source, up);
    scene.settings.options.background = "transparent";
    for (const Colour& c : shadedOnce(scene, *scene.shader(), {0.5, 0.5})) EXPECT_EQ(c.a, 0.0f);
    scene.settings.options.background = "#204060";
    const auto shader = scene.shader();
    std::vector<uint8_t> rgba(8 * 8 * 4);
    shader->toDisplay(shadedOnce(scene, *shader, {0.5, 0.5}), rgba);
    EXPECT_EQ(rgba[0], 0x20);
    EXPECT_EQ(rgba[1], 0x40);
    EXPECT_EQ(rgba[2], 0x60);
}

TEST(Shader, ThePlinthFillsUnderTheRimAndHidesNoGround) {
    const FunctionSource source(80, 80, 10, hills);
    Camera camera = cameraOver(source, 64, 48);
    camera.eye.y -= 600;
    ShadeScene scene(source, camera);
    scene.settings.shading = Shading::Light;
    scene.settings.options.background = "transparent";
    const auto hits = scene.hits();
    const auto bare = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    scene.settings.options.base = true;
    const auto based = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    size_t filled = 0;
    for (size_t k = 0; k < hits.size(); ++k) {
        const bool seenFromAbove = isHit(hits[k]) && !(hits[k].flags & kHitFromBelow);
        if (seenFromAbove) {
            EXPECT_EQ(bare[k].g, based[k].g) << k;
        }
        filled += bare[k].a == 0 && based[k].a > 0;
    }
    EXPECT_GT(filled, 20u);
}

TEST(Shader, VoidsThatGroundSurroundsShowNoSky) {
    const auto surrounded = [](int64_t i, int64_t j) {
        return std::hypot(static_cast<double>(i - 90), static_cast<double>(j - 70)) < 12;
    };
    const FunctionSource whole(180, 150, 10, hills);
    const FunctionSource source(180, 150, 10, [&](int64_t i, int64_t j) {
        return surrounded(i, j) ? std::numeric_limits<double>::quiet_NaN() : hills(i, j);
    });
    const Camera camera = cameraOver(source, 96, 80);
    ShadeScene scene(source, camera);
    const ShadeScene full(whole, camera);
    const auto hits = scene.hits(), groundThere = full.hits();
    const auto drawn = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    const auto sky = shadedOnce(full, *full.shader(), {0.5, 0.5});
    scene.settings.options.background = "#ff0000";
    const auto red = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    size_t voids = 0, beside = 0;
    for (size_t k = 0; k < hits.size(); ++k) {
        if (isHit(hits[k])) continue;
        EXPECT_EQ(red[k].g, 0.0f);  // asked for: shown as it is, through voids as well
        if (isHit(groundThere[k])) {
            EXPECT_LT(drawn[k].b, 1.1f * drawn[k].r);
            EXPECT_LT(drawn[k].g, 0.6f);
            ++voids;
        } else {
            EXPECT_EQ(drawn[k].g, sky[k].g);
            ++beside;
        }
    }
    EXPECT_GT(voids, 20u);
    EXPECT_GT(beside, 500u);
}

TEST(Shader, ShadowsDarkenButStayReadable) {
    // A wall along the west throws a shadow on level ground.
    const FunctionSource source(200, 200, 10,
                                [](int64_t i, int64_t) { return i < 60 ? 400. : 0.; });
    ShadeScene scene(source, cameraOver(source, 64, 48));
    scene.settings.options.samples = 1;
    scene.settings.options.hazeKm = 0;
    scene.settings.shading = Shading::Light;
    const auto with = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    scene.settings.options.shadows = false;
    const auto without = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    size_t darker = 0;
    for (size_t k = 0; k < with.size(); ++k) {
        EXPECT_LE(with[k].g, without[k].g);
        if (with[k].g > 0.7f * without[k].g) continue;
        ++darker;
        EXPECT_GT(with[k].g, 0.05f);
        EXPECT_GT(with[k].b / without[k].b, with[k].r / without[k].r);  // shadows are cooler
    }
    EXPECT_GT(darker, 50u);
}

/// With so many pixels the sun is swept; the picture is the one of cast shadow rays.
TEST(Shader, SweptShadowsAreCastShadows) {
    const FunctionSource source(400, 300, 30, hills);
    ShadeScene scene(source, cameraOver(source, 256, 192), 1.3, 6.8e-8);
    scene.settings.shading = Shading::Light;
    scene.settings.options.samples = 2;
    scene.settings.sunSweeps = std::make_shared<SunSweepCache>(2 * SunSweep::bytesFor(1));
    const SunRays sunRays(scene.settings.sun, scene.rays);
    const auto withShadows = scene.shader();
    scene.settings.options.shadows = false;
    const auto without = scene.shader();
    int dark = 0;
    for (const Vec2 offset : {Vec2{0.25, 0.25}, Vec2{0.75, 0.75}}) {
        const auto hits = scene.hits(offset);
        const auto shaded = shadedOnce(scene, *withShadows, offset);
        const auto bare = shadedOnce(scene, *without, offset);
        const SunDirection sun = sunRays.direction(2.0 * (offset - Vec2{0.5, 0.5}));
        const auto sweep = scene.settings.sunSweeps->get(scene.cut.cut(), sun);
        ASSERT_TRUE(sweep);
        EXPECT_EQ(sweep, scene.settings.sunSweeps->get(scene.cut.cut(), sun));
        for (size_t k = 0; k < hits.size(); ++k) {
            if (!isHit(hits[k])) continue;
            const auto place = hitPlace(scene.cut.cut(), hits[k]);
            const auto height = static_cast<float>(hitHeight(scene.cut.cut(), hits[k]));
            const Ray ray = sun.rayFrom(place.i, place.j, static_cast<double>(height));
            uint8_t cast = 0;
            TraceCounters traced;
            occluded(scene.cut.cut(), {&hits[k], 1}, {&ray, 1}, {&cast, 1}, traced);
            if (cast == 0) {
                EXPECT_EQ(shaded[k].g, bare[k].g) << k;
            } else {
                EXPECT_LE(shaded[k].g, bare[k].g) << k;
                dark += shaded[k].g < bare[k].g ? 1 : 0;
            }
        }
    }
    EXPECT_GT(dark, 1000);
}

/// The way without sums gives the bytes of the way with them.
TEST(Shader, ShowsAtOnceWhatSumsWouldShow) {
    const FunctionSource source(300, 280, 10, hills);
    ShadeScene scene(source, cameraOver(source, 97, 61));
    const auto hits = scene.hits();
    size_t seen = 0, missed = 0;
    for (const Hit& hit : hits) ++(isHit(hit) ? seen : missed);
    EXPECT_GT(seen, 1000u);
    EXPECT_GT(missed, 100u);
    for (const char* background : {"transparent", "sky", "#804020"}) {
        for (const Shading shading : {Shading::Ramp, Shading::Light, Shading::Hillshade}) {
            scene.settings.options.background = background;
            scene.settings.shading = shading;
            const auto shader = scene.shader();
            ASSERT_NE(shader, nullptr);
            ShadeCounters counters;
            std::vector<Colour> sum(hits.size());
            shader->shadeTile(scene.tile(), {0.5, 0.5}, hits, 1.0f, sum, counters);
            std::vector<uint8_t> resolved(4 * hits.size()), shown(4 * hits.size(), 77);
            shader->toDisplay(sum, resolved);
            shader->showTile(scene.tile(), {0.5, 0.5}, hits, shown, counters);
            EXPECT_EQ(resolved, shown) << background << " " << static_cast<int>(shading);
        }
    }
}

TEST(Shader, FarRoughGroundIsCalm) {
    // White noise of two metres on a plain, seen from so far that a pixel holds hundreds of posts.
    std::mt19937 random(8);
    std::vector<float> noise(1024 * 1024);
    for (float& v : noise) v = static_cast<float>(random() % 1000) * 0.002f;
    const FunctionSource source(1024, 1024, 10, [&](int64_t i, int64_t j) {
        return static_cast<double>(noise[static_cast<size_t>(j * 1024 + i)]);
    });
    Camera camera = cameraOver(source, 24, 16);
    camera.eye.z += 30000;
    camera.forward = {0, 0, -1};
    camera.up = {0, 1, 0};
    camera.tanHalfFovY = 0.05;
    camera.eye.y += 0.7 * 10240;
    ShadeScene scene(source, camera);
    scene.settings.options.shadows = false;
    scene.settings.shading = Shading::Light;
    const auto picture = shadedOnce(scene, *scene.shader(), {0.5, 0.5});
    float low = 10, high = 0;
    for (const Colour& c : picture) low = std::min(low, c.g), high = std::max(high, c.g);
    EXPECT_LT(high - low, 0.15f * high);
}

TEST(SunRays, AreTranslatesOfOneParabola) {
    const FunctionSource source(100, 100, 1000, hills);
    const RayFrame rays(cameraOver(source, 8, 8), source.info().worldFromLattice, 3.0, 6.8e-8);
    Sun sun;
    sun.towards = glm::normalize(Vec3{-0.6, 0.5, 0.2});
    sun.centre = {520000, 3970000};
    const SunRays sunRays(sun, rays);
    for (const Vec2 onDisc : {Vec2{0, 0}, Vec2{1, -0.7}}) {
        const SunDirection toSun = sunRays.direction(onDisc);
        const Ray from = toSun.rayFrom(50, 40, 1200);
        const double t = 25000;
        const double i = from.x + from.dx * t, j = from.y + from.dy * t;
        const double z = from.z + from.dz * t + from.bend * t * t;
        const Ray onward = toSun.rayFrom(i, j, z);
        EXPECT_NEAR(onward.dx, from.dx, 1e-12);
        EXPECT_NEAR(onward.dz, from.dz + 2 * from.bend * t, 1e-12);
        EXPECT_NEAR(onward.bend, from.bend, 1e-18);
        EXPECT_GT(from.bend, 0);
    }
}

}  // namespace
}  // namespace terray
