// SPDX-License-Identifier: Apache-2.0
// `terray-bench kernel`: primary rays a second of the exact tracer, six cameras, one thread and
// all.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cameras.h"
#include "commands.h"
#include "frame_timing.h"
#include "kernel/trace.h"
#include "scene.h"
#include "stream/cut.h"
#include "technique/technique.h"

namespace terray::bench {
namespace {

struct KernelOptions {
    std::string source;  ///< empty: the fractal
    int64_t size = 4096;
    double cell = 10;
    std::string format = "int16", target, camera, technique = "ray_cast";
    int width = 1920, height = 1080, reps = 5;
    std::vector<int> threads;
    double tolerance = 0;
    bool constant = false;
};

struct Figures {
    Timing median;  ///< of the repetitions
    TraceCounters counters;
};

/// One frame: ray set-up and tracing of every image tile, hits into a buffer of the thread.
TraceCounters traceFrame(const Technique& technique, const TerrainCut& cut, const RayFrame& frame) {
    struct Worker {
        std::vector<Hit> hits = std::vector<Hit>(kTileSide * kTileSide);
        TraceCounters counters;
    };
    tbb::enumerable_thread_specific<Worker> workers;
    castTiles(frame.camera().width, frame.camera().height, workers,
              [&](const ImageTile& tile, Worker& worker) {
                  const std::span hits(worker.hits.data(), tile.pixelCount());
                  technique.castTile(cut, frame, tile, {0.5, 0.5}, hits, worker.counters);
              });
    TraceCounters sum;
    for (const Worker& worker : workers) addCounters(sum, worker.counters);
    return sum;
}

Figures measure(const Technique& technique, const TerrainCut& cut, const RayFrame& frame,
                int threads, int reps) {
    Figures figures;
    tbb::task_arena arena(threads);
    std::vector<Timing> timings;
    for (int rep = -1; rep < reps; ++rep) {  // the first one warms up
        const Timing timing =
            timeOnce(arena, [&] { figures.counters = traceFrame(technique, cut, frame); });
        if (rep >= 0) timings.push_back(timing);
    }
    figures.median = medianOf(timings);
    return figures;
}

nlohmann::json jsonOf(const Scene& scene, const KernelOptions& options, const std::string& camera,
                      int threads, const Figures& figures) {
    const TraceCounters& c = figures.counters;
    return {{"bench", "kernel"},
            {"terrain", scene.name},
            {"technique", options.technique},
            {"target", activeSimdTarget()},
            {"surface", options.constant ? "constant" : "bilinear"},
            {"tolerance_px", options.tolerance},
            {"camera", camera},
            {"width", options.width},
            {"height", options.height},
            {"threads", threads},
            {"reps", options.reps},
            {"ms", figures.median.ms},
            {"cpu_ms", figures.median.cpuMs},
            {"mrays_per_cpu_s", static_cast<double>(c.rays) / figures.median.cpuMs / 1e3},
            {"mrays_per_s", static_cast<double>(c.rays) / figures.median.ms / 1e3},
            {"rays", c.rays},
            {"hits", c.hits},
            {"steps_per_ray", static_cast<double>(c.steps) / static_cast<double>(c.rays)},
            {"redone_share", static_cast<double>(c.redone) / static_cast<double>(c.rays)},
            {"column_share", static_cast<double>(c.columns) / static_cast<double>(c.rays)},
            {"beam_share", static_cast<double>(c.beams) / static_cast<double>(c.rays)}};
}

void printTable(const std::vector<nlohmann::json>& lines) {
    fmt::print("{:<10} {:>7} {:>10} {:>9} {:>14} {:>7} {:>10} {:>9} {:>9}\n", "camera", "threads",
               "M rays/s", "ms", "M rays/(cpu s)", "hits %", "steps/ray", "redone %", "column %");
    for (const nlohmann::json& line : lines) {
        const double rays = line["rays"].get<double>();
        fmt::print(
            "{:<10} {:>7} {:>10.1f} {:>9.2f} {:>14.1f} {:>7.1f} {:>10.2f} {:>9.4f} {:>9.1f}\n",
            line["camera"].get<std::string>(), line["threads"].get<int>(),
            line["mrays_per_s"].get<double>(), line["ms"].get<double>(),
            line["mrays_per_cpu_s"].get<double>(), 100 * line["hits"].get<double>() / rays,
            line["steps_per_ray"].get<double>(), 100 * line["redone_share"].get<double>(),
            100 * line["column_share"].get<double>());
    }
}

int runKernel(const KernelOptions& options) {
    if (!setSimdTarget(options.target)) {
        std::string known;
        for (const std::string& name : simdTargets()) known += (known.empty() ? "" : ", ") + name;
        return report(
            makeError(ErrorCode::Usage, "--target {}: this machine has {}", options.target, known));
    }
    auto technique = makeTechnique(options.technique);
    if (!technique) return report(technique.error());
    const std::string source = options.source.empty() ? syntheticName("fractal", options.size,
                                                                      options.cell, options.format)
                                                      : options.source;
    auto scene = loadScene(source);
    if (!scene) return report(scene.error());
    fmt::print("{}: {} x {} posts, loaded in {:.0f} ms, built in {:.0f} ms, {:.1f} MiB\n",
               scene->name, scene->terrain->info().scheme.columns,
               scene->terrain->info().scheme.rows, scene->build.loadMs, scene->build.buildMs,
               static_cast<double>(scene->build.residentBytes) / 1048576);
    std::vector<int> threadCounts = options.threads;
    if (threadCounts.empty()) threadCounts = {1, tbb::this_task_arena::max_concurrency()};
    fmt::print("target {}, {} x {}, median of {}\n", activeSimdTarget(), options.width,
               options.height, options.reps);
    std::vector<nlohmann::json> lines;
    for (const NamedCamera& named : speedCameras(*scene->terrain, options.width, options.height)) {
        if (!options.camera.empty() && named.name != options.camera) continue;
        CutOptions cutOptions;
        cutOptions.tolerancePx = options.tolerance;
        cutOptions.bend = scene->bend;
        cutOptions.surface = options.constant ? kSurfaceConstant : kSurfaceBilinear;
        const FrameCut cut = selectCut(*scene->terrain, named.camera, cutOptions);
        const RayFrame frame(named.camera, scene->terrain->info().worldFromLattice, 1, scene->bend);
        for (const int threads : threadCounts)
            lines.push_back(jsonOf(*scene, options, named.name, threads,
                                   measure(**technique, cut.cut(), frame, threads, options.reps)));
    }
    printTable(lines);
    for (const nlohmann::json& line : lines) fmt::print("{}\n", line.dump());
    return 0;
}

}  // namespace

void addKernel(CLI::App& program, Job& job) {
    CLI::App* command =
        program.add_subcommand("kernel", "M rays/s of the exact tracer, six cameras");
    const auto options = std::make_shared<KernelOptions>();
    command->add_option(
        "source", options->source,
        "DEM file or synthetic:... (default: the fractal of --size, --cell, --format)");
    command->add_option("--size", options->size, "posts a side of the fractal")
        ->check(CLI::Range(2, 65536))
        ->capture_default_str();
    command->add_option("--cell", options->cell, "metres between posts of the fractal")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--format", options->format, "posts of the fractal")
        ->check(CLI::IsMember({"int16", "float"}))
        ->capture_default_str();
    command->add_option("--reps", options->reps, "timed repetitions; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--width", options->width)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--height", options->height)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--target", options->target, "SIMD target, e.g. AVX3 (default: the best)");
    command->add_option("--camera", options->camera, "one camera only")
        ->check(CLI::IsMember(speedCameraNames()));
    command->add_option("--threads", options->threads, "thread counts (default: 1 and all cores)")
        ->delimiter(',')
        ->check(CLI::Range(1, 4096));
    command->add_option("--technique", options->technique)->capture_default_str();
    command->add_option("--tolerance", options->tolerance, "pixels of error allowed; 0: finest mip")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command->add_flag("--constant", options->constant, "the constant surface instead of bilinear");
    command->footer("Example: terray-bench kernel --camera low50 --threads 1,2 --reps 9");
    command->callback([options, &job] { job = [options] { return runKernel(*options); }; });
}

}  // namespace terray::bench
