// SPDX-License-Identifier: Apache-2.0
// What the speed measurements share: their options, their terrain, repeated timing, image tiles.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cameras.h"
#include "frame_timing.h"
#include "scene.h"
#include "stream/cut.h"
#include "technique/technique.h"
#include "view/ray_frame.h"

namespace terray::bench {

struct SpeedOptions {
    std::string source;  ///< empty: the fractal
    int64_t size = 4096;
    double cell = 10;
    std::string format = "int16", target, camera, technique = "ray_cast";
    int width = 1920, height = 1080, reps = 5;
    std::vector<int> threads;
    double tolerance = 0;
};
void addSpeedOptions(CLI::App& command, SpeedOptions& options);

/// A scene and its technique, with the wanted SIMD target in use; says on a line what was loaded.
struct Bench {
    Scene scene;
    std::unique_ptr<Technique> technique;
    std::vector<NamedCamera> cameras;
    std::vector<int> threads;
};
Result<Bench> openBench(const SpeedOptions& options);

FrameCut cutFor(const Bench& bench, const Camera& camera, double tolerancePx, bool constant);

/// Runs a job once to warm up, then `reps` times, on so many threads.
Timing timeRuns(int threads, int reps, const std::function<void()>& job);

/// The image tiles of a frame, row by row.
std::vector<ImageTile> imageTiles(int width, int height);

/// One frame: ray set-up and tracing of every image tile, hits into a buffer of the thread.
TraceCounters traceFrame(const Technique& technique, const TerrainCut& cut, const RayFrame& frame);

}  // namespace terray::bench
