// SPDX-License-Identifier: Apache-2.0
// A technique answers one question: where does each ray of an image tile hit? It fills hits, no
// more.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "kernel/trace.h"
#include "technique/device_technique.h"
#include "view/ray_frame.h"

namespace terray {

/// The image tiles that frames are made of: as wide as rows share best, and few enough hits to stay
/// in a core's cache until they are shaded.
constexpr int kTileWidth = 256, kTileHeight = 128;

/// const-shared: castTile may be called from many threads at once.
class Technique {
public:
    virtual ~Technique() = default;
    /// Hits of the rays through (x + offset.x, y + offset.y) of each pixel, row by row. offset in
    /// 0..1.
    virtual void castTile(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile,
                          Vec2 offset, std::span<Hit> hits, TraceCounters& counters) const = 0;
};

struct TechniqueEntry {
    std::string name, line;
    std::unique_ptr<Technique> (*make)();
    Result<std::unique_ptr<DeviceTechnique>> (*openOnDevice)(const DeviceRequest& request);
};
/// The explicit table of techniques (registry.cpp), the default first.
std::span<const TechniqueEntry> techniqueTable();
/// Error Usage naming the known ones.
Result<std::unique_ptr<Technique>> makeTechnique(const std::string& name);
/// The same on a device.
Result<std::unique_ptr<DeviceTechnique>> openTechnique(const std::string& name,
                                                       const DeviceRequest& request);

}  // namespace terray
