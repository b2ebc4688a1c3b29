// SPDX-License-Identifier: Apache-2.0
// The steps of a bake, and what an earlier run leaves to be done.
#include "bake/bake_store.h"

#include <algorithm>
#include <filesystem>

#include "bake/finish.h"
#include "bake/measure.h"
#include "bake/workshop.h"
#include "base/log.h"
#include "store/format.h"

namespace terray {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 34;
constexpr int kCacheShare = 3;  ///< of the memory budget

std::string withoutSlash(std::string path) {
    while (path.size() > 1 && path.ends_with('/')) path.pop_back();
    return path;
}

bool isThere(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
}

/// The manifest of the store at `out` if it was made by this very plan; its files may be damaged.
std::optional<StoreManifest> sameStore(const BakePlan& plan, const std::string& out) {
    const auto bytes = readFile(out + "/" + kManifestName, kMostBytes);
    if (!bytes) return std::nullopt;
    auto manifest =
        parseManifest(kManifestName, {reinterpret_cast<const char*>(bytes->data()), bytes->size()});
    if (!manifest || manifest->plan != hashText(hashOf(bytesOf(plan.text())))) return std::nullopt;
    return std::move(*manifest);
}

/// Hashes of the store's files; none if they cannot be trusted.
std::vector<FileHashes> trustedHashes(const StoreManifest& manifest, const std::string& out) {
    const auto bytes = readFile(out + "/" + kHashesName, kMostBytes);
    if (!bytes || hashText(hashOf(*bytes)) != manifest.hashes) return {};
    auto hashes = decodeHashes(kHashesName, *bytes);
    return hashes ? std::move(*hashes) : std::vector<FileHashes>{};
}

std::vector<FileHashes> wholeFiles(const std::vector<FileHashes>& all, const std::string& out) {
    std::vector<FileHashes> whole;
    for (const FileHashes& file : all) {
        const auto bytes = readFile(out + "/" + file.path, file.size);
        if (bytes.ok() && compareFile(file, *bytes).isNone()) whole.push_back(file);
    }
    return whole;
}

bool hasAll(const WorkFolder& folder, int mips, std::string (*pathOf)(int)) {
    for (int mip = 0; mip < mips; ++mip) {
        if (!folder.isFinished(pathOf(mip))) return false;
    }
    return true;
}

/// Sources may not change while they are read: their posts would not belong together.
Result<void> checkSources(const BakePlan& plan) {
    std::vector<StoreSource> sources = plan.manifest.sources;
    const std::vector<StoreSource>& photos = plan.manifest.photoSources;
    sources.insert(sources.end(), photos.begin(), photos.end());
    for (const StoreSource& source : sources) {
        const auto now = stateOf(source.name);
        if (!now) return now.error();
        if (*now == source) continue;
        return makeError(
            ErrorCode::Input,
            "'{}' has changed while it was baked; remove the '.baking' folder and bake "
            "again",
            source.name);
    }
    return {};
}

double blocksOfAll(const TilingScheme& scheme) {
    double blocks = 0;
    for (int mip = 0; mip < scheme.mipCount(); ++mip) {
        const BlockGrid grid(scheme, mip);
        blocks += static_cast<double>(grid.blocksX) * grid.blocksY;
    }
    return blocks;
}

Result<void> makeStore(const BakePlan& plan, WorkFolder& folder,
                       const std::optional<StoreManifest>& repaired) {
    const TilingScheme& scheme = plan.info().scheme;
    BlockCache cache(plan.info(), plan.memoryBytes / kCacheShare);
    const std::optional<PhotoLayer>& photo = plan.manifest.photo;
    Progress progress("Baking", 2 * blocksOfAll(scheme) + (photo ? photoBlockCount(*photo) : 0));
    Workshop shop{plan, folder, cache, progress};
    TERRAY_TRY(makeHeights(shop));
    TERRAY_TRY(makePhoto(shop));
    TERRAY_TRY(checkSources(plan));
    const int mips = scheme.mipCount();
    HeightTally tally;
    if (repaired && hasAll(folder, mips, edgesPath) && hasAll(folder, mips, boundsPath)) {
        tally = {repaired->info.minZ, repaired->info.maxZ, repaired->holes};
    } else {
        TERRAY_TRY(measureAll(shop));
        const auto assembled = assembleMeasured(shop);
        if (!assembled) return assembled.error();
        tally = *assembled;
    }
    return finishStore(shop, tally);
}

}  // namespace

Result<BakeOutcome> bakeStore(const BakePlan& plan, const std::string& out, bool repair) {
    const std::string store = withoutSlash(out);
    auto lock = StoreLock::take(store);
    if (!lock) return lock.error();
    if (isThere(store) && !isThere(store + "/" + kManifestName)) {
        return makeError(ErrorCode::Failed,
                         "'{}' is there and is no store; name another one with -o, or remove it",
                         store);
    }
    BakeOutcome outcome;
    const std::optional<StoreManifest> same = sameStore(plan, store);
    std::vector<FileHashes> whole;
    if (same && !WorkFolder::hasBegun(store)) {
        outcome.wasDone = !repair;
        if (outcome.wasDone) return outcome;
        const std::vector<FileHashes> all = trustedHashes(*same, store);
        whole = wholeFiles(all, store);
        outcome.foundFiles = whole.size();
        outcome.wasDone = !all.empty() && whole.size() == all.size();
        if (outcome.wasDone) return outcome;
    }
    auto folder = WorkFolder::open(*plan.calls, store, plan.text());
    if (!folder) return folder.error();
    outcome.foundFiles += (*folder)->foundFiles();
    for (const FileHashes& file : whole) TERRAY_TRY((*folder)->adopt(store, file));
    TERRAY_TRY(makeStore(plan, **folder, whole.empty() ? std::nullopt : same));
    TERRAY_TRY((*folder)->publish());
    return outcome;
}

}  // namespace terray
