// SPDX-License-Identifier: Apache-2.0
// Shared parts of the speed measurements.
#include "measure.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "frame_timing.h"
#include "kernel/trace.h"

namespace terray::bench {
void addSpeedOptions(CLI::App& command, SpeedOptions& options) {
    command.add_option(
        "source", options.source,
        "DEM file or synthetic:... (default: the fractal of --size, --cell, --format)");
    command.add_option("--size", options.size, "posts a side of the fractal")
        ->check(CLI::Range(2, 65536))
        ->capture_default_str();
    command.add_option("--cell", options.cell, "metres between posts of the fractal")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command.add_option("--format", options.format, "posts of the fractal")
        ->check(CLI::IsMember({"int16", "float"}))
        ->capture_default_str();
    command.add_option("--reps", options.reps, "timed repetitions; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command.add_option("--width", options.width)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command.add_option("--height", options.height)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command.add_option("--target", options.target, "SIMD target, e.g. AVX3 (default: the best)");
    command.add_option("--camera", options.camera, "one camera only")
        ->check(CLI::IsMember({"low50", "mid500", "high3000", "down5000", "valley", "mountain"}));
    command.add_option("--threads", options.threads, "thread counts (default: 1 and all cores)")
        ->delimiter(',')
        ->check(CLI::Range(1, 4096));
    command.add_option("--technique", options.technique)->capture_default_str();
    command.add_option("--tolerance", options.tolerance, "pixels of error allowed; 0: finest mip")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
}

Result<Bench> openBench(const SpeedOptions& options) {
    if (!setSimdTarget(options.target)) {
        std::string known;
        for (const std::string& name : simdTargets()) known += (known.empty() ? "" : ", ") + name;
        return makeError(ErrorCode::Usage, "--target {}: this machine has {}", options.target,
                         known);
    }
    Bench bench;
    auto technique = makeTechnique(options.technique);
    if (!technique) return technique.error();
    bench.technique = std::move(*technique);
    const std::string source = options.source.empty() ? syntheticName("fractal", options.size,
                                                                      options.cell, options.format)
                                                      : options.source;
    auto scene = loadScene(source);
    if (!scene) return scene.error();
    bench.scene = std::move(*scene);
    fmt::print("{}: {} x {} posts, loaded in {:.0f} ms, built in {:.0f} ms, {:.1f} MiB\n",
               bench.scene.name, bench.scene.terrain->info().scheme.columns,
               bench.scene.terrain->info().scheme.rows, bench.scene.build.loadMs,
               bench.scene.build.buildMs,
               static_cast<double>(bench.scene.build.residentBytes) / 1048576);
    fmt::print("target {}, {} x {}, median of {}\n", activeSimdTarget(), options.width,
               options.height, options.reps);
    for (const NamedCamera& named :
         speedCameras(*bench.scene.terrain, options.width, options.height))
        if (options.camera.empty() || named.name == options.camera) bench.cameras.push_back(named);
    bench.threads = options.threads;
    if (bench.threads.empty()) bench.threads = {1, tbb::this_task_arena::max_concurrency()};
    return bench;
}

FrameCut cutFor(const Bench& bench, const Camera& camera, double tolerancePx, bool constant) {
    CutOptions options;
    options.tolerancePx = tolerancePx;
    options.bend = bench.scene.bend;
    options.surface = constant ? kSurfaceConstant : kSurfaceBilinear;
    return selectCut(*bench.scene.terrain, camera, options);
}

Timing timeRuns(int threads, int reps, const std::function<void()>& job) {
    tbb::task_arena arena(threads);
    std::vector<Timing> timings;
    for (int rep = -1; rep < reps; ++rep) {
        const Timing timing = timeOnce(arena, job);
        if (rep >= 0) timings.push_back(timing);
    }
    return medianOf(timings);
}

std::vector<ImageTile> imageTiles(int width, int height) {
    std::vector<ImageTile> tiles;
    for (int y = 0; y < height; y += kTileHeight)
        for (int x = 0; x < width; x += kTileWidth)
            tiles.push_back(
                {x, y, std::min(kTileWidth, width - x), std::min(kTileHeight, height - y)});
    return tiles;
}

TraceCounters traceFrame(const Technique& technique, const TerrainCut& cut, const RayFrame& frame) {
    const auto tiles = imageTiles(frame.camera().width, frame.camera().height);
    struct Worker {
        std::vector<Hit> hits;
        TraceCounters counters;
    };
    tbb::enumerable_thread_specific<Worker> workers;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, tiles.size(), 1), [&](const auto& range) {
        Worker& worker = workers.local();
        for (size_t k = range.begin(); k < range.end(); ++k) {
            worker.hits.resize(tiles[k].pixelCount());
            technique.castTile(cut, frame, tiles[k], {0.5, 0.5}, worker.hits, worker.counters);
        }
    });
    TraceCounters sum;
    for (const Worker& worker : workers) sum.add(worker.counters);
    return sum;
}

}  // namespace terray::bench
