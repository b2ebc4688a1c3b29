// SPDX-License-Identifier: Apache-2.0
// Pictures on a Vulkan device are those of the CPU, even when the device is lost on the way.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "device/devices.h"
#include "terray/renderer.h"
#include "terray/terrain.h"

namespace terray {
namespace {

constexpr const char* kDeviceTerrain = "synthetic:fractal?size=700&cell=10&seed=3";

/// Skipped aloud where there is no device.
class DevicePicture : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(setenv("TERRAY_VULKAN_VALIDATION", "1", 1), 0);
        const auto devices = listDevices();
        if (!devices) GTEST_SKIP() << devices.error().message;
        faults_ = validationFaults();
    }
    void TearDown() override {
        unsetenv("TERRAY_VULKAN_LOSE_AFTER");
        EXPECT_EQ(validationFaults(), faults_);
    }

private:
    uint64_t faults_ = 0;
};

View deviceView() {
    View view;
    view.width = 256;
    view.height = 144;
    return view;
}

struct Picture {
    std::vector<uint8_t> rgba;
    RenderStats stats;
};

Picture pictureOf(const Terrain& terrain, const View& view, RenderOptions options,
                  const std::string& device) {
    Picture picture;
    picture.rgba.resize(static_cast<size_t>(view.width) * static_cast<size_t>(view.height) * 4);
    options.device = device;
    const auto stats = render(terrain, view, options, picture.rgba);
    EXPECT_TRUE(stats.ok()) << stats.error().message;
    if (stats) picture.stats = *stats;
    return picture;
}

/// Pixels of which a channel differs by more than 2 of 255.
size_t pixelsThatDiffer(const Picture& a, const Picture& b) {
    size_t count = 0;
    for (size_t k = 0; k < a.rgba.size(); k += 4) {
        bool differs = false;
        for (size_t c = 0; c < 4; ++c)
            differs = differs || std::abs(a.rgba[k + c] - b.rgba[k + c]) > 2;
        count += differs ? 1u : 0u;
    }
    return count;
}

void expectTheSame(const Picture& device, const Picture& cpu) {
    EXPECT_LE(pixelsThatDiffer(device, cpu), cpu.rgba.size() / 4 / 10'000);
    EXPECT_EQ(device.stats.rays, cpu.stats.rays);
    EXPECT_EQ(device.stats.hits, cpu.stats.hits);
}

TEST_F(DevicePicture, IsThatOfTheCpu) {
    const auto terrain = Terrain::open(kDeviceTerrain);
    ASSERT_TRUE(terrain.ok());
    for (const int samples : {1, 4}) {
        for (const Shading shading : {Shading::Ramp, Shading::Distance}) {
            RenderOptions options;
            options.samples = samples;
            options.shading = shading;
            const Picture device = pictureOf(*terrain, deviceView(), options, "vulkan");
            const Picture cpu = pictureOf(*terrain, deviceView(), options, "cpu");
            expectTheSame(device, cpu);
            EXPECT_EQ(cpu.stats.device, "cpu");
            EXPECT_TRUE(device.stats.device.starts_with("vulkan: ")) << device.stats.device;
            EXPECT_GT(device.stats.hits, device.stats.rays / 4);
            EXPECT_LT(device.stats.redone, device.stats.rays / 50);
        }
    }
}

TEST_F(DevicePicture, IsThatOfTheCpuForEveryProjectionAndSurface) {
    const auto terrain = Terrain::open(kDeviceTerrain);
    ASSERT_TRUE(terrain.ok());
    View panorama = deviceView(), ortho = deviceView();
    panorama.projection = Projection::Panorama;
    panorama.eye = Place{3500, 3500, 300, true};
    ortho.projection = Projection::Ortho;
    RenderOptions constant;
    constant.samples = 1;
    constant.surface = Surface::Constant;
    for (const View& view : {panorama, ortho, deviceView()})
        expectTheSame(pictureOf(*terrain, view, constant, "vulkan"),
                      pictureOf(*terrain, view, constant, "cpu"));
    RenderOptions tall;
    tall.samples = 1;
    tall.exaggeration = 2.5;
    for (const View& view : {panorama, ortho, deviceView()})
        expectTheSame(pictureOf(*terrain, view, tall, "vulkan"),
                      pictureOf(*terrain, view, tall, "cpu"));
}

TEST_F(DevicePicture, TilesAreUploadedOnce) {
    const auto terrain = Terrain::open(kDeviceTerrain);
    ASSERT_TRUE(terrain.ok());
    const Picture first = pictureOf(*terrain, deviceView(), {}, "vulkan");
    const Picture second = pictureOf(*terrain, deviceView(), {}, "vulkan");
    EXPECT_EQ(first.rgba, second.rgba);
    EXPECT_GT(first.stats.deviceUploadBytes, 500'000u);
    EXPECT_LT(second.stats.deviceUploadBytes, 10'000u);
}

TEST_F(DevicePicture, ALostDeviceLeavesTheRestToTheCpu) {
    View view = deviceView();
    view.width = 128;
    view.height = 300;  // two bands
    // Lost while tiles are brought, at the first rays, and some rays later.
    for (const int submits : {0, 5, 8}) {
        const auto terrain = Terrain::open(kDeviceTerrain);
        ASSERT_TRUE(terrain.ok());
        const Picture cpu = pictureOf(*terrain, view, {}, "cpu");
        ASSERT_EQ(setenv("TERRAY_VULKAN_LOSE_AFTER", std::to_string(submits).c_str(), 1), 0);
        testing::internal::CaptureStderr();
        const Picture first = pictureOf(*terrain, view, {}, "vulkan");
        const Picture second = pictureOf(*terrain, view, {}, "vulkan");  // lost again
        const Picture third = pictureOf(*terrain, view, {}, "vulkan");
        const std::string words = testing::internal::GetCapturedStderr();
        EXPECT_NE(words.find("the CPU goes on with this picture"), std::string::npos) << words;
        for (const Picture* picture : {&first, &second}) {
            expectTheSame(*picture, cpu);
            const bool noted = picture->stats.device.find("lost") != std::string::npos;
            EXPECT_EQ(noted, submits > 0) << picture->stats.device;
        }
        EXPECT_EQ(third.rgba, cpu.rgba);
        EXPECT_EQ(third.stats.device, "cpu");
    }
}

TEST_F(DevicePicture, ALostDeviceIsOpenedAnew) {
    const auto terrain = Terrain::open(kDeviceTerrain);
    ASSERT_TRUE(terrain.ok());
    ASSERT_EQ(setenv("TERRAY_VULKAN_LOSE_AFTER", "5", 1), 0);
    testing::internal::CaptureStderr();
    const Picture lost = pictureOf(*terrain, deviceView(), {}, "vulkan");
    testing::internal::GetCapturedStderr();
    unsetenv("TERRAY_VULKAN_LOSE_AFTER");
    const Picture whole = pictureOf(*terrain, deviceView(), {}, "vulkan");
    EXPECT_NE(lost.stats.device.find("lost"), std::string::npos);
    EXPECT_TRUE(whole.stats.device.starts_with("vulkan: "));
    EXPECT_EQ(whole.stats.device.find("lost"), std::string::npos);
    EXPECT_GT(whole.stats.deviceUploadBytes, 500'000u);
    expectTheSame(whole, lost);
}

TEST_F(DevicePicture, BuffersAreThoseOfTheCpu) {
    const auto terrain = Terrain::open(kDeviceTerrain);
    ASSERT_TRUE(terrain.ok());
    const auto folder = std::filesystem::temp_directory_path() / "terray_device_buffers";
    std::filesystem::create_directories(folder);
    RenderOptions options;
    options.device = "vulkan";
    OutputOptions outputs;
    outputs.path = (folder / "a.png").string();
    outputs.aovs = {{Aov::Distance, (folder / "d.tif").string()}};
    const auto stats = renderToFiles(*terrain, deviceView(), options, outputs);
    ASSERT_TRUE(stats.ok()) << stats.error().message;
    // Four places for the picture, the centre for the buffer.
    EXPECT_EQ(stats->rays, uint64_t{5} * 256 * 144);
    std::filesystem::remove_all(folder);
}

TEST(DeviceOption, IsCheckedBeforeAnyWork) {
    RenderOptions options;
    options.device = "vulkan:99";
    const auto checked = checkRender(deviceView(), options, {});
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, ErrorCode::Resource);
    EXPECT_TRUE(checked.error().message.starts_with("--device vulkan")) << checked.error().message;
}

}  // namespace
}  // namespace terray
