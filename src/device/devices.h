// SPDX-License-Identifier: Apache-2.0
// Which devices there are, and what --device names. Needs no Vulkan to be included.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace terray {

/// What the text of --device asks for.
struct DeviceWish {
    bool vulkan = false;  ///< else the CPU
    std::string which;    ///< index in listDevices(), part of a name, or empty: the best
};
/// auto, cpu, vulkan, vulkan:N, vulkan:NAME; anything else is an Error Usage.
Result<DeviceWish> parseDevice(const std::string& text);

/// A Vulkan device of this machine.
struct DeviceEntry {
    std::string name;
    std::string kind;   ///< "discrete GPU", "integrated GPU", "virtual GPU", "CPU", "other"
    std::string lacks;  ///< what it lacks; empty: it can be used
};
/// The best first: its place is its number in --device vulkan:N. Error Resource when there is no
/// loader, no device, or this program was built without Vulkan.
Result<std::vector<DeviceEntry>> listDevices();

/// Whether there is what is wished for; asks the machine once for each wish. synchronised.
Result<void> checkDevice(const DeviceWish& wish);

/// Faults that the validation layer has found in this process so far; 0 without it.
/// TERRAY_VULKAN_VALIDATION=1 in the environment turns it on.
uint64_t validationFaults();

}  // namespace terray
