// SPDX-License-Identifier: Apache-2.0
// Option values out of range are refused with their option's name; good ones pass.
#include "engine/check.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace terray {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string optionError(const std::function<void(RenderOptions&)>& change,
                        ErrorCode code = ErrorCode::Usage) {
    RenderOptions options;
    change(options);
    const auto result = checkOptions(View{}, options);
    if (result.ok()) return "accepted";
    EXPECT_EQ(result.error().code, code) << result.error().message;
    return result.error().message;
}

std::string viewError(const std::function<void(View&)>& change) {
    View view;
    change(view);
    const auto result = checkView(view);
    if (result.ok()) return "accepted";
    EXPECT_EQ(result.error().code, ErrorCode::Usage);
    return result.error().message;
}

TEST(Check, DefaultsAreGood) {
    EXPECT_TRUE(checkView(View{}).ok());
    EXPECT_TRUE(checkOptions(View{}, RenderOptions{}).ok());
    EXPECT_TRUE(checkOutputNames(RenderOptions{}, OutputOptions{}).ok());
}

TEST(Check, NumbersOutOfRangeNameTheirOption) {
    for (const double bad : {kNan, kInfinity, -1e9}) {
        EXPECT_TRUE(optionError([&](auto& o) { o.tolerancePx = bad; }).starts_with("--tolerance"));
        EXPECT_TRUE(optionError([&](auto& o) { o.refraction = bad; }).starts_with("--refraction"));
        EXPECT_TRUE(
            optionError([&](auto& o) { o.exaggeration = bad; }).starts_with("--exaggeration"));
        EXPECT_TRUE(optionError([&](auto& o) { o.hazeKm = bad; }).starts_with("--haze"));
        EXPECT_TRUE(optionError([&](auto& o) { o.contoursM = bad; }).starts_with("--contours"));
        EXPECT_TRUE(optionError([&](auto& o) {
                        o.sunAzElDeg = {{bad, 10.0}};
                    }).starts_with("--sun"));
        EXPECT_TRUE(viewError([&](View& v) { v.headingDeg = bad; }).starts_with("--heading"));
        EXPECT_TRUE(viewError([&](View& v) { v.pitchDeg = bad; }).starts_with("--pitch"));
        EXPECT_TRUE(viewError([&](View& v) { v.fovDeg = bad; }).starts_with("--fov"));
    }
    EXPECT_TRUE(optionError([](auto& o) { o.exaggeration = 0; }).starts_with("--exaggeration"));
}

TEST(Check, NamesAreKnownOrRefused) {
    EXPECT_EQ(optionError([](auto& o) { o.device = "cpu"; }), "accepted");
    EXPECT_TRUE(optionError([](auto& o) { o.device = "toaster"; }).starts_with("--device"));
    EXPECT_TRUE(optionError([](auto& o) { o.device = "vulkan:99"; }, ErrorCode::Resource)
                    .starts_with("--device vulkan"));
    EXPECT_NE(optionError([](auto& o) { o.technique = "magic"; }).find("magic"), std::string::npos);
    for (const char* good : {"sky", "transparent", "#0aF9c3"})
        EXPECT_EQ(optionError([&](auto& o) { o.background = good; }), "accepted");
    for (const char* bad : {"", "#12345", "#12345g", "red"})
        EXPECT_TRUE(optionError([&](auto& o) { o.background = bad; }).starts_with("--background"));
    for (const int good : {1, 2, 4, 8, 16})
        EXPECT_EQ(optionError([&](auto& o) { o.samples = good; }), "accepted");
    for (const int bad : {0, 3, 32, -4})
        EXPECT_TRUE(optionError([&](auto& o) { o.samples = bad; }).starts_with("--samples"));
}

TEST(Check, TimeAndSunExcludeEachOther) {
    EXPECT_EQ(optionError([](auto& o) { o.time = "2024-06-21T12:00:00Z"; }), "accepted");
    EXPECT_TRUE(optionError([](auto& o) { o.time = "yesterday"; }).starts_with("--time 'y"));
    EXPECT_NE(optionError([](auto& o) {
                  o.time = "2024-06-21T12:00:00Z";
                  o.sunAzElDeg = {{10.0, 20.0}};
              }).find("--sun and --time"),
              std::string::npos);
}

TEST(Check, ViewsThatContradictThemselvesAreRefused) {
    EXPECT_TRUE(viewError([](View& v) { v.width = 0; }).starts_with("--size"));
    EXPECT_TRUE(viewError([](View& v) { v.eye = Place{1, 2, {}, false}; }).starts_with("--eye"));
    EXPECT_TRUE(viewError([](View& v) {
                    v.lookAt = Place{1, 2, {}, false};
                }).starts_with("--look-at"));
    EXPECT_NE(viewError([](View& v) { v.extent = Extent{0, 0, 1, 1}; }), "accepted");
    EXPECT_NE(viewError([](View& v) {
                  v.projection = Projection::Ortho;
                  v.extent = Extent{1, 0, 0, 1};
              }),
              "accepted");
}

TEST(Check, GroundHeightsAreNotJudgedBeforeTheTerrainIsKnown) {
    EXPECT_EQ(viewError([](View& v) {
                  v.eye = Place{5, 5, 2.0, true};
                  v.lookAt = Place{5, 5, {}, false};
              }),
              "accepted");
    EXPECT_EQ(viewError([](View& v) { v.projection = Projection::Panorama; }), "accepted");
}

TEST(Check, OutputsNeedTheirOwnFilesAndFloatFormats) {
    const auto error = [](const OutputOptions& outputs) {
        const auto result = checkOutputNames(RenderOptions{}, outputs);
        return result.ok() ? std::string("accepted") : result.error().message;
    };
    EXPECT_EQ(error({.path = "a.png", .aovs = {{Aov::Depth, "b.tif"}, {Aov::Mip, "c.exr"}}}),
              "accepted");
    EXPECT_NE(error({.path = "a.tif", .aovs = {{Aov::Depth, "a.tif"}}}).find("twice"),
              std::string::npos);
    EXPECT_NE(error({.path = "", .aovs = {{Aov::Depth, "a.png"}}}).find(".exr"), std::string::npos);
    EXPECT_NE(error({.path = "", .aovs = {}}).find("nothing to write"), std::string::npos);
    RenderOptions words;
    words.legend = true;
    EXPECT_FALSE(checkOutputNames(words, {.path = "a.exr", .aovs = {}}).ok());
}

}  // namespace
}  // namespace terray
