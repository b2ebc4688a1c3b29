// SPDX-License-Identifier: Apache-2.0
// Asking ahead, noting what was missing, bringing it.
#include "engine/frame_photo.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "base/log.h"

namespace terray {
namespace {

constexpr int kScoutPixels = 16;       ///< of the picture, for one of the small one
constexpr double kScoutRays = 10'000;  ///< at most, about

using Blocks = std::vector<uint32_t>;

/// Both are in order: coarse ones first.
Blocks joined(const Blocks& a, const Blocks& b) {
    Blocks all;
    std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all),
                   std::greater<>());
    return all;
}

}  // namespace

FramePhoto::FramePhoto(const Terrain::State& state, const RenderOptions& options)
    : photo_(*state.storedPhoto),
      state_(state),
      waits_(options.waitForTiles),
      allowMissing_(options.allowMissing),
      before_(photo_.figures()) {}

Blocks FramePhoto::blocksIn(const Shader& shader, const RayFrame& rays) const {
    Camera small = rays.camera();
    const double most = std::sqrt(small.width * (small.height / kScoutRays));
    const int pixels = std::max(kScoutPixels, static_cast<int>(std::ceil(most)));
    small.width = (small.width + pixels - 1) / pixels;
    small.height = (small.height + pixels - 1) / pixels;
    PhotoUse use;
    shader.prepareUse(use);
    shader.scoutPhoto(RayFrame(small, rays.worldFromLattice(), rays.exaggeration(), rays.bend()),
                      pixels, use);
    return photo_.blocksOf(use);
}

void FramePhoto::scout(const Shader& shader, const RayFrame& rays,
                       const std::optional<Camera>& soon) {
    const Blocks wanted = blocksIn(shader, rays);
    if (waits_) {
        // Bands wait for what they need; this only saves making them again.
        if (wanted.size() <= photo_.room()) static_cast<void>(photo_.bring(wanted));
        return;
    }
    Blocks next;
    if (soon)
        next = blocksIn(shader,
                        RayFrame(*soon, rays.worldFromLattice(), rays.exaggeration(), rays.bend()));
    photo_.update(photo_.withCoarser(joined(wanted, state_.lastPhotoBlocks)),
                  photo_.withCoarser(next));
}

void FramePhoto::note(const ImageTile& tile, const PhotoUse& use) {
    Blocks blocks = photo_.blocksOf(use);
    const std::lock_guard lock(mutex_);
    if (!isFinishing_) wanted_ = joined(wanted_, blocks);
    if (waits_ && !isFinishing_ && !use.missing.empty())
        unfinished_.push_back({tile, std::move(blocks)});
    else
        lateSamples_ += use.lateSamples;
}

Result<void> FramePhoto::bring(Blocks& blocks) const {
    if (blocks.size() > photo_.room()) {
        if (!std::exchange(hasWarned_, true))
            log::warning(
                "memory holds {} blocks of the photo, too few for what one place shows: it is "
                "coarser "
                "there (raise --memory)",
                photo_.room());
        blocks.resize(photo_.room());
    }
    const Result<void> brought = photo_.bring(blocks);
    if (brought || brought.error().code == ErrorCode::Interrupted || allowMissing_) return brought;
    return makeError(ErrorCode::Failed, "{} (--allow-missing draws a coarser one instead)",
                     brought.error().message);
}

Result<void> FramePhoto::finishBand(const std::function<void(std::span<const ImageTile>)>& make) {
    isFinishing_ = true;
    while (!unfinished_.empty()) {
        std::vector<ImageTile> tiles;
        Blocks blocks;
        while (!unfinished_.empty()) {
            Blocks more = joined(blocks, unfinished_.back().blocks);
            if (!tiles.empty() && more.size() > photo_.room()) break;
            blocks = std::move(more);
            tiles.push_back(unfinished_.back().tile);
            unfinished_.pop_back();
        }
        const Result<void> brought = bring(blocks);
        if (!brought && !(allowMissing_ && brought.error().code != ErrorCode::Interrupted))
            return brought;
        make(tiles);
    }
    isFinishing_ = false;
    return {};
}

PhotoFigures FramePhoto::figures() const {
    const StreamFigures& now = photo_.figures();
    PhotoFigures figures;
    figures.wanted = wanted_.size();
    figures.loaded = now.loaded - before_.loaded;
    figures.evicted = now.evicted - before_.evicted;
    figures.bytesRead = now.bytesRead - before_.bytesRead;
    figures.lateSamples = lateSamples_;
    const std::vector<uint32_t>& slots = photo_.pages().slots;
    if (lateSamples_ > 0)
        figures.absent = static_cast<uint64_t>(std::count_if(
            wanted_.begin(), wanted_.end(), [&](uint32_t b) { return slots[b] == kNoSlot; }));
    state_.lastPhotoBlocks = wanted_;
    return figures;
}

}  // namespace terray
