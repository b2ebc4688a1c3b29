// SPDX-License-Identifier: Apache-2.0
// A terrain far larger than any disk here: tiles are made when they are asked for, pass through the
// store's codec and its decoder, and have bounds that are known without making any.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "terabyte_ground.h"
#include "tile/tile_source.h"

namespace terray::bench {

/// const-shared.
class TerabyteSource final : public TileSource {
public:
    /// Ground of width x height metres (multiples of 64), with posts 2^finestMip metres apart: the
    /// same ground whatever that is, less what such posts miss. Bare: without trees and houses.
    TerabyteSource(int64_t width, int64_t height, int finestMip, uint32_t seed, bool isBare);

    const TerrainInfo& info() const override { return info_; }
    uint64_t holes() const override { return 0; }
    std::span<const BlockBounds> bounds(int mip) const override {
        return bounds_[static_cast<size_t>(mip)];
    }
    Result<std::unique_ptr<TileReader>> makeReader() const override;

    /// Posts of a mip, without the codec.
    void makePosts(int mip, int64_t x, int64_t y, int width, int height, float* out) const;

    /// What readers have done so far.
    struct Work {
        std::atomic<uint64_t> tiles{0}, encodedBytes{0}, decodedBytes{0};
        std::atomic<double> makeMs{0}, encodeMs{0}, decodeMs{0};
    };
    Work& work() const { return work_; }

private:
    friend class BoundsMaker;
    int finestMip_;
    uint32_t seed_;
    Clutter clutter_;
    TerrainInfo info_;
    std::vector<std::vector<BlockBounds>> bounds_;
    mutable Work work_;
};

}  // namespace terray::bench
