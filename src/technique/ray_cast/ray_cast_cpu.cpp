// SPDX-License-Identifier: Apache-2.0
// ray_cast on CPU cores: columns march where they can, bundles of rays go where they cannot.
#include <algorithm>

#include "kernel/columns.h"
#include "technique/ray_cast/column_march.h"
#include "technique/ray_cast/ray_cast.h"

namespace terray {
namespace {

class RayCast final : public Technique {
public:
    void castTile(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
                  std::span<Hit> hits, TraceCounters& counters) const override {
        const auto stride = static_cast<size_t>(tile.width);
        const auto cast = cut.surface == kSurfaceConstant ? castByBeams : marchTile;
        for (int y = 0; y < tile.height; y += kMarchColumns) {
            for (int x = 0; x < tile.width; x += kMarchColumns) {
                const ImageTile part{tile.x + x, tile.y + y,
                                     std::min(kMarchColumns, tile.width - x),
                                     std::min(kMarchColumns, tile.height - y)};
                const auto first = static_cast<size_t>(y) * stride + static_cast<size_t>(x);
                cast(cut, rays, part, offset, hits.subspan(first), stride, counters);
            }
        }
    }
};

}  // namespace

std::unique_ptr<Technique> makeRayCast() { return std::make_unique<RayCast>(); }

}  // namespace terray
