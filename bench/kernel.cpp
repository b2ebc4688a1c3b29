// SPDX-License-Identifier: Apache-2.0
// `terray-bench kernel`: primary rays a second of the exact tracer, six cameras, one thread and
// all.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "commands.h"
#include "kernel/trace.h"
#include "measure.h"

namespace terray::bench {
namespace {

struct KernelOptions : SpeedOptions {
    bool constant = false;
};

struct KernelFigures {
    Timing times;
    TraceCounters counters;
};

KernelFigures measure(const Technique& technique, const TerrainCut& cut, const RayFrame& frame,
                      int threads, int reps) {
    KernelFigures figures;
    figures.times =
        timeRuns(threads, reps, [&] { figures.counters = traceFrame(technique, cut, frame); });
    return figures;
}

nlohmann::json jsonOf(const Scene& scene, const KernelOptions& options, const std::string& camera,
                      int threads, const KernelFigures& figures) {
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
            {"ms", figures.times.ms},
            {"cpu_ms", figures.times.cpuMs},
            {"mrays_per_cpu_s", static_cast<double>(c.rays) / figures.times.cpuMs / 1e3},
            {"mrays_per_s", static_cast<double>(c.rays) / figures.times.ms / 1e3},
            {"rays", c.rays},
            {"hits", c.hits},
            {"steps_per_ray", static_cast<double>(c.steps) / static_cast<double>(c.rays)},
            {"redone_share", static_cast<double>(c.redone) / static_cast<double>(c.rays)},
            {"column_share", static_cast<double>(c.columns) / static_cast<double>(c.rays)},
            {"beam_share", static_cast<double>(c.beams) / static_cast<double>(c.rays)}};
}

void printKernelTable(const std::vector<nlohmann::json>& lines) {
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
    auto bench = openBench(options);
    if (!bench) return report(bench.error());
    std::vector<nlohmann::json> lines;
    for (const NamedCamera& named : bench->cameras) {
        const FrameCut cut = cutFor(*bench, named.camera, options.tolerance, options.constant);
        const RayFrame frame(named.camera, bench->scene.terrain->info().worldFromLattice, 1,
                             bench->scene.bend);
        for (const int threads : bench->threads)
            lines.push_back(
                jsonOf(bench->scene, options, named.name, threads,
                       measure(*bench->technique, cut.cut(), frame, threads, options.reps)));
    }
    printKernelTable(lines);
    for (const nlohmann::json& line : lines) fmt::print("{}\n", line.dump());
    return 0;
}

}  // namespace

void addKernel(CLI::App& program, Job& job) {
    CLI::App* command =
        program.add_subcommand("kernel", "M rays/s of the exact tracer, six cameras");
    const auto options = std::make_shared<KernelOptions>();
    addSpeedOptions(*command, *options);
    command->add_flag("--constant", options->constant, "the constant surface instead of bilinear");
    command->footer("Example: terray-bench kernel --camera low50 --threads 1,2 --reps 9");
    command->callback([options, &job] { job = [options] { return runKernel(*options); }; });
}

}  // namespace terray::bench
