// SPDX-License-Identifier: Apache-2.0
// Techniques, bare packets, the oracle and shadow rays, each behind castTile().
#include "peers/terray_casters.h"

#include <array>
#include <limits>

#include "kernel/height.h"
#include "kernel/scalar/oracle.h"
#include "kernel/simd/block.h"

namespace terray::bench {
namespace {

constexpr int kBlockSide = 8, kPacketSide = 4;
constexpr int kOracleStep = 8;

/// Pixels of an 8 x 8 block, its 4 x 4 quarters one after the other: what fills packets best.
struct PixelOrder {
    std::array<int, kBatchRays> x, y;
    constexpr PixelOrder() : x(), y() {
        for (int k = 0; k < kBatchRays; ++k) {
            const int quarter = k / 16, inner = k % 16;
            x[static_cast<size_t>(k)] = quarter % 2 * kPacketSide + inner % kPacketSide;
            y[static_cast<size_t>(k)] = quarter / 2 * kPacketSide + inner / kPacketSide;
        }
    }
};
constexpr PixelOrder kOrder;

/// Calls work(x, y, count) for the 8 x 8 blocks of a tile, with the tile's own pixel coordinates.
template <class Work>
void forBlocks(const ImageTile& tile, const Work& work) {
    std::array<int, kBatchRays> x, y;
    for (int top = 0; top < tile.height; top += kBlockSide)
        for (int left = 0; left < tile.width; left += kBlockSide) {
            size_t count = 0;
            for (size_t k = 0; k < kBatchRays; ++k) {
                x[count] = left + kOrder.x[k];
                y[count] = top + kOrder.y[k];
                if (x[count] < tile.width && y[count] < tile.height) ++count;
            }
            work(x, y, count);
        }
}

void readHits(const ImageTile& tile, const Scratch& scratch, std::span<float> values) {
    for (size_t k = 0; k < tile.pixelCount(); ++k)
        values[k] =
            isHit(scratch.hits[k]) ? scratch.hits[k].t : std::numeric_limits<float>::infinity();
}

class TechniqueCaster final : public Caster {
public:
    TechniqueCaster(const Technique& technique, const TerrainCut& cut, const RayFrame& frame)
        : technique_(technique), cut_(cut), frame_(frame) {}
    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        technique_.castTile(cut_, frame_, tile, {0.5, 0.5},
                            {scratch.hits.data(), tile.pixelCount()}, scratch.counters);
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        readHits(tile, scratch, values);
    }

private:
    const Technique& technique_;
    const TerrainCut& cut_;
    const RayFrame& frame_;
};

class PacketCaster final : public Caster {
public:
    PacketCaster(const TerrainCut& cut, const RayFrame& frame) : cut_(cut), frame_(frame) {}
    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        std::array<double, kBatchRays> px, py;
        std::array<Hit, kBatchRays> found;
        RayBatch batch;
        forBlocks(tile, [&](const auto& x, const auto& y, size_t count) {
            for (size_t k = 0; k < count; ++k) {
                px[k] = tile.x + x[k] + 0.5;
                py[k] = tile.y + y[k] + 0.5;
            }
            frame_.fillBatch(std::span(px).first(count), std::span(py).first(count), 0.0, batch);
            firstHits(cut_, batch, static_cast<int>(count), simd::kEnterAtTop,
                      std::span(found).first(count), scratch.counters);
            for (size_t k = 0; k < count; ++k) scratch.hits[indexOf(tile, x[k], y[k])] = found[k];
        });
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        readHits(tile, scratch, values);
    }

private:
    const TerrainCut& cut_;
    const RayFrame& frame_;
};

class OracleCaster final : public Caster {
public:
    OracleCaster(const TerrainCut& cut, const RayFrame& frame) : cut_(cut), frame_(frame) {}
    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        for (int y = 0; y < tile.height; y += kOracleStep)
            for (int x = 0; x < tile.width; x += kOracleStep) {
                const Ray ray = frame_.rayThrough(tile.x + x + 0.5, tile.y + y + 0.5);
                const Hit hit = oracle::firstHit(cut_, ray).hit;
                scratch.hits[indexOf(tile, x, y)] = hit;
                scratch.counters.rays += 1;
                scratch.counters.hits += isHit(hit) ? 1 : 0;
                scratch.counters.steps += hit.steps;
            }
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        readHits(tile, scratch, values);
    }

private:
    const TerrainCut& cut_;
    const RayFrame& frame_;
};

class ShadowCaster final : public Caster {
public:
    ShadowCaster(const TerrainCut& cut, const RayFrame& frame, std::vector<Hit> hits)
        : cut_(cut),
          hits_(std::move(hits)),
          width_(frame.camera().width),
          sun_(frame.latticeRay({{}, towardsSun()})) {}
    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        std::array<Hit, kBatchRays> from;
        std::array<Ray, kBatchRays> rays;
        std::array<uint8_t, kBatchRays> dark;
        forBlocks(tile, [&](const auto& x, const auto& y, size_t count) {
            for (size_t k = 0; k < count; ++k) {
                from[k] = hits_[static_cast<size_t>(tile.y + y[k]) * static_cast<size_t>(width_) +
                                static_cast<size_t>(tile.x + x[k])];
                rays[k] = sun_;
                if (!isHit(from[k])) continue;
                const LatticePlace place = hitPlace(cut_, from[k]);
                rays[k].x = place.i;
                rays[k].y = place.j;
                rays[k].z = hitHeight(cut_, from[k]);
            }
            occluded(cut_, std::span(from).first(count), std::span(rays).first(count),
                     std::span(dark).first(count), scratch.counters);
            for (size_t k = 0; k < count; ++k) scratch.values[indexOf(tile, x[k], y[k])] = dark[k];
        });
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        std::copy_n(scratch.values.begin(), tile.pixelCount(), values.begin());
    }

private:
    const TerrainCut& cut_;
    std::vector<Hit> hits_;
    int width_;
    Ray sun_;
};

}  // namespace

std::unique_ptr<Caster> makeTechniqueCaster(const Technique& technique, const TerrainCut& cut,
                                            const RayFrame& frame) {
    return std::make_unique<TechniqueCaster>(technique, cut, frame);
}

std::unique_ptr<Caster> makePacketCaster(const TerrainCut& cut, const RayFrame& frame) {
    return std::make_unique<PacketCaster>(cut, frame);
}

std::unique_ptr<Caster> makeOracleCaster(const TerrainCut& cut, const RayFrame& frame) {
    return std::make_unique<OracleCaster>(cut, frame);
}

std::unique_ptr<Caster> makeShadowCaster(const TerrainCut& cut, const RayFrame& frame,
                                         std::vector<Hit> hits) {
    return std::make_unique<ShadowCaster>(cut, frame, std::move(hits));
}

std::vector<Hit> castHits(const Technique& technique, const TerrainCut& cut,
                          const RayFrame& frame) {
    const auto width = static_cast<size_t>(frame.camera().width);
    std::vector<Hit> hits(width * static_cast<size_t>(frame.camera().height));
    tbb::enumerable_thread_specific<Scratch> scratches;
    castTiles(frame.camera().width, frame.camera().height, scratches,
              [&](const ImageTile& tile, Scratch& scratch) {
                  technique.castTile(cut, frame, tile, {0.5, 0.5},
                                     {scratch.hits.data(), tile.pixelCount()}, scratch.counters);
                  for (int y = 0; y < tile.height; ++y)
                      std::copy_n(
                          scratch.hits.begin() + y * tile.width, tile.width,
                          hits.begin() +
                              static_cast<std::ptrdiff_t>(static_cast<size_t>(tile.y + y) * width) +
                              tile.x);
              });
    return hits;
}

}  // namespace terray::bench
