// SPDX-License-Identifier: Apache-2.0
// A technique on a device: many image tiles at once, hits as exact as on the CPU.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "kernel/trace.h"
#include "view/ray_frame.h"

namespace terray {

/// Work of a device, summed over calls by the caller.
struct DeviceFigures {
    double deviceMs = 0;         ///< of its own clock, tracing; 0 if it has none
    double castMs = 0;           ///< wall clock, with placing rays and what was left open
    uint64_t uploadedBytes = 0;  ///< tiles and tables, not rays
};

struct DeviceRequest {
    std::string which{};       ///< see DeviceWish
    uint64_t budgetBytes = 0;  ///< of the device's memory; 0: half of it
    /// Of a test: the device counts as lost after so much work; -1: never.
    int submitsUntilLost = -1;
};

/// Keeps a terrain's tiles on its device from picture to picture. confined.
class DeviceTechnique {
public:
    virtual ~DeviceTechnique() = default;
    virtual std::string deviceName() const = 0;
    /// Brings what the cut draws to the device. Pictures of one terrain only. Error Resource if it
    /// does not fit.
    virtual Result<void> prepare(const TerrainCut& cut, DeviceFigures& figures) = 0;
    /// Of the cut that was prepared last: the hits of each image tile, row by row, one tile after
    /// the other. offset as in Technique::castTile.
    virtual Result<void> cast(const TerrainCut& cut, const RayFrame& rays,
                              std::span<const ImageTile> tiles, Vec2 offset, std::span<Hit> hits,
                              TraceCounters& counters, DeviceFigures& figures) = 0;
    /// After an Error: the device is gone, not only too small.
    virtual bool isLost() const = 0;
};

}  // namespace terray
