// SPDX-License-Identifier: Apache-2.0
// The loader's threads: each has a filler of its own, made anew after an error.
#include "stream/slot_loader.h"

#include <algorithm>
#include <utility>

namespace terray {

int loaderThreads() {
    return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) / 4, 2, 8);
}

SlotLoader::SlotLoader(MakeFiller makeFiller, int threads) : makeFiller_(std::move(makeFiller)) {
    for (int k = 0; k < threads; ++k) threads_.emplace_back([this] { work(); });
}

SlotLoader::~SlotLoader() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    asked_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

void SlotLoader::ask(const SlotJob& job) {
    {
        const std::lock_guard lock(mutex_);
        jobs_.push_back(job);
    }
    asked_.notify_one();
}

std::vector<SlotJob> SlotLoader::takeBack() {
    const std::lock_guard lock(mutex_);
    std::vector<SlotJob> jobs(jobs_.begin(), jobs_.end());
    jobs_.clear();
    return jobs;
}

std::vector<FilledSlot> SlotLoader::take(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    const auto isIdle = [&] { return jobs_.empty() && busy_ == 0; };
    done_.wait_for(lock, most, [&] { return !filled_.empty() || isIdle(); });
    return std::exchange(filled_, {});
}

void SlotLoader::work() {
    std::unique_ptr<SlotFiller> filler;
    std::unique_lock lock(mutex_);
    while (true) {
        asked_.wait(lock, [&] { return stop_ || !jobs_.empty(); });
        if (stop_) return;
        const SlotJob job = jobs_.front();
        jobs_.pop_front();
        ++busy_;
        lock.unlock();
        FilledSlot filled{job, {}, 0, 0};
        if (!filler) {
            auto made = makeFiller_();
            if (made)
                filler = std::move(*made);
            else
                filled.outcome = made.error();
        }
        if (filler) {
            const uint64_t before = filler->bytesRead();
            filled.outcome = filler->fill(job);
            filled.bytesRead = filler->bytesRead() - before;
        }
        if (!filled.outcome) filler.reset();
        filled.latencyMs =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - job.since)
                .count();
        lock.lock();
        --busy_;
        filled_.push_back(std::move(filled));
        done_.notify_all();
    }
}

}  // namespace terray
