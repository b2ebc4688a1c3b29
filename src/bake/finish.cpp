// SPDX-License-Identifier: Apache-2.0
// Assembling what was measured shard by shard, and the files that bind the store together.
#include "bake/finish.h"

#include <algorithm>

#include "base/assert.h"
#include "store/bounds_file.h"
#include "store/edges.h"
#include "store/vrt.h"
#include "tile/block_bounds.h"

namespace terray {
namespace {

constexpr uint64_t kMostMeasuredBytes = uint64_t{1} << 30;

class Assembler {
public:
    explicit Assembler(Workshop& shop) : shop_(shop), info_(shop.info()) {
        for (int mip = 0; mip < info_.scheme.mipCount(); ++mip) {
            bounds_.emplace_back(static_cast<size_t>(int64_t{boundsX(info_.scheme, mip)} *
                                                     boundsY(info_.scheme, mip)));
        }
    }

    Result<HeightTally> run() {
        for (int mip = 0; mip < mips(); ++mip) TERRAY_TRY(takeMip(mip));
        for (int mip = 1; mip < mips(); ++mip) inherit(mip);
        for (int mip = 0; mip < mips(); ++mip) {
            const auto encoded = encodeBounds(info_, mip, bounds_[static_cast<size_t>(mip)]);
            if (!encoded) return encoded.error();
            TERRAY_TRY(shop_.folder.finish(boundsPath(mip), encoded->bytes, {}));
        }
        return tally_;
    }

private:
    int mips() const { return info_.scheme.mipCount(); }

    /// Also writes the edge file, which is as large as one percent of the posts.
    Result<void> takeMip(int mip) {
        const BlockGrid grid = shop_.grid(mip);
        Bytes edges = encodeEdgeHeader(info_, mip);
        edges.resize(edgeFileBytes(info_, mip));
        for (const ShardId shard : shardsOf(grid, mip, 0, grid.blocksY)) {
            const std::string path = shop_.folder.pathOf(measuredPath(shard));
            const auto bytes = readFile(path, kMostMeasuredBytes);
            if (!bytes) return bytes.error();
            Measured measured;
            if (!decodeMeasured(*bytes, measured)) {
                return makeError(ErrorCode::Failed, "'{}' is damaged; run the same command again",
                                 path);
            }
            TERRAY_TRY(takeShard(shard, measured, edges));
        }
        return shop_.folder.finish(edgesPath(mip), edges, edgeRanges(info_, mip));
    }

    Result<void> takeShard(ShardId shard, const Measured& measured, Bytes& edges) {
        tally_.add(measured.tally);
        const int width = boundsX(info_.scheme, shard.mip);
        std::vector<BlockBounds>& bounds = bounds_[static_cast<size_t>(shard.mip)];
        for (size_t t = 0; t < measured.tiles.size(); ++t) {
            const Measured::Tile& tile = measured.tiles[t];
            const TileId id{shard.mip, shard.x0 + static_cast<int>(t), shard.y};
            const BlockRange range = edgeRange(info_, id);
            if (tile.edges.size() != range.size || range.offset + range.size > edges.size()) {
                return makeError(ErrorCode::Failed, "'{}' is damaged; run the same command again",
                                 shop_.folder.pathOf(measuredPath(shard)));
            }
            std::copy(tile.edges.begin(), tile.edges.end(),
                      edges.begin() + static_cast<ptrdiff_t>(range.offset));
            for (int k = 0; k < kTileBlocks * kTileBlocks; ++k) {
                const int64_t x = int64_t{id.x} * kTileBlocks + k % kTileBlocks;
                const int64_t y = int64_t{id.y} * kTileBlocks + k / kTileBlocks;
                BlockBounds& out = bounds[static_cast<size_t>(y * width + x)];
                const float error = out.errorToFinest;  // of finer mips, met before
                out = tile.blocks[k];
                out.errorToFinest = error;
            }
        }
        for (const Measured::CoarseError& found : measured.errors) {
            BlockBounds& out = bounds_[found.mip][found.block];
            out.errorToFinest = std::max(out.errorToFinest, found.error);
        }
        return {};
    }

    void inherit(int mip) {
        const int width = boundsX(info_.scheme, mip), height = boundsY(info_.scheme, mip);
        const int finerWidth = boundsX(info_.scheme, mip - 1);
        const int finerHeight = boundsY(info_.scheme, mip - 1);
        const std::vector<BlockBounds>& finer = bounds_[static_cast<size_t>(mip - 1)];
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                BlockBounds& out =
                    bounds_[static_cast<size_t>(mip)][static_cast<size_t>(int64_t{y} * width + x)];
                float sum = 0;
                for (int child = 0; child < 4; ++child) {
                    const int cx = 2 * x + child % 2, cy = 2 * y + child / 2;
                    if (cx >= finerWidth || cy >= finerHeight) continue;
                    const BlockBounds& in =
                        finer[static_cast<size_t>(int64_t{cy} * finerWidth + cx)];
                    inheritFromFiner(out, in, mip);
                    sum = std::max(sum, in.errorToFinest + in.errorToNext);
                }
                if (mip > kLastComparedMip) {
                    out.errorToFinest = sum * (1 + 0x1p-20f);
                } else if (mip > 1) {
                    out.errorToFinest = withRounding(out.errorToFinest, out, mip);
                }
                setCoverage(out, info_.worldFromLattice, mip);
            }
        }
    }

    Workshop& shop_;
    const TerrainInfo& info_;
    std::vector<std::vector<BlockBounds>> bounds_;
    HeightTally tally_;
};

/// The files of a store, in the order of the manifest and of hashes.bin.
std::vector<std::string> storeFiles(const TerrainInfo& info, bool inPlace) {
    std::vector<std::string> files;
    const int mips = info.scheme.mipCount();
    for (int mip = inPlace ? 1 : 0; mip < mips; ++mip) {
        const BlockGrid grid(info.scheme, mip);
        for (const ShardId shard : shardsOf(grid, mip, 0, grid.blocksY)) {
            files.push_back(shardPath(shard));
        }
    }
    for (int mip = 0; mip < mips; ++mip) files.push_back(edgesPath(mip));
    for (int mip = 0; mip < mips; ++mip) files.push_back(boundsPath(mip));
    for (int mip = 1; mip < mips; ++mip) files.push_back(mipVrtPath(mip));
    files.push_back(kHeightVrtName);
    return files;
}

}  // namespace

Result<HeightTally> assembleMeasured(Workshop& shop) { return Assembler(shop).run(); }

Result<void> finishStore(Workshop& shop, const HeightTally& tally) {
    const TerrainInfo& info = shop.info();
    for (int mip = 0; mip < info.scheme.mipCount(); ++mip) {
        const auto text = vrtText(info, mip, shop.plan.manifest.inPlace);
        if (!text) return text.error();
        TERRAY_TRY(
            shop.folder.finish(mip == 0 ? kHeightVrtName : mipVrtPath(mip), bytesOf(*text), {}));
    }
    StoreManifest manifest = shop.plan.manifest;
    manifest.files = storeFiles(info, manifest.inPlace.has_value());
    if (manifest.photo) {
        const std::vector<std::string> more = photoFiles(*manifest.photo);
        manifest.files.insert(manifest.files.end(), more.begin(), more.end());
    }
    manifest.holes = tally.holes;
    if (tally.minZ <= tally.maxZ) {
        manifest.info.minZ = tally.minZ;
        manifest.info.maxZ = tally.maxZ;
    } else {
        manifest.info.minZ = manifest.info.maxZ = 0;
    }
    std::vector<FileHashes> hashes;
    for (const std::string& file : manifest.files) {
        const FileHashes* found = shop.folder.hashesOf(file);
        TERRAY_ASSERT(found != nullptr);
        hashes.push_back(*found);
    }
    const Bytes bytes = encodeHashes(hashes);
    manifest.hashes = hashText(hashOf(bytes));
    manifest.plan = hashText(hashOf(bytesOf(shop.plan.text())));
    const FileCalls& calls = *shop.plan.calls;
    TERRAY_TRY(replaceFile(calls, shop.folder.pathOf(kHashesName), bytes));
    TERRAY_TRY(
        replaceFile(calls, shop.folder.pathOf(kManifestName), bytesOf(manifestText(manifest))));
    return shop.folder.removeFolder(kMeasuredFolder);
}

}  // namespace terray
