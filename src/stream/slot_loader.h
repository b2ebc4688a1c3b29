// SPDX-License-Identifier: Apache-2.0
// Fills slots of a pool on threads of its own, the first of a list first.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/result.h"

namespace terray {

using SteadyTime = std::chrono::steady_clock::time_point;

/// Something that comes and goes, by its number, and the slot that it goes into. The slot is the
/// loader's until the job is taken.
struct SlotJob {
    uint32_t number = 0, slot = 0;
    SteadyTime since;  ///< when it was first asked for
};
struct FilledSlot {
    SlotJob job;
    Result<void> outcome;    ///< or why the slot is not filled
    double latencyMs = 0;    ///< since it was asked for
    uint64_t bytesRead = 0;  ///< of files
};

/// Fills slots for one thread. confined.
class SlotFiller {
public:
    virtual ~SlotFiller() = default;
    virtual Result<void> fill(const SlotJob& job) = 0;
    /// Bytes read of files since it was made.
    virtual uint64_t bytesRead() const = 0;
};
/// Called by each thread, and again after an error: nothing of what went wrong is kept.
using MakeFiller = std::function<Result<std::unique_ptr<SlotFiller>>()>;

/// Threads that keep a loader from being what pictures wait for: a quarter of the cores, but 2
/// to 8.
int loaderThreads();

/// synchronised.
class SlotLoader {
public:
    SlotLoader(MakeFiller makeFiller, int threads);
    /// Waits for what is being filled.
    ~SlotLoader();
    SlotLoader(const SlotLoader&) = delete;
    SlotLoader& operator=(const SlotLoader&) = delete;

    void ask(const SlotJob& job);
    /// Takes back what no thread has begun with.
    std::vector<SlotJob> takeBack();
    /// What is done. With nothing done, waits for something for up to `most`.
    std::vector<FilledSlot> take(std::chrono::milliseconds most);

private:
    void work();

    MakeFiller makeFiller_;
    std::mutex mutex_;
    std::condition_variable asked_, done_;
    std::deque<SlotJob> jobs_;
    std::vector<FilledSlot> filled_;
    int busy_ = 0;  ///< threads that fill
    bool stop_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace terray
