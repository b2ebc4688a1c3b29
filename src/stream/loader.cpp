// SPDX-License-Identifier: Apache-2.0
// The loader's threads: each has a reader of its own, made anew after an error.
#include "stream/loader.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "stream/slot.h"

namespace terray {

TileLoader::TileLoader(const TileSource& source, ResidentTerrain::Pool& pool, int threads)
    : source_(source), pool_(pool) {
    for (int k = 0; k < threads; ++k) threads_.emplace_back([this] { work(); });
}

TileLoader::~TileLoader() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    source_.stopReading();
    asked_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

void TileLoader::ask(const TileJob& job) {
    {
        const std::lock_guard lock(mutex_);
        jobs_.push_back(job);
    }
    asked_.notify_one();
}

std::vector<TileJob> TileLoader::takeBack() {
    const std::lock_guard lock(mutex_);
    std::vector<TileJob> jobs(jobs_.begin(), jobs_.end());
    jobs_.clear();
    return jobs;
}

std::vector<LoadedTile> TileLoader::take(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    const auto isIdle = [&] { return jobs_.empty() && busy_ == 0; };
    done_.wait_for(lock, most, [&] { return !loaded_.empty() || isIdle(); });
    return std::exchange(loaded_, {});
}

void TileLoader::work() {
    std::unique_ptr<TileReader> reader;
    std::unique_lock lock(mutex_);
    while (true) {
        asked_.wait(lock, [&] { return stop_ || !jobs_.empty(); });
        if (stop_) return;
        const TileJob job = jobs_.front();
        jobs_.pop_front();
        ++busy_;
        lock.unlock();
        Result<void> outcome;
        if (!reader) {
            auto made = source_.makeReader();
            if (made)
                reader = std::move(*made);
            else
                outcome = made.error();
        }
        if (reader) outcome = load(*reader, job);
        if (!outcome) reader.reset();  // nothing of what went wrong is kept
        lock.lock();
        --busy_;
        loaded_.push_back({job, std::move(outcome)});
        done_.notify_all();
    }
}

Result<void> TileLoader::load(TileReader& reader, const TileJob& job) {
    const auto read = [&](auto* posts) {
        const bool isFull =
            pool_.cellsX(job.id) == kTileCells && pool_.cellsY(job.id) == kTileCells;
        if (!isFull) std::fill_n(posts, size_t{kSlotPosts}, 0);
        if constexpr (std::is_same_v<decltype(posts), float*>)
            return reader.read(job.id, posts, kPostStride);
        else
            return reader.readCodes(job.id, posts, kPostStride);
    };
    TERRAY_TRY(pool_.format == PostFormat::Int16 ? read(pool_.postsOf<uint16_t>(job.slot))
                                                 : read(pool_.postsOf<float>(job.slot)));
    makePyramid(pool_, job.slot);
    return {};
}

}  // namespace terray
