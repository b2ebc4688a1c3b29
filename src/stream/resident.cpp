// SPDX-License-Identifier: Apache-2.0
// Building a resident terrain: size check, reading, then everything that follows from mip 0.
#include "stream/resident.h"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "stream/build_mips.h"
#include "stream/load.h"
#include "stream/pool.h"
#include "stream/streamer.h"

namespace terray {
namespace {

constexpr double kGiB = 1 << 30;
constexpr double kMostSlots = static_cast<double>(kLargestPoolBytes) / (kSlotPosts * sizeof(float));
constexpr double kLeastRoom = 16;       ///< tiles of a frame, beside those that stay
constexpr int kRemoteThreads = 8;       ///< that read
constexpr double kWorkBytes = 8 << 20;  ///< windows that are worked on, per terrain

Result<void> checkSize(const TerrainInfo& info, uint64_t memoryBytes) {
    const PoolSizes sizes = poolSizes(info);
    const double needed = sizes.total() + kWorkBytes;
    if (needed > static_cast<double>(memoryBytes)) {
        return makeError(ErrorCode::Input,
                         "'{}' ({} x {} posts) needs {:.2f} GiB of memory, but only {:.2f} GiB may "
                         "be used; raise --memory or take a smaller window of the data",
                         info.name, info.scheme.columns, info.scheme.rows, needed / kGiB,
                         static_cast<double>(memoryBytes) / kGiB);
    }
    if (std::max(sizes.postBytes, sizes.boundBytes) > static_cast<double>(kLargestPoolBytes)) {
        return makeError(ErrorCode::Input,
                         "'{}' ({} x {} posts) is too large to be held in memory at once; take a "
                         "smaller window of the data or a coarser copy of it",
                         info.name, info.scheme.columns, info.scheme.rows);
    }
    return {};
}

}  // namespace

ResidentTerrain::ResidentTerrain() = default;
ResidentTerrain::~ResidentTerrain() = default;

uint64_t ResidentTerrain::requiredBytes(const TerrainInfo& info) {
    return static_cast<uint64_t>(std::min(poolSizes(info).total() + kWorkBytes, 0x1p63));
}

Result<std::unique_ptr<ResidentTerrain>> ResidentTerrain::make(const TerrainInfo& info,
                                                               uint64_t memoryBytes) {
    TERRAY_TRY(checkSize(info, memoryBytes));
    std::unique_ptr<ResidentTerrain> terrain(new ResidentTerrain);
    terrain->info_ = info;
    auto pool = Pool::make(terrain->info_);
    if (!pool) return pool.error();
    terrain->pool_ = std::move(*pool);
    return terrain;
}

Result<std::unique_ptr<ResidentTerrain>> ResidentTerrain::build(const HeightSource& source,
                                                                uint64_t memoryBytes,
                                                                BuildStats& stats) {
    auto terrain = make(source.info(), memoryBytes);
    if (!terrain) return terrain.error();
    ResidentTerrain& made = **terrain;

    const Stopwatch loading;
    const auto loaded = loadFinest(source, *made.pool_);
    if (!loaded) return loaded.error();
    made.info_.minZ = loaded.value().minZ;
    made.info_.maxZ = loaded.value().maxZ;
    releaseFreedMemory();
    stats.loadMs = loading.elapsedMs();

    const Stopwatch building;
    TERRAY_TRY(buildMips(*made.pool_));
    releaseFreedMemory();
    stats.buildMs = building.elapsedMs();
    stats.holes = loaded.value().holes;
    stats.residentBytes = made.residentBytes();
    return terrain;
}

Result<std::unique_ptr<ResidentTerrain>> ResidentTerrain::build(const TileSource& source,
                                                                uint64_t memoryBytes,
                                                                BuildStats& stats) {
    auto terrain = make(source.info(), memoryBytes);
    if (!terrain) return terrain.error();
    ResidentTerrain& made = **terrain;
    const Stopwatch loading;
    TERRAY_TRY(loadTiles(source, *made.pool_));
    releaseFreedMemory();
    stats.loadMs = loading.elapsedMs();
    const Stopwatch building;
    TERRAY_TRY(takeMips(source, *made.pool_));
    stats.buildMs = building.elapsedMs();
    stats.holes = source.holes();
    stats.residentBytes = made.residentBytes();
    return terrain;
}

Result<std::unique_ptr<ResidentTerrain>> ResidentTerrain::stream(std::unique_ptr<TileSource> source,
                                                                 int firstKept, uint64_t poolBytes,
                                                                 BuildStats& stats) {
    const Stopwatch loading;
    const TerrainInfo& info = source->info();
    const double perSlot = poolSizes(info, 1).total() - poolSizes(info, 0).total();
    const double left = static_cast<double>(poolBytes) - poolSizes(info, 0).total();
    // More slots than tiles are of no use; as many would pass for a whole terrain.
    const double most = std::min({std::floor(std::max(left, 0.0) / perSlot), kMostSlots,
                                  poolSizes(info).slots + kLeastRoom});
    double kept = 0;
    for (int mip = firstKept; mip < info.scheme.mipCount(); ++mip) {
        kept += static_cast<double>(info.scheme.tileCount(mip));
    }
    if (most < kept + kLeastRoom) {
        return makeError(ErrorCode::Input,
                         "'{}': {:.0f} MiB of memory hold {:.0f} tiles, too few to show it; raise "
                         "--memory by {:.0f} MiB",
                         info.name, static_cast<double>(poolBytes) / 0x1p20, most,
                         (kept + kLeastRoom - most) * perSlot / 0x1p20 + 1);
    }
    std::unique_ptr<ResidentTerrain> terrain(new ResidentTerrain);
    terrain->info_ = info;
    auto pool = Pool::makeFree(info, static_cast<uint32_t>(most));
    if (!pool) return pool.error();
    terrain->pool_ = std::move(*pool);
    terrain->pool_->firstKept = firstKept;
    terrain->pool_->takeBlocks(*source);
    source->dropBounds();
    const int threads = source->isRemote() ? kRemoteThreads : loaderThreads();
    auto streamer = Streamer::make(*source, *terrain->pool_, threads);
    if (!streamer) return streamer.error();
    terrain->streamer_ = std::move(*streamer);
    stats.loadMs = loading.elapsedMs();
    stats.holes = source->holes();
    stats.residentBytes = terrain->residentBytes();
    terrain->source_ = std::move(source);
    return terrain;
}

uint64_t ResidentTerrain::residentBytes() const {
    return static_cast<uint64_t>(
        poolSizes(info_, static_cast<double>(pool_->tiles.size())).total());
}

int ResidentTerrain::mipCount() const { return pool_->mips; }

uint32_t ResidentTerrain::slotOf(TileId id) const { return pool_->slotOf(id); }

std::span<const BlockBounds> ResidentTerrain::blocks(uint32_t slot) const {
    return pool_->blocksOf(pool_->numberOf(pool_->ids[slot]));
}

}  // namespace terray
