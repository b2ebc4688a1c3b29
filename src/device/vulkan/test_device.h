// SPDX-License-Identifier: Apache-2.0
// Devices for tests: validated, or the test is skipped aloud.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "device/devices.h"
#include "device/vulkan/device.h"

namespace terray::vulkan {

/// Every test's device validates; when the test ends, nothing may have been found.
class VulkanTest : public testing::Test {
protected:
    void SetUp() override {
        const auto devices = listDevices();
        if (!devices) GTEST_SKIP() << devices.error().message;
        faults_ = validationFaults();
        device_ = open({});
    }
    void TearDown() override {
        device_.reset();  // objects that were left over are faults too
        EXPECT_EQ(validationFaults(), faults_);
    }

    static std::unique_ptr<Device> open(DeviceOptions options) {
        options.validation = true;
        auto device = Device::open(options);
        EXPECT_TRUE(device) << (device ? "" : device.error().message);
        return device ? std::move(*device) : nullptr;
    }
    Device& device() { return *device_; }

private:
    std::unique_ptr<Device> device_;
    uint64_t faults_ = 0;
};

}  // namespace terray::vulkan
