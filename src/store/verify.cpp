// SPDX-License-Identifier: Apache-2.0
// From hashes that differ to the names of tiles.
#include "store/verify.h"

#include <algorithm>
#include <cstdio>
#include <mutex>

#include "base/progress.h"
#include "base/workers.h"
#include "dataset/remote.h"
#include "store/files.h"
#include "store/format.h"
#include "store/hashes.h"
#include "store/manifest.h"

namespace terray {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 34;

std::string tileName(int mip, int x, int y) {
    return fmt::format("tile ({}, {}) of mip {}", x, y, mip);
}

/// Blocks of a photo file: of colours; as many masks may follow.
size_t photoBlocks(const std::optional<PhotoLayer>& photo, ShardId shard) {
    if (!photo || shard.mip < 0 || shard.mip >= photo->mipCount()) return kShardBlocks;
    return static_cast<size_t>(std::clamp(photo->grid(shard.mip).blocksOf(shard), 1, kShardBlocks));
}

/// What block k of a file is for people.
std::string blockName(const FileHashes& file, size_t k, const TilingScheme& scheme,
                      const std::optional<PhotoLayer>& photo) {
    ShardId shard;
    if (std::sscanf(file.path.c_str(), "height/m%d/y%d_x%d.tif", &shard.mip, &shard.y, &shard.x0) ==
        3) {
        return tileName(shard.mip, shard.x0 + static_cast<int>(k), shard.y);
    }
    if (std::sscanf(file.path.c_str(), "photo/m%d/y%d_x%d.tif", &shard.mip, &shard.y, &shard.x0) ==
        3) {
        const size_t blocks = photoBlocks(photo, shard);
        return fmt::format("{}block ({}, {}) of mip {} of the photo", k < blocks ? "" : "mask of ",
                           shard.x0 + static_cast<int>(k % blocks), shard.y, shard.mip);
    }
    int mip = 0;
    if (std::sscanf(file.path.c_str(), "edges/m%d.bin", &mip) == 1 && mip >= 0 &&
        mip < scheme.mipCount()) {
        const auto tilesX = static_cast<size_t>(scheme.tilesX(mip));
        return "edges of " +
               tileName(mip, static_cast<int>(k % tilesX), static_cast<int>(k / tilesX));
    }
    return fmt::format("block {}", k);
}

std::vector<std::string> describe(const FileHashes& file, const FileDamage& damage,
                                  const TilingScheme& scheme,
                                  const std::optional<PhotoLayer>& photo) {
    std::vector<std::string> lines;
    if (damage.size) lines.push_back(fmt::format("{}: is not {} bytes long", file.path, file.size));
    for (const size_t k : damage.blocks) {
        lines.push_back(
            fmt::format("{}: {} is damaged", file.path, blockName(file, k, scheme, photo)));
    }
    if (damage.rest) {
        const char* what = file.blocks.empty() ? "is damaged" : "its header is damaged";
        lines.push_back(fmt::format("{}: {}", file.path, what));
    }
    return lines;
}

/// Names and hashes must be of the same files, or a missing one would go unseen.
bool areOfOneStore(const StoreManifest& manifest, const std::vector<FileHashes>& hashes) {
    return std::equal(
        manifest.files.begin(), manifest.files.end(), hashes.begin(), hashes.end(),
        [](const std::string& name, const FileHashes& file) { return name == file.path; });
}

}  // namespace

Result<StoreCheck> checkStore(const std::string& path) {
    StoreCheck check;
    const auto text = readFile(fileIn(path, kManifestName), kMostBytes);
    if (!text) {
        return makeError(ErrorCode::Input, "'{}' is not a store: {}", shownName(path),
                         text.error().message);
    }
    check.files = 2;
    check.bytes = text->size();
    const auto manifest =
        parseManifest(kManifestName, {reinterpret_cast<const char*>(text->data()), text->size()});
    if (!manifest) check.damage.push_back(manifest.error().message);
    const auto hashBytes = readFile(fileIn(path, kHashesName), kMostBytes);
    auto hashes = hashBytes ? decodeHashes(kHashesName, *hashBytes)
                            : Result<std::vector<FileHashes>>(hashBytes.error());
    if (!hashes) {
        check.damage.push_back(hashes.error().message);
        return check;
    }
    check.bytes += hashBytes->size();
    if (manifest &&
        (hashText(hashOf(*hashBytes)) != manifest->hashes || !areOfOneStore(*manifest, *hashes))) {
        check.damage.push_back(
            fmt::format("{}: does not belong to {}", kHashesName, kManifestName));
    }
    if (manifest && manifest->inPlace) {
        const auto same = checkInPlace(*manifest->inPlace, manifest->sources[0], path);
        if (!same) check.damage.push_back(same.error().message);
    }
    const TilingScheme scheme = manifest ? manifest->info.scheme : TilingScheme{2, 2};
    const std::optional<PhotoLayer> photo = manifest ? manifest->photo : std::nullopt;
    std::vector<std::vector<std::string>> found(hashes->size());
    Progress progress("Verifying", static_cast<double>(hashes->size()));
    const auto makeNothing = [] { return Result<int>(0); };
    const auto compare = [&](int&, int64_t task) -> Result<void> {
        const auto k = static_cast<size_t>(task);
        const FileHashes& file = (*hashes)[k];
        const auto bytes = readFile(fileIn(path, file.path), kMostBytes);
        found[k] = bytes ? describe(file, compareFile(file, *bytes), scheme, photo)
                         : std::vector<std::string>{file.path + ": is missing or cannot be read"};
        progress.advance();
        return {};
    };
    TERRAY_TRY(forEachTask(static_cast<int64_t>(hashes->size()), makeNothing, compare));
    for (size_t k = 0; k < found.size(); ++k) {
        const FileHashes& file = (*hashes)[k];
        ++check.files;
        check.bytes += file.size;
        if (file.path.starts_with("height/m")) check.tiles += file.blocks.size();
        check.damage.insert(check.damage.end(), found[k].begin(), found[k].end());
    }
    return check;
}

}  // namespace terray
