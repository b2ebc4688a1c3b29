// SPDX-License-Identifier: Apache-2.0
// Opening, keeping and giving up a terrain's device; casting a few image tiles ahead.
#include "engine/device_cast.h"

#include <algorithm>
#include <cstdlib>

#include "base/assert.h"
#include "base/log.h"
#include "device/devices.h"

namespace terray {
namespace {

constexpr int kMostLosses = 2;

/// Of tests: after how many submissions a device counts as lost.
int submitsUntilLost() {
    const char* text = std::getenv("TERRAY_VULKAN_LOSE_AFTER");
    return text != nullptr ? std::atoi(text) : -1;
}

}  // namespace

std::unique_lock<std::mutex> DeviceCaster::hold(const RenderOptions& options) {
    const auto wish = parseDevice(options.device);
    return wish && wish->vulkan ? std::unique_lock(mutex_) : std::unique_lock<std::mutex>();
}

Result<DeviceTechnique*> DeviceCaster::prepare(const RenderOptions& options, const TerrainCut& cut,
                                               DeviceFigures& figures) {
    const auto wish = parseDevice(options.device);
    if (!wish) return wish.error();
    if (!wish->vulkan || losses_ >= kMostLosses) return nullptr;
    const std::string wanted = options.technique + " " + wish->which;
    if (!technique_ || openedFor_ != wanted) {
        technique_.reset();
        DeviceRequest request;
        request.which = wish->which;
        request.submitsUntilLost = submitsUntilLost();
        auto opened = openTechnique(options.technique, request);
        if (!opened) return opened.error();
        technique_ = std::move(*opened);
        openedFor_ = wanted;
    }
    if (const auto prepared = technique_->prepare(cut, figures); !prepared) {
        TERRAY_TRY(giveUpIfLost(prepared.error()));
        return nullptr;
    }
    return technique_.get();
}

Result<void> DeviceCaster::giveUpIfLost(const Error& error) {
    if (!technique_->isLost()) return error;
    ++losses_;
    log::warning("{}; the CPU goes on{}", error.message,
                 losses_ < kMostLosses ? " with this picture" : "");
    technique_.reset();
    return {};
}

size_t TilesAhead::tilesAtOnce() const {
    constexpr size_t kHits = size_t{1} << 20;
    return std::max(kHits / (offsets_.size() * kTileWidth * kTileHeight), size_t{1});
}

Result<void> TilesAhead::cast(DeviceTechnique& technique, std::vector<ImageTile> tiles,
                              TraceCounters& counters, DeviceFigures& figures) {
    perOffset_ = 0;
    for (const ImageTile& tile : tiles) perOffset_ += tile.pixelCount();
    hits_.resize(perOffset_ * offsets_.size());
    for (size_t k = 0; k < offsets_.size(); ++k)
        TERRAY_TRY(technique.cast(cut_, rays_, tiles, offsets_[k],
                                  std::span(hits_).subspan(k * perOffset_, perOffset_), counters,
                                  figures));
    tiles_ = std::move(tiles);
    return {};
}

std::span<const Hit> TilesAhead::hitsOf(const ImageTile& tile, Vec2 offset) const {
    size_t first = 0;
    for (const ImageTile& t : tiles_) {
        if (t.x == tile.x && t.y == tile.y) {
            const auto found = std::find(offsets_.begin(), offsets_.end(), offset);
            TERRAY_ASSERT(found != offsets_.end());
            const auto k = static_cast<size_t>(found - offsets_.begin());
            return std::span(hits_).subspan(k * perOffset_ + first, tile.pixelCount());
        }
        first += t.pixelCount();
    }
    return {};
}

}  // namespace terray
