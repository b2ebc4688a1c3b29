// SPDX-License-Identifier: Apache-2.0
// Which device is meant, and free lists: no device is needed.
#include "device/vulkan/choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "device/devices.h"
#include "device/vulkan/free_list.h"

namespace terray::vulkan {
namespace {

PhysicalDevice fakeDevice(const char* name, const char* lacks) {
    PhysicalDevice device;
    std::strncpy(device.properties.deviceName, name, VK_MAX_PHYSICAL_DEVICE_NAME_SIZE - 1);
    device.lacks = lacks;
    return device;
}

TEST(DeviceChoice, TakesTheFirstUsableOne) {
    const PhysicalDevice devices[] = {fakeDevice("Old 1", "Vulkan 1.3"), fakeDevice("Fast 2", ""),
                                      fakeDevice("Fast 3", "")};
    EXPECT_EQ(chooseDevice(devices, "")->name(), "Fast 2");
    EXPECT_EQ(chooseDevice(devices, "Fast")->name(), "Fast 2");
    EXPECT_EQ(chooseDevice(devices, "2")->name(), "Fast 3");
}

TEST(DeviceChoice, SaysWhatIsWrong) {
    const PhysicalDevice devices[] = {fakeDevice("Old", "timelineSemaphore, Vulkan 1.3")};
    for (const char* which : {"", "0", "Old"}) {
        const auto chosen = chooseDevice(devices, which);
        ASSERT_FALSE(chosen);
        EXPECT_EQ(chosen.error().code, ErrorCode::Resource);
        EXPECT_NE(chosen.error().message.find("lacks timelineSemaphore"), std::string::npos);
    }
    EXPECT_NE(chooseDevice(devices, "1").error().message.find("there are: 0 Old"),
              std::string::npos);
    EXPECT_NE(chooseDevice({}, "").error().message.find("--device cpu"), std::string::npos);
}

TEST(DeviceWish, ReadsTheOption) {
    EXPECT_FALSE(parseDevice("auto")->vulkan);
    EXPECT_FALSE(parseDevice("cpu")->vulkan);
    EXPECT_TRUE(parseDevice("vulkan")->vulkan);
    EXPECT_EQ(parseDevice("vulkan:1")->which, "1");
    for (const char* wrong : {"", "gpu", "vulkan:", "Vulkan", "vulkan1"})
        EXPECT_EQ(parseDevice(wrong).error().code, ErrorCode::Usage) << wrong;
}

TEST(FreeList, PartsNeverOverlapAndAllComesBack) {
    std::mt19937 random(3);
    FreeList list(1 << 16);
    struct Part {
        uint64_t begin, size;
    };
    std::vector<Part> parts;
    size_t full = 0;
    for (int k = 0; k < 5000; ++k) {
        if (parts.empty() || random() % 5 < 3) {
            const uint64_t size = 1 + random() % 3000, alignment = uint64_t{1} << random() % 9;
            const auto begin = list.take(size, alignment);
            full += begin ? 0u : 1u;
            if (!begin) continue;
            EXPECT_EQ(*begin % alignment, 0u);
            EXPECT_LE(*begin + size, uint64_t{1} << 16);
            for (const Part& p : parts)
                EXPECT_TRUE(p.begin + p.size <= *begin || *begin + size <= p.begin);
            parts.push_back({*begin, size});
        } else {
            std::swap(parts[random() % parts.size()], parts.back());
            list.give(parts.back().begin, parts.back().size);
            parts.pop_back();
        }
    }
    EXPECT_GT(full, 0u);
    EXPECT_FALSE(list.isEmpty());
    for (const Part& p : parts) list.give(p.begin, p.size);
    EXPECT_TRUE(list.isEmpty());
}

}  // namespace
}  // namespace terray::vulkan
