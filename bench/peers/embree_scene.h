// SPDX-License-Identifier: Apache-2.0
// A terrain's finest mip as an Embree scene: two triangles a cell, or one grid.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "math/types.h"
#include "stream/resident.h"

namespace terray::bench {

enum class EmbreeGeometry { Triangles, Grid };

struct EmbreeOptions {
    EmbreeGeometry geometry = EmbreeGeometry::Triangles;
    int threads = 1;      ///< of the build
    bool robust = false;  ///< RTC_SCENE_FLAG_ROBUST; Embree's default is without
    std::string isa;      ///< instructions at most, as Embree names them; empty: all
};

struct EmbreeFigures {
    double commitMs = 0;                ///< rtcCommitGeometry and rtcCommitScene, heights in place
    uint64_t bytes = 0, peakBytes = 0;  ///< by the device's own count, buffers included
};

/// Owns device, geometry and scene. Coordinates are metres from `origin`, the lattice's middle, so
/// that floats are small.
class EmbreeScene {
public:
    /// Error Resource if Embree runs out of memory, Input if a grid is too large for it.
    static Result<std::unique_ptr<EmbreeScene>> build(const ResidentTerrain& terrain,
                                                      const EmbreeOptions& options);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    RTCScene scene() const { return scene_; }
    const WorldPoint& origin() const { return origin_; }
    const EmbreeFigures& figures() const { return figures_; }

private:
    EmbreeScene() = default;
    Result<void> open(const EmbreeOptions& options);
    Result<RTCGeometry> makeGeometry(const ResidentTerrain& terrain, EmbreeGeometry kind);
    static bool countBytes(void* self, ssize_t bytes, bool post);

    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    WorldPoint origin_{};
    std::atomic<int64_t> bytes_ = 0, peakBytes_ = 0;
    EmbreeFigures figures_;
};

}  // namespace terray::bench
