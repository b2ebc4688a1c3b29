// SPDX-License-Identifier: Apache-2.0
// Flight files: what they may say, and the sentence for everything else.
#include "flight/flight_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace terray {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(FlightFile, ReadsKeyFramesAndDirectives) {
    const auto file = parseFlight(
        "\xEF\xBB\xBF# a flight\r\n"
        "crs EPSG:32611  # of X,Y\r\n"
        "clearance 30\n"
        "\n"
        "0   500, 4000, +250.5   350 , -10\n"
        "fov 60\n"
        "  2.5 501,4001,1200 10,-20,5 # turns through north\n"
        "1e1 502,4002,1300 look-at 510,4010\n"
        "11 503,4003,1300 look-at 510,4010,+20",
        "f.txt");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->crs, "EPSG:32611");
    EXPECT_EQ(file->clearance, 30);
    EXPECT_FALSE(file->lonLat);
    ASSERT_EQ(file->keys.size(), 4u);
    const FlightKey& first = file->keys[0];
    EXPECT_EQ(first.line, 5);
    EXPECT_EQ(first.eye.y, 4000);
    EXPECT_EQ(first.eye.z, 250.5);
    EXPECT_TRUE(first.eye.aboveGround);
    EXPECT_EQ(first.headingDeg, 350);
    EXPECT_FALSE(first.fovDeg);
    EXPECT_EQ(file->keys[1].rollDeg, 5);
    EXPECT_EQ(file->keys[1].fovDeg, 60);
    EXPECT_FALSE(file->keys[1].eye.aboveGround);
    EXPECT_EQ(file->keys[2].seconds, 10);
    ASSERT_TRUE(file->keys[2].target);
    EXPECT_FALSE(file->keys[2].target->z);
    EXPECT_TRUE(file->keys[3].target->aboveGround);
}

TEST(FlightFile, TimesMayBeLeftOutWithASpeed) {
    const std::string keys = "- 0,0,+10 0,0\n- 9,9,+10 0,0\n";
    EXPECT_FALSE(parseFlight(keys, "f"));
    EXPECT_TRUE(parseFlight(keys, "f", true));
    const auto file = parseFlight("speed 70\n" + keys, "f");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->speed, 70);
}

struct Bad {
    const char *text, *line, *words;
};

class BadFlightFile : public testing::TestWithParam<Bad> {};

TEST_P(BadFlightFile, IsRefusedWithItsLine) {
    const auto file = parseFlight(GetParam().text, "f.txt");
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().code, ErrorCode::Input);
    EXPECT_THAT(file.error().message, StartsWith(std::string("f.txt:") + GetParam().line + ": "));
    EXPECT_THAT(file.error().message, HasSubstr(GetParam().words));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadFlightFile,
    testing::Values(
        Bad{"", "1", "no key frame"}, Bad{"# nothing\n\n", "2", "no key frame"},
        Bad{"\n0 1,2,3 0,0\n", "2", "one key frame"},
        Bad{"0 1,2,3 0,0\n0 2,2,3 0,0\n", "2", "must increase"},
        Bad{"5 1,2,3 0,0\n4 2,2,3 0,0\n", "2", "must increase"},
        Bad{"nan 1,2,3 0,0\n", "1", "neither a key frame"}, Bad{"0 nan,2,3 0,0\n", "1", "no place"},
        Bad{"0 1,2,inf 0,0\n", "1", "no height"}, Bad{"0 1,2 0,0\n", "1", "no place"},
        Bad{"0 1,2,3,4 0,0\n", "1", "no place"}, Bad{"0 1,,3 0,0\n", "1", "no place"},
        Bad{"0 1,2,++3 0,0\n", "1", "no height"}, Bad{"1x 1,2,3 0,0\n", "1", "no time"},
        Bad{"1e99 1,2,3 0,0\n", "1", "no time"}, Bad{"- 1,2,3 0,0\n", "1", "time is missing"},
        Bad{"0 1,2,3\n", "1", "no key frame"}, Bad{"0 1,2,3 0,0 9\n", "1", "no key frame"},
        Bad{"0 1,2,3 0\n", "1", "no direction"}, Bad{"0 1,2,3 0,-91\n", "1", "pitch"},
        Bad{"0 1,2,3 721,0\n", "1", "heading"}, Bad{"0 1,2,3 0,0,400\n", "1", "roll"},
        Bad{"0 1,2,3 0,nan\n", "1", "no direction"}, Bad{"0 1,2,3 look-at 1\n", "1", "no place"},
        Bad{"0 1,2,3 look-to 1,2\n", "1", "no key frame"}, Bad{"zoom 3\n", "1", "'zoom'"},
        Bad{"fov\n", "1", "one value"}, Bad{"fov 180\n", "1", "fov"}, Bad{"fov nan\n", "1", "fov"},
        Bad{"speed 0\n", "1", "speed"}, Bad{"speed 5\nspeed 6\n", "2", "twice"},
        Bad{"lonlat yes\n", "1", "no value"}, Bad{"lonlat\ncrs EPSG:4326\n", "2", "leave one"},
        Bad{"0 1,2,3 0,0\ncrs EPSG:4326\n", "2", "above the first"}));

TEST(FlightFile, AnyBytesAreRefusedOrReadButNeverMore) {
    const std::string alphabet = "0123456789.,+- \t\n#eEnaflook-tspdcr";
    std::mt19937 random(11);
    for (int round = 0; round < 2000; ++round) {
        std::string text;
        for (auto k = random() % 200; k > 0; --k) text += alphabet[random() % alphabet.size()];
        const auto file = parseFlight(text, "f");
        if (file) {
            EXPECT_GE(file->keys.size(), 2u);
        } else {
            EXPECT_EQ(file.error().code, ErrorCode::Input);
        }
    }
    EXPECT_FALSE(parseFlight(std::string(100'000, '7'), "f"));
}

TEST(FlightFile, OnlyTextOfReasonableSizeIsRead) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(testing::TempDir()) / "terray_flight_file";
    fs::create_directories(folder);
    const std::string path = (folder / "f.txt").string();
    EXPECT_THAT(readFlightText(path).error().message, HasSubstr("no such"));
    EXPECT_THAT(readFlightText(folder.string()).error().message, HasSubstr("folder"));
    std::ofstream(path, std::ios::binary) << std::string("0 1\0 2", 6);
    EXPECT_THAT(readFlightText(path).error().message, HasSubstr("no text"));
    fs::resize_file(path, uint64_t{1} << 40);  // sparse
    EXPECT_THAT(readFlightText(path).error().message, HasSubstr("MiB"));
    std::ofstream(path, std::ios::binary) << "fov 3";
    EXPECT_EQ(readFlightText(path).value(), "fov 3");
    fs::remove_all(folder);
}

}  // namespace
}  // namespace terray
