// SPDX-License-Identifier: Apache-2.0
// ray_cast on CPU cores: image tiles are cut into 8 x 8 pixel blocks whose 4 x 4 quarters fill SIMD
// packets.
#include <algorithm>
#include <array>

#include "technique/ray_cast/ray_cast.h"

namespace terray {
namespace {

constexpr int kBlockSide = 8;
constexpr int kPacketSide = 4;

/// Pixels of an 8 x 8 block in packet order: four 4 x 4 squares one after the other.
constexpr std::array<std::array<uint8_t, 2>, kBlockSide * kBlockSide> packetOrder() {
    std::array<std::array<uint8_t, 2>, kBlockSide * kBlockSide> order{};
    for (int k = 0; k < kBlockSide * kBlockSide; ++k) {
        const int quarter = k / (kPacketSide * kPacketSide),
                  inner = k % (kPacketSide * kPacketSide);
        order[static_cast<size_t>(k)] = {
            static_cast<uint8_t>((quarter % 2) * kPacketSide + inner % kPacketSide),
            static_cast<uint8_t>((quarter / 2) * kPacketSide + inner / kPacketSide)};
    }
    return order;
}

class RayCast final : public Technique {
public:
    void castTile(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
                  std::span<Hit> hits, TraceCounters& counters) const override {
        for (int y = 0; y < tile.height; y += kBlockSide)
            for (int x = 0; x < tile.width; x += kBlockSide)
                castBlock(cut, rays, tile, x, y, offset, hits, counters);
    }

private:
    static void castBlock(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile,
                          int x0, int y0, Vec2 offset, std::span<Hit> hits,
                          TraceCounters& counters) {
        static constexpr auto kOrder = packetOrder();
        std::array<Ray, kBlockSide * kBlockSide> block;
        std::array<size_t, kBlockSide * kBlockSide> target;
        std::array<Hit, kBlockSide * kBlockSide> found;
        size_t count = 0;
        for (const auto& [dx, dy] : kOrder) {
            const int x = x0 + dx, y = y0 + dy;
            if (x >= tile.width || y >= tile.height) continue;
            block[count] = rays.rayThrough(tile.x + x + offset.x, tile.y + y + offset.y);
            target[count++] =
                static_cast<size_t>(y) * static_cast<size_t>(tile.width) + static_cast<size_t>(x);
        }
        firstHits(cut, std::span(block).first(count), std::span(found).first(count), counters);
        for (size_t k = 0; k < count; ++k) hits[target[k]] = found[k];
    }
};

}  // namespace

std::unique_ptr<Technique> makeRayCast() { return std::make_unique<RayCast>(); }

}  // namespace terray
