// SPDX-License-Identifier: Apache-2.0
// Numbered tasks on all cores, taken in order; stops at the first error or on Ctrl-C.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>

#include "base/interrupt.h"
#include "base/result.h"

namespace terray {

/// Runs work(worker, task) for task = 0 .. tasks - 1. `makeWorker()` gives each thread its own
/// Result<Worker> (readers, scratch) first.
template <class MakeWorker, class Work>
Result<void> forEachTask(int64_t tasks, const MakeWorker& makeWorker, const Work& work) {
    std::atomic<int64_t> next{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    std::optional<Error> error;
    const auto fail = [&](Error cause) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::move(cause);
        stop = true;
    };
    const int threads = tbb::this_task_arena::max_concurrency();
    const int workers = static_cast<int>(std::clamp<int64_t>(tasks, 1, threads));
    tbb::parallel_for(0, workers, [&](int) {
        if (stop || next >= tasks) return;
        auto worker = makeWorker();
        if (!worker.ok()) return fail(worker.error());
        for (int64_t task = next++; task < tasks && !stop; task = next++) {
            if (isInterrupted()) return fail(Error{ErrorCode::Interrupted, "interrupted"});
            const Result<void> done = work(*worker, task);
            if (!done.ok()) return fail(done.error());
        }
    });
    if (error) return *error;
    return {};
}

}  // namespace terray
