// SPDX-License-Identifier: Apache-2.0
// Tiles that come and go: the same surface as with all of them resident, late and missing tiles.
#include "stream/streamer.h"
#include "base/test_size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <set>

#include "kernel/height.h"
#include "kernel/scalar/oracle.h"
#include "kernel/trace.h"
#include "stream/cut.h"
#include "stream/ray_tiles.h"
#include "stream/test_source.h"
#include "stream/tile_rule.h"
#include "view/ray_frame.h"

namespace terray {
namespace {

/// Tiles of a terrain that is wholly resident; can be told to fail and to wait.
class MemoryTiles final : public TileSource {
public:
    struct Troubles {
        std::atomic<bool> isHeld{false};
        std::atomic<int> failures{0};  ///< that are still to come, of tiles of mip 0
        std::atomic<int> reads{0};
    };
    MemoryTiles(const ResidentTerrain& terrain, std::shared_ptr<Troubles> troubles)
        : terrain_(terrain), troubles_(std::move(troubles)) {
        const TilingScheme& scheme = info().scheme;
        for (int mip = 0; mip < scheme.mipCount(); ++mip) {
            std::vector<BlockBounds>& bounds = bounds_.emplace_back();
            for (int y = 0; y < scheme.tilesY(mip) * kTileBlocks; ++y) {
                for (int x = 0; x < scheme.tilesX(mip) * kTileBlocks; ++x) {
                    const uint32_t slot = terrain.slotOf({mip, x / kTileBlocks, y / kTileBlocks});
                    const int k = y % kTileBlocks * kTileBlocks + x % kTileBlocks;
                    bounds.push_back(terrain.blocks(slot)[static_cast<size_t>(k)]);
                }
            }
        }
    }
    const TerrainInfo& info() const override { return terrain_.info(); }
    uint64_t holes() const override { return 0; }
    std::span<const BlockBounds> bounds(int mip) const override {
        return bounds_[static_cast<size_t>(mip)];
    }
    Result<std::unique_ptr<TileReader>> makeReader() const override {
        return std::unique_ptr<TileReader>(new Reader(*this));
    }
    void stopReading() const override { troubles_->isHeld = false; }

private:
    class Reader final : public TileReader {
    public:
        explicit Reader(const MemoryTiles& tiles) : tiles_(tiles) {}
        Result<void> read(TileId id, float* posts, ptrdiff_t stride) override {
            TERRAY_TRY(tiles_.obey(id));
            const ResidentTerrain::Pool& pool = tiles_.terrain_.pool();
            for (int row = 0; row <= pool.cellsY(id); ++row)
                pool.decodeRow(pool.slotOf(id), row, 0, pool.cellsX(id) + 1, posts + row * stride);
            return {};
        }
        Result<void> readCodes(TileId id, uint16_t* codes, ptrdiff_t stride) override {
            TERRAY_TRY(tiles_.obey(id));
            const ResidentTerrain::Pool& pool = tiles_.terrain_.pool();
            const auto* from = pool.postsOf<const uint16_t>(pool.slotOf(id));
            for (int row = 0; row <= pool.cellsY(id); ++row)
                std::copy_n(from + row * kPostStride, pool.cellsX(id) + 1, codes + row * stride);
            return {};
        }

    private:
        const MemoryTiles& tiles_;
    };
    Result<void> obey(TileId id) const {
        ++troubles_->reads;
        while (troubles_->isHeld) std::this_thread::yield();
        if (id.mip == 0 && troubles_->failures > 0) {
            --troubles_->failures;
            return makeError(ErrorCode::Input, "tile ({}, {}) is broken", id.x, id.y);
        }
        return {};
    }

    const ResidentTerrain& terrain_;
    std::shared_ptr<Troubles> troubles_;
    std::vector<std::vector<BlockBounds>> bounds_;
};

struct Pair {
    std::unique_ptr<ResidentTerrain> whole, streamed;
    std::shared_ptr<MemoryTiles::Troubles> troubles = std::make_shared<MemoryTiles::Troubles>();

    Pair(const HeightSource& source, int firstKept, uint64_t tiles) : whole(test::built(source)) {
        const TerrainInfo& info = whole->info();
        const double bytes = poolSizes(info, static_cast<double>(tiles)).total() + 1;
        BuildStats stats;
        auto made = ResidentTerrain::stream(std::make_unique<MemoryTiles>(*whole, troubles),
                                            firstKept, static_cast<uint64_t>(bytes), stats);
        if (made) streamed = std::move(*made);
    }
};

Camera cameraAt(const ResidentTerrain& terrain, std::mt19937& random) {
    const auto pick = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const TerrainInfo& info = terrain.info();
    const double heading = pick(-3, 3), pitch = pick(-1.2, -0.1);
    const Vec2 place = info.worldFromLattice.worldFromLattice(
        {pick(0.1, 0.9) * static_cast<double>(info.scheme.columns),
         pick(0.1, 0.9) * static_cast<double>(info.scheme.rows)});
    Camera camera;
    camera.width = 160;
    camera.height = 90;
    camera.forward = {std::sin(heading) * std::cos(pitch), std::cos(heading) * std::cos(pitch),
                      std::sin(pitch)};
    camera.right = {std::cos(heading), -std::sin(heading), 0};
    camera.up = glm::cross(camera.right, camera.forward);
    camera.eye = {place.x, place.y, static_cast<double>(info.maxZ) + pick(20, 3000)};
    return camera;
}

/// Hits of all pixels; slots are replaced by what they hold.
std::vector<Hit> hitsOf(const TerrainCut& cut, const RayFrame& rays) {
    std::vector<Ray> all;
    for (int y = 0; y < rays.camera().height; y += 3)
        for (int x = 0; x < rays.camera().width; x += 3) all.push_back(rays.rayThrough(x, y));
    std::vector<Hit> hits(all.size());
    TraceCounters counters;
    firstHits(cut, all, hits, counters);
    for (Hit& hit : hits) {
        if (!isHit(hit)) continue;
        const TileDesc& tile = cut.tiles[hit.tile];
        hit.tile = static_cast<uint32_t>(tile.x / kTileCells * 4096 + tile.y / kTileCells);
    }
    return hits;
}

void expectSameTile(const ResidentTerrain& whole, const ResidentTerrain& streamed, TileId id) {
    const ResidentTerrain::Pool &a = whole.pool(), &b = streamed.pool();
    const uint32_t slotA = a.slotOf(id), slotB = b.slotOf(id);
    ASSERT_NE(slotB, kNoSlot);
    EXPECT_TRUE(std::equal(a.bounds + a.tiles[slotA].bounds,
                           a.bounds + a.tiles[slotA].bounds + kSlotBounds,
                           b.bounds + b.tiles[slotB].bounds));
    constexpr int kSteps[][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    for (const auto& step : kSteps) {
        const uint32_t beside = b.numberOf({id.mip, id.x + step[0], id.y + step[1]});
        if (beside != kNoSlot && !b.isHere(beside)) return;
    }
    const auto sharpA = a.sharpness.begin() + ptrdiff_t{slotA} * kSlotSharpness;
    const auto sharpB = b.sharpness.begin() + ptrdiff_t{slotB} * kSlotSharpness;
    // Beside a hollow tile all counts as the rim of a hole: not less than what it is.
    for (uint32_t k = 0; k < kSlotSharpness; ++k) ASSERT_GE(sharpB[k], sharpA[k]);
}

TEST(Streamer, DrawsWhatAWholeTerrainDraws) {
    for (const auto format : {PostFormat::Int16, PostFormat::Float32}) {
        const test::ArraySource source(5000, 4100, format, test::hills(3, true));
        const Pair pair(source, 2, 44);
        ASSERT_NE(pair.streamed, nullptr);
        std::mt19937 random(5);
        uint64_t finest = 0;
        for (int view = 0; view < 8; ++view) {
            const Camera camera = cameraAt(*pair.whole, random);
            CutOptions options;
            options.tolerancePx = 4;
            options.sun = SunBound{{-0.6, 0.5, 0.6}};
            options.sampleShare = 8;
            const std::vector<TileId> wanted = wantedTiles(*pair.streamed, camera, options);
            ASSERT_LE(wanted.size(), pair.streamed->streamer()->room());
            ASSERT_TRUE(pair.streamed->streamer()->bring(wanted).ok());
            const FrameCut a = selectCut(*pair.whole, camera, options);
            const FrameCut b = selectCut(*pair.streamed, camera, options);
            EXPECT_EQ(a.tilesPerMip(), b.tilesPerMip());
            EXPECT_EQ(b.standIns(), 0u);
            finest += b.tilesPerMip()[0];
            for (const TileId id : wanted) expectSameTile(*pair.whole, *pair.streamed, id);
            const RayFrame rays(camera, source.info().worldFromLattice, 1, 0);
            const auto hitsA = hitsOf(a.cut(), rays), hitsB = hitsOf(b.cut(), rays);
            for (size_t k = 0; k < hitsA.size(); ++k) {
                ASSERT_EQ(isHit(hitsA[k]), isHit(hitsB[k]));
                if (!isHit(hitsA[k])) continue;
                ASSERT_EQ(hitsA[k].tile, hitsB[k].tile);
                ASSERT_EQ(hitsA[k].cell, hitsB[k].cell);
                ASSERT_NEAR(hitsA[k].t, hitsB[k].t, 1e-5f * hitsA[k].t);
            }
        }
        EXPECT_GT(finest, 20u);
        EXPECT_GT(pair.streamed->streamer()->figures().evicted, 0u);
    }
}

TEST(Streamer, LateTilesAreStoodInForAndTheCutIsWhole) {
    const test::ArraySource source(3000, 3000, PostFormat::Int16, test::hills(4, false));
    const Pair pair(source, 2, 44);
    ASSERT_NE(pair.streamed, nullptr);
    std::mt19937 random(8);
    Streamer& streamer = *pair.streamed->streamer();
    pair.troubles->isHeld = true;
    const Camera camera = cameraAt(*pair.whole, random);
    CutOptions options;
    options.tolerancePx = 0.5;
    options.sampleShare = 100;
    const auto wanted = wantedTiles(*pair.streamed, camera, options);
    EXPECT_GT(streamer.update(wanted), 0u);
    EXPECT_GT(streamer.update(wanted), 0u);  // asked again, and in the same slots
    const FrameCut late = selectCut(*pair.streamed, camera, options);
    EXPECT_GT(late.standIns(), 0u);
    EXPECT_EQ(late.tilesPerMip()[0], 0u);
    // A hit counts as late where the tile under it misses the tolerance, and only there.
    const RayFrame rays(camera, source.info().worldFromLattice, 1, 0);
    const auto countLate = [&](const FrameCut& cut, const Camera& from, const CutOptions& judged) {
        std::vector<Ray> all;
        for (int y = 0; y < camera.height; y += 3)
            for (int x = 0; x < camera.width; x += 3) all.push_back(rays.rayThrough(x, y));
        std::vector<Hit> hits(all.size());
        TraceCounters counters;
        firstHits(cut.cut(), all, hits, counters);
        const TileRule rule(*pair.streamed, from, judged);
        size_t count = 0;
        for (const Hit& hit : hits) {
            if (!isHit(hit)) continue;
            const ResidentTerrain::Pool& pool = pair.streamed->pool();
            const uint64_t blocks = rule.lateBlocks(pool.numberOf(pool.ids[hit.tile]));
            const uint32_t block = cellY(hit) / 64 * 8 + cellX(hit) / 64;
            EXPECT_EQ(cut.isLate(hit), (blocks >> block & 1u) != 0);
            count += cut.isLate(hit) ? 1 : 0;
        }
        return count;
    };
    EXPECT_GT(countLate(late, camera, options), 100u);
    for (int k = 0; k < 500; ++k) {
        std::uniform_real_distribution<double> at(0, 2999);
        EXPECT_NE(surfaceCellAt(late.cut(), at(random), at(random)).slot, kNoSlot);
    }
    pair.troubles->isHeld = false;
    ASSERT_TRUE(streamer.bring(wanted).ok());
    EXPECT_EQ(streamer.update(wanted), 0u);
    const FrameCut whole = selectCut(*pair.streamed, camera, options, wanted);
    EXPECT_EQ(whole.standIns(), 0u);
    EXPECT_EQ(countLate(whole, camera, options), 0u);
}

TEST(Streamer, BrokenTilesAreTriedAgainAndThenNamed) {
    const test::ArraySource source(1500, 1500, PostFormat::Float32, test::hills(5, false));
    const Pair pair(source, 1, 40);
    ASSERT_NE(pair.streamed, nullptr);
    Streamer& streamer = *pair.streamed->streamer();
    const std::vector<TileId> wanted{{0, 1, 1}, {0, 0, 1}};
    pair.troubles->failures = 3;
    EXPECT_TRUE(streamer.bring(wanted).ok());
    EXPECT_EQ(streamer.figures().failed, 3u);
    const std::vector<TileId> other{{0, 2, 2}};
    pair.troubles->failures = 1000;
    const auto failed = streamer.bring(other);
    ASSERT_FALSE(failed.ok());
    EXPECT_NE(failed.error().message.find("(2, 2) is broken"), std::string::npos);
    EXPECT_EQ(pair.streamed->slotOf({0, 2, 2}), kNoSlot);
    pair.troubles->failures = 0;
    while (streamer.update(other) > 0) std::this_thread::yield();  // recovers by itself
    EXPECT_NE(pair.streamed->slotOf({0, 2, 2}), kNoSlot);
}

TEST(Streamer, EndsWhileReadsHang) {
    const test::ArraySource source(1500, 1500, PostFormat::Float32, test::hills(5, false));
    Pair pair(source, 1, 40);
    ASSERT_NE(pair.streamed, nullptr);
    pair.troubles->isHeld = true;
    const int before = pair.troubles->reads;
    const std::vector<TileId> wanted{{0, 1, 1}};
    EXPECT_EQ(pair.streamed->streamer()->update(wanted), 1u);
    while (pair.troubles->reads == before) std::this_thread::yield();
    pair.streamed.reset();
    EXPECT_FALSE(pair.troubles->isHeld);
}

TEST(Streamer, AFlightNeverHoldsMoreThanItsSlotsNorLosesOne) {
    const test::ArraySource source(4097, 4097, PostFormat::Int16, test::hills(6, true));
    const Pair pair(source, 2, 44);
    ASSERT_NE(pair.streamed, nullptr);
    const ResidentTerrain::Pool& pool = pair.streamed->pool();
    std::mt19937 random(9);
    CutOptions options;
    options.sampleShare = 4;
    for (int frame = 0; frame < 60 / test::kLess; ++frame) {
        const Camera camera = cameraAt(*pair.whole, random);
        const auto wanted = wantedTiles(*pair.streamed, camera, options);
        if (frame % 6 == 0 && wanted.size() <= pair.streamed->streamer()->room())
            ASSERT_TRUE(pair.streamed->streamer()->bring(wanted).ok());
        else
            pair.streamed->streamer()->update(wanted);
        std::set<uint32_t> slots;
        for (uint32_t number = 0; number < pool.slots.size(); ++number) {
            const uint32_t slot = pool.slots[number];
            if (slot == kNoSlot) continue;
            EXPECT_TRUE(slots.insert(slot).second);
            EXPECT_EQ(pool.ids[slot], pool.tileOf(number));
        }
        const FrameCut cut = selectCut(*pair.streamed, camera, options);
        EXPECT_FALSE(
            hitsOf(cut.cut(), RayFrame(camera, source.info().worldFromLattice, 1, 0)).empty());
    }
    EXPECT_GT(pair.streamed->streamer()->figures().loaded, 30u);
}

TEST(Streamer, RefusesMemoryThatHoldsTooLittle) {
    const test::ArraySource source(3000, 3000, PostFormat::Int16, test::hills(4, false));
    EXPECT_EQ(Pair(source, 1, 20).streamed, nullptr);
    EXPECT_NE(Pair(source, 1, 40).streamed, nullptr);
}

TEST(RayTiles, HoldTheTileOfTheFirstHit) {
    const test::ArraySource source(4097, 3000, PostFormat::Float32, test::hills(7, true));
    const Pair pair(source, 2, 44);
    ASSERT_NE(pair.streamed, nullptr);
    const FrameCut finest = finestCut(*pair.whole, kSurfaceBilinear);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> at(-500, 4500), height(-200, 1500), turn(-1, 1);
    int hits = 0;
    size_t most = 0;
    for (int k = 0; k < 400; ++k) {
        Ray ray;
        ray.x = at(random), ray.y = at(random), ray.z = height(random);
        ray.dx = turn(random), ray.dy = turn(random), ray.dz = 20 * turn(random);
        if (k % 7 == 0) ray.dx = 0;
        if (k % 50 == 0) ray.x = 512 * (k / 50);
        ray.bend = k % 2 ? 1e-3 : 0;
        const oracle::ExactHit hit = oracle::firstHit(finest.cut(), ray);
        const auto along = tilesAlong(*pair.streamed, ray, kSurfaceBilinear);
        most = std::max(most, along.size());
        if (!isHit(hit.hit)) continue;
        ++hits;
        const TileId id = pair.whole->pool().ids[hit.hit.tile];
        const auto found = std::find_if(along.begin(), along.end(),
                                        [&](const RayTile& tile) { return tile.id == id; });
        ASSERT_NE(found, along.end());
        EXPECT_LE(found->enter, hit.t);
    }
    EXPECT_GT(hits, 60);
    EXPECT_LT(most, 30u);  // of 48
}

}  // namespace
}  // namespace terray
