// SPDX-License-Identifier: Apache-2.0
// ray_cast on CPU cores: image tiles are cut into 8 x 8 pixel blocks whose 4 x 4 quarters fill SIMD
// packets.
#include <algorithm>
#include <array>
#include <cmath>

#include "kernel/beam.h"
#include "technique/ray_cast/ray_cast.h"

namespace terray {
namespace {

constexpr int kBeamSide = 16;
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

/// The bundle of all rays of a pixel square, and how its parameter scales.
Beam beamOf(const RayFrame& rays, double x, double y, double side) {
    Beam beam;
    const std::array<std::array<double, 2>, 4> corners{
        {{0, 0}, {side, 0}, {0, side}, {side, side}}};
    for (size_t k = 0; k < corners.size(); ++k)
        beam.corners[k] = rays.pencilRay(x + corners[k][0], y + corners[k][1]).ray;
    if (rays.camera().projection == Projection::Panorama) {  // the front is an arc
        const double halfAngle = 0.5 * side / rays.camera().focalPixels();
        const Ray& r = beam.corners[0];
        beam.bulge = 1.1 * (1.0 - std::cos(halfAngle)) * std::hypot(r.dx, r.dy);
    }
    return beam;
}

class RayCast final : public Technique {
public:
    void castTile(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
                  std::span<Hit> hits, TraceCounters& counters) const override {
        for (int y = 0; y < tile.height; y += kBeamSide) {
            for (int x = 0; x < tile.width; x += kBeamSide) {
                const BeamStart start =
                    beamStart(cut, beamOf(rays, tile.x + x, tile.y + y, kBeamSide));
                for (int k = 0; k < 4; ++k)
                    castBlock(cut, rays, tile, {x + (k % 2) * kBlockSide, y + (k / 2) * kBlockSide},
                              start, offset, hits, counters);
            }
        }
    }

private:
    struct Corner {
        int x, y;
    };

    static void castBlock(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile,
                          Corner corner, const BeamStart& start, Vec2 offset, std::span<Hit> hits,
                          TraceCounters& counters) {
        static constexpr auto kOrder = packetOrder();
        std::array<double, kBatchRays> px, py;
        std::array<size_t, kBatchRays> target;
        std::array<Hit, kBatchRays> found;
        RayBatch batch;
        size_t count = 0;
        for (const auto& [dx, dy] : kOrder) {
            const int x = corner.x + dx, y = corner.y + dy;
            if (x >= tile.width || y >= tile.height) continue;
            px[count] = tile.x + x + offset.x;
            py[count] = tile.y + y + offset.y;
            target[count++] =
                static_cast<size_t>(y) * static_cast<size_t>(tile.width) + static_cast<size_t>(x);
        }
        if (count == 0) return;
        rays.fillBatch(std::span(px).first(count), std::span(py).first(count), start.w, batch);
        firstHits(cut, batch, static_cast<int>(count), start.level, std::span(found).first(count),
                  counters);
        for (size_t k = 0; k < count; ++k) hits[target[k]] = found[k];
    }
};

}  // namespace

std::unique_ptr<Technique> makeRayCast() { return std::make_unique<RayCast>(); }

}  // namespace terray
