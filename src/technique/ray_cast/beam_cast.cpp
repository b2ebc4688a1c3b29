// SPDX-License-Identifier: Apache-2.0
// An image tile ray by ray: bundles of 16 x 16 pixels give a head start, 8 x 8 blocks in 4 x 4
// quarters fill SIMD packets.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernel/beam.h"
#include "technique/ray_cast/column_march.h"

namespace terray {
namespace {

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

struct Corner {
    int x, y;
};

}  // namespace

Beam beamOf(const RayFrame& rays, double x, double y, double width, double height) {
    Beam beam;
    const std::array<std::array<double, 2>, 4> corners{
        {{0, 0}, {width, 0}, {0, height}, {width, height}}};
    for (size_t k = 0; k < corners.size(); ++k)
        beam.corners[k] = rays.pencilRay(x + corners[k][0], y + corners[k][1]).ray;
    if (rays.camera().projection == Projection::Panorama) {  // the front is an arc
        const double halfAngle = 0.5 * width / rays.camera().focalPixels();
        const Ray& r = beam.corners[0];
        beam.bulge = 1.1 * (1.0 - std::cos(halfAngle)) * std::hypot(r.dx, r.dy);
    }
    return beam;
}

void castByBeams(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
                 std::span<Hit> hits, size_t stride, TraceCounters& counters) {
    static constexpr auto kOrder = packetOrder();
    const auto castBlock = [&](Corner corner, double clear, int level) {
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
            target[count++] = static_cast<size_t>(y) * stride + static_cast<size_t>(x);
        }
        if (count == 0) return;
        rays.fillBatch(std::span(px).first(count), std::span(py).first(count), clear, batch);
        firstHits(cut, batch, static_cast<int>(count), level, std::span(found).first(count),
                  counters);
        counters.beams += count;
        for (size_t k = 0; k < count; ++k) hits[target[k]] = found[k];
    };
    for (int y = 0; y < tile.height; y += kBeamSide) {
        for (int x = 0; x < tile.width; x += kBeamSide) {
            BeamWalk walk(cut, beamOf(rays, tile.x + x, tile.y + y, kBeamSide, kBeamSide));
            const double clear = walk.clearTo(std::numeric_limits<double>::infinity());
            for (int k = 0; k < 4; ++k)
                castBlock({x + (k % 2) * kBlockSide, y + (k / 2) * kBlockSide}, clear,
                          walk.level());
        }
    }
}

}  // namespace terray
