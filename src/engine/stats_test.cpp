// SPDX-License-Identifier: Apache-2.0
// Figures as JSON: keys that others read, and values that come back.
#include "terray/stats.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace terray {
namespace {

TEST(Stats, JsonHasTheDocumentedKeys) {
    const auto json = nlohmann::json::parse(toJson(RenderStats{}));
    for (const char* key : {"device", "technique", "width", "height", "rays", "hits", "primary_ms",
                            "shade_ms", "load_ms", "build_ms", "mrays_per_s", "steps_per_ray",
                            "bytes_per_sample", "peak_rss_bytes"})
        EXPECT_TRUE(json.contains(key)) << key;
}

TEST(Stats, JsonGivesValuesBack) {
    RenderStats stats;
    stats.device = "cpu";
    stats.width = 17;
    stats.rays = 123456789012345;
    stats.primaryMs = 1.5;
    stats.tilesPerMip = {3, 1};
    const auto json = nlohmann::json::parse(toJson(stats));
    EXPECT_EQ(json["device"], "cpu");
    EXPECT_EQ(json["width"], 17);
    EXPECT_EQ(json["rays"], 123456789012345);
    EXPECT_EQ(json["primary_ms"], 1.5);
    EXPECT_EQ(json["tiles_per_mip"], (std::vector<int>{3, 1}));
}

TEST(Stats, DevicesHaveFiguresOfTheirOwn) {
    RenderStats stats;
    stats.device = "cpu";
    EXPECT_FALSE(nlohmann::json::parse(toJson(stats)).contains("device_ms"));
    stats.device = "vulkan: Voodoo";
    stats.deviceMs = 2.5;
    stats.deviceUploadBytes = 77;
    const auto json = nlohmann::json::parse(toJson(stats));
    EXPECT_EQ(json["device_ms"], 2.5);
    EXPECT_EQ(json["device_upload_bytes"], 77);
}

}  // namespace
}  // namespace terray
