// SPDX-License-Identifier: Apache-2.0
// Flights through key frames and along tracks: where the eye is, how fast, how high, and its turns.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "flight/follow.h"
#include "flight/key_path.h"
#include "flight/track_path.h"

namespace terray {
namespace {

PathKey key(double seconds, Vec3 eye, double heading, double pitch, double roll = 0) {
    PathKey k;
    k.seconds = seconds;
    k.eye = WorldPoint::fromVec(eye);
    k.headingDeg = heading;
    k.pitchDeg = pitch;
    k.rollDeg = roll;
    k.name = "f:1";
    return k;
}

std::vector<PathKey> randomKeys(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-5000, 5000), turn(-360, 720), tilt(-90, 90);
    std::vector<PathKey> keys;
    double t = 0;
    for (int k = 0; k < 8; ++k) {
        keys.push_back(key(t, {5e5 + place(random), 4e6 + place(random), place(random)},
                           turn(random), tilt(random), tilt(random)));
        t += 0.5 + static_cast<double>(random() % 100) * 0.05;
    }
    return keys;
}

double turnBetween(double a, double b) { return std::abs(std::remainder(a - b, 360.0)); }

TEST(KeyPath, IsAtEachKeyFrameInTime) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const auto keys = randomKeys(seed);
        const auto path = makeKeyPath(keys, {});
        ASSERT_TRUE(path);
        EXPECT_EQ((*path)->begin(), keys.front().seconds);
        EXPECT_EQ((*path)->end(), keys.back().seconds);
        for (const PathKey& k : keys) {
            const Pose pose = (*path)->at(k.seconds);
            EXPECT_EQ(pose.eye.vec(), k.eye.vec());
            EXPECT_LT(turnBetween(pose.headingDeg, k.headingDeg), 1e-9);
            EXPECT_EQ(pose.pitchDeg, k.pitchDeg);
            EXPECT_LT(turnBetween(pose.rollDeg, k.rollDeg), 1e-9);
        }
    }
}

TEST(KeyPath, MovesAndTurnsWithoutJumps) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const auto path = makeKeyPath(randomKeys(seed), {});
        ASSERT_TRUE(path);
        constexpr double kStep = 1e-3;
        Pose last = (*path)->at(0);
        for (double t = kStep; t < (*path)->end(); t += kStep) {
            const Pose pose = (*path)->at(t);
            EXPECT_LT(glm::length(pose.eye - last.eye), 130) << t;  // 15 km in half a second, x 3
            EXPECT_LT(turnBetween(pose.headingDeg, last.headingDeg), 1.6) << t;
            EXPECT_LE(std::abs(pose.pitchDeg), 90);
            last = pose;
        }
    }
}

TEST(KeyPath, TurnsTheShorterWay) {
    const auto path = makeKeyPath({key(0, {0, 0, 0}, 350, 0), key(1, {1, 0, 0}, 10, 0),
                                   key(2, {2, 0, 0}, -20, 0), key(3, {3, 0, 0}, 700, 0)},
                                  {});
    ASSERT_TRUE(path);
    for (double t = 0; t <= 3; t += 0.01)
        EXPECT_LE(turnBetween((*path)->at(t).headingDeg, 355), 15 + 1e-9) << t;
    EXPECT_LT(turnBetween((*path)->at(0.5).headingDeg, 0), 8);
}

TEST(KeyPath, ConstantSpeedIsConstant) {
    auto keys = randomKeys(3);
    KeyPathOptions options;
    options.speed = 80;
    const auto path = makeKeyPath(keys, options);
    ASSERT_TRUE(path);
    constexpr double kStep = 0.02;
    Vec3 last = (*path)->at(0).eye.vec();
    EXPECT_EQ(last, keys.front().eye.vec());
    for (double t = kStep; t < (*path)->end(); t += kStep) {
        const Vec3 eye = (*path)->at(t).eye.vec();
        EXPECT_NEAR(glm::length(eye - last) / kStep, 80, 0.5) << t;
        last = eye;
    }
    EXPECT_EQ((*path)->at((*path)->end()).eye.vec(), keys.back().eye.vec());
    keys[2].eye = keys[1].eye;
    EXPECT_FALSE(makeKeyPath(keys, options));
}

TEST(KeyPath, LooksAtMovingTargetsBetweenKeysThatHaveThem) {
    auto keys = randomKeys(4);
    keys[2].target = WorldPoint{1, 2, 3};
    keys[3].target = WorldPoint{11, 2, 3};
    keys[4].target = WorldPoint{11, 2, 3};
    const auto path = makeKeyPath(keys, {});
    ASSERT_TRUE(path);
    const auto targetAt = [&](double t) { return (*path)->at(t).target; };
    EXPECT_FALSE(targetAt(keys[2].seconds - 0.01));
    EXPECT_EQ(targetAt(keys[2].seconds)->x, 1);
    const double middle = targetAt(0.5 * (keys[2].seconds + keys[3].seconds))->x;
    EXPECT_GT(middle, 3);
    EXPECT_LT(middle, 11);
    EXPECT_EQ(targetAt(0.5 * (keys[3].seconds + keys[4].seconds))->x, 11);
    EXPECT_FALSE(targetAt(keys[4].seconds + 0.01));
}

/// Ridges of a kilometre's width, 500 m high, with seeded noise on top.
double roughGround(Vec2 p) {
    const double ridge = 250 * (1 + std::sin(p.x / 160) * std::cos(p.y / 230));
    const double seed = std::sin(std::floor(p.x / 30) * 12.9898 + std::floor(p.y / 30) * 78.233);
    return ridge + 40 * (seed * 43758.5453 - std::floor(seed * 43758.5453));
}

TEST(KeyPath, ClearanceLiftsSmoothlyOverTheGround) {
    KeyPathOptions options;
    options.clearance = 50;
    options.spacing = 10;
    options.ground = roughGround;
    const auto path =
        makeKeyPath({key(0, {0, 0, 300}, 0, 0), key(30, {3000, 900, 300}, 0, 0)}, options);
    ASSERT_TRUE(path);
    bool lifted = false;
    double lastSlope = 0;
    for (double t = 0.1; t < 30; t += 0.1) {
        const Pose pose = (*path)->at(t);
        EXPECT_GE(pose.eye.z - roughGround({pose.eye.x, pose.eye.y}), 50 - 1e-6) << t;
        EXPECT_GE(pose.eye.z, 300 - 1e-9);
        const double slope = (pose.eye.z - (*path)->at(t - 0.1).eye.z) / 0.1;
        EXPECT_LT(std::abs(slope - lastSlope), 40) << t;
        lastSlope = slope;
        lifted = lifted || pose.eye.z > 310;
    }
    EXPECT_TRUE(lifted);
}

TEST(Follow, NeverComesNearerThanHalfTheHeight) {
    std::mt19937 random(3);
    for (int round = 0; round < 50; ++round) {
        std::vector<double> ground;
        double z = 0;
        for (int k = 0; k < 400; ++k) {
            z += static_cast<double>(random() % 61) - 30;
            ground.push_back(random() % 40 == 0 ? z + 700 : z);
        }
        const auto heights = followedHeights(ground, 100, 30);
        for (size_t k = 0; k < ground.size(); ++k) EXPECT_GE(heights[k], ground[k] + 50 - 1e-6);
    }
    const auto level = followedHeights(std::vector<double>(60, 12.0), 100, 30);
    for (const double height : level) EXPECT_NEAR(height, 112, 1e-9);
}

TEST(Follow, BridgesGapsOfTheGround) {
    const auto ground = [](Vec2 p) -> std::optional<double> {
        if (p.x < 10 || (p.x > 20.5 && p.x < 29.5) || p.x > 40) return std::nullopt;
        return p.x < 25 ? 100.0 : 200.0;
    };
    std::vector<Vec2> places;
    for (int k = 0; k <= 50; ++k) places.emplace_back(k, 0);
    const auto along = groundAlong(places, ground, 1);
    ASSERT_EQ(along.size(), 51u);
    EXPECT_EQ(along[0], 100);
    EXPECT_EQ(along[50], 200);
    EXPECT_NEAR(along[25], 150, 11);
    EXPECT_TRUE(groundAlong(
                    places, [](Vec2) { return std::nullopt; }, 1)
                    .empty());
}

std::vector<Vec2> zigzag() {
    std::vector<Vec2> places;
    std::mt19937 random(9);
    for (int k = 0; k <= 60; ++k)
        places.emplace_back(4e5 + 50 * k, 5e6 + (k % 20 < 10 ? 1 : -1) * 40 * (k % 10) +
                                              static_cast<double>(random() % 8));
    return places;
}

TEST(TrackPath, FliesFromEndToEndAtConstantSpeed) {
    TrackPathOptions options;
    options.speed = 50;
    const auto places = zigzag();
    const auto path = makeTrackPath(places, {}, roughGround, options, "t");
    ASSERT_TRUE(path) << path.error().message;
    const auto at = [&](double t) { return (*path)->at(t); };
    EXPECT_LT(glm::length(Vec2(at(0).eye.vec()) - places.front()), 1e-6);
    EXPECT_LT(glm::length(Vec2(at((*path)->end()).eye.vec()) - places.back()), 1e-6);
    for (double t = 1; t < (*path)->end() - 1; t += 0.25) {
        const Vec2 way = Vec2(at(t + 0.05).eye.vec()) - Vec2(at(t - 0.05).eye.vec());
        EXPECT_NEAR(glm::length(way) / 0.1, 50, 2.5) << t;
        EXPECT_LT(turnBetween(at(t).headingDeg, at(t - 0.25).headingDeg), 15) << t;
        const Vec3 eye = at(t).eye.vec();
        EXPECT_GE(eye.z - roughGround({eye.x, eye.y}), 100 - 5) << t;
        EXPECT_LT(std::abs(eye.z - at(t - 0.25).eye.z), 40) << t;
    }
    EXPECT_EQ(at(3).pitchDeg, -10);
}

TEST(TrackPath, LooksAlongTheTrack) {
    TrackPathOptions options;
    options.speed = 30;
    const auto path =
        makeTrackPath({{0, 0}, {1000, 0}, {1000, 1000}}, {}, roughGround, options, "t");
    ASSERT_TRUE(path);
    EXPECT_NEAR((*path)->at(10).headingDeg, 90, 1e-6);
    EXPECT_LT(turnBetween((*path)->at((*path)->end() - 10).headingDeg, 0), 1e-6);
}

TEST(TrackPath, KeepsItsOwnTimesAndRests) {
    const auto path = makeTrackPath({{0, 0}, {1000, 0}, {1000, 0}, {3000, 0}}, {100, 120, 150, 170},
                                    roughGround, {}, "t");
    ASSERT_TRUE(path);
    EXPECT_EQ((*path)->end(), 70);
    EXPECT_NEAR((*path)->at(10).eye.x, 500, 5);
    EXPECT_NEAR((*path)->at(35).eye.x, 1000, 1e-6);
    EXPECT_NEAR((*path)->at(35).headingDeg, 90, 1e-6);
    EXPECT_NEAR((*path)->at(60).eye.x, 2000, 5);
}

TEST(TrackPath, RefusesTracksThatLeadNowhere) {
    TrackPathOptions options;
    options.speed = 30;
    const auto rests = makeTrackPath({{0, 0}, {0.1, 0}}, {}, roughGround, options, "t.gpx");
    ASSERT_FALSE(rests);
    EXPECT_THAT(rests.error().message, testing::HasSubstr("t.gpx"));
    EXPECT_FALSE(makeTrackPath(
        {{0, 0}, {900, 0}}, {}, [](Vec2) { return std::nullopt; }, options, "t"));
}

}  // namespace
}  // namespace terray
