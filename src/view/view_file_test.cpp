// SPDX-License-Identifier: Apache-2.0
// Tests of camera files: every key, and one clear sentence for every mistake.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "terray/view.h"

namespace terray {
namespace {

class ViewFile : public testing::Test {
protected:
    void SetUp() override {
        folder_ = testing::TempDir() + "view_file_" +
                  testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string fileOf(const std::string& text) const {
        std::ofstream(folder_ + "/camera.json") << text;
        return folder_ + "/camera.json";
    }
    std::string errorOf(const std::string& text) const {
        const Result<View> view = readView(fileOf(text));
        if (view.ok()) return "";
        EXPECT_EQ(view.error().code, ErrorCode::Input);
        EXPECT_THAT(view.error().message, testing::HasSubstr("camera.json"));
        return view.error().message;
    }
    std::string folder_;
};

TEST_F(ViewFile, ReadsEveryKey) {
    const Result<View> view = readView(fileOf(
        R"({"eye": [1.5, 2, "+30"], "heading": 90, "pitch": -12.5, "roll": 3, "fov": 60,
            "projection": "panorama", "size": [800, 600], "extent": [0, 1, 2, 3], "lonlat": true})"));
    ASSERT_TRUE(view.ok()) << view.error().message;
    ASSERT_TRUE(view->eye);
    EXPECT_EQ(view->eye->x, 1.5);
    EXPECT_EQ(view->eye->y, 2);
    EXPECT_EQ(view->eye->z, 30);
    EXPECT_TRUE(view->eye->aboveGround);
    EXPECT_EQ(view->headingDeg, 90);
    EXPECT_EQ(view->pitchDeg, -12.5);
    EXPECT_EQ(view->rollDeg, 3);
    EXPECT_EQ(view->fovDeg, 60);
    EXPECT_EQ(view->projection, Projection::Panorama);
    EXPECT_EQ(view->width, 800);
    EXPECT_EQ(view->height, 600);
    ASSERT_TRUE(view->extent);
    EXPECT_EQ(view->extent->yMax, 3);
    EXPECT_TRUE(view->lonLat);
}

TEST_F(ViewFile, LookAtMayLeaveTheHeightToTheGround) {
    const Result<View> view = readView(fileOf(R"({"eye": [1, 2, -3], "look_at": [4, 5]})"));
    ASSERT_TRUE(view.ok());
    EXPECT_EQ(view->eye->z, -3);
    EXPECT_FALSE(view->eye->aboveGround);
    EXPECT_FALSE(view->lookAt->z);
}

TEST_F(ViewFile, KeepsDefaultsForAbsentKeys) {
    View defaults;
    defaults.width = 77;
    defaults.fovDeg = 33;
    const Result<View> view = readView(fileOf(R"({"fov": 50})"), defaults);
    ASSERT_TRUE(view.ok());
    EXPECT_EQ(view->width, 77);
    EXPECT_EQ(view->fovDeg, 50);
}

TEST_F(ViewFile, NamesTheKeyOfEveryMistake) {
    using testing::HasSubstr;
    EXPECT_THAT(errorOf(R"({"tilt": 5})"), HasSubstr("'tilt'"));
    EXPECT_THAT(errorOf(R"({"eye": [1, 2]})"), HasSubstr("'eye'"));
    EXPECT_THAT(errorOf(R"({"eye": [1, "2", 3]})"), HasSubstr("'eye'"));
    EXPECT_THAT(errorOf(R"({"eye": [1, 2, "3"]})"), HasSubstr("'eye'"));
    EXPECT_THAT(errorOf(R"({"eye": [1, 2, "+"]})"), HasSubstr("'eye'"));
    EXPECT_THAT(errorOf(R"({"eye": [1, 2, "+x"]})"), HasSubstr("'eye'"));
    EXPECT_THAT(errorOf(R"({"eye": {"x": 1}})"), HasSubstr("'eye'"));
    EXPECT_THAT(errorOf(R"({"look_at": 3})"), HasSubstr("'look_at'"));
    EXPECT_THAT(errorOf(R"({"look_at": [1, 2], "heading": 3})"), HasSubstr("'look_at'"));
    EXPECT_THAT(errorOf(R"({"heading": "north"})"), HasSubstr("'heading'"));
    EXPECT_THAT(errorOf(R"({"pitch": -91})"), HasSubstr("'pitch'"));
    EXPECT_THAT(errorOf(R"({"fov": 0})"), HasSubstr("'fov'"));
    EXPECT_THAT(errorOf(R"({"projection": "fisheye"})"), HasSubstr("'projection'"));
    EXPECT_THAT(errorOf(R"({"size": [0, 5]})"), HasSubstr("'size'"));
    EXPECT_THAT(errorOf(R"({"size": [10.5, 5]})"), HasSubstr("'size'"));
    EXPECT_THAT(errorOf(R"({"size": [99999999999999999999, 5]})"), HasSubstr("'size'"));
    EXPECT_THAT(errorOf(R"({"extent": [0, 0, 0, 1]})"), HasSubstr("'extent'"));
    EXPECT_THAT(errorOf(R"({"lonlat": 1})"), HasSubstr("'lonlat'"));
}

TEST_F(ViewFile, RefusesWhatIsNoJsonObject) {
    EXPECT_NE(errorOf(""), "");
    EXPECT_NE(errorOf("{\"eye\": [1, 2"), "");
    EXPECT_NE(errorOf("[1, 2]"), "");
    EXPECT_NE(errorOf("{\"heading\": 1e999}"), "");
    EXPECT_NE(errorOf(std::string(2 << 20, ' ')), "");
    EXPECT_NE(errorOf(std::string(100000, '[')), "");
    EXPECT_FALSE(readView(folder_ + "/missing.json").ok());
    EXPECT_FALSE(readView(folder_).ok());
}

}  // namespace
}  // namespace terray
