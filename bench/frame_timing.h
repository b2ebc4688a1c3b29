// SPDX-License-Identifier: Apache-2.0
// Timing of whole frames: a picture's tiles on all threads of an arena, medians of repetitions.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <vector>

#include "base/stopwatch.h"
#include "kernel/trace.h"
#include "technique/technique.h"
#include "timing.h"
#include "view/ray_frame.h"

namespace terray::bench {

/// Calls cast(tile, worker) for the tiles of a picture, `worker` being the thread's own.
template <class Worker, class Cast>
void castTiles(int width, int height, tbb::enumerable_thread_specific<Worker>& workers,
               const Cast& cast) {
    const int columns = (width + kTileWidth - 1) / kTileWidth,
              rows = (height + kTileHeight - 1) / kTileHeight;
    tbb::parallel_for(tbb::blocked_range<int>(0, columns * rows, 1), [&](const auto& range) {
        Worker& worker = workers.local();
        for (int k = range.begin(); k < range.end(); ++k) {
            ImageTile tile{k % columns * kTileWidth, k / columns * kTileHeight, 0, 0};
            tile.width = std::min(kTileWidth, width - tile.x);
            tile.height = std::min(kTileHeight, height - tile.y);
            cast(tile, worker);
        }
    });
}

struct Timing {
    double ms = 0;
    double cpuMs = 0;  ///< of all threads: what counts on a busy machine
};

/// Times one run of `work` on the threads of an arena.
template <class Work>
Timing timeOnce(tbb::task_arena& arena, const Work& work) {
    const double cpuStart = cpuMs();
    const Stopwatch watch;
    arena.execute(work);
    return {watch.elapsedMs(), cpuMs() - cpuStart};
}

/// Medians of wall and of processor time, each for itself.
Timing medianOf(const std::vector<Timing>& timings);

}  // namespace terray::bench
