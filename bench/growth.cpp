// SPDX-License-Identifier: Apache-2.0
// `terray-bench growth`: what a frame costs as the posts of the same ground become finer.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "commands.h"
#include "streamed.h"

namespace terray::bench {
namespace {

constexpr int64_t kSide = 65536;  ///< metres

struct GrowthOptions {
    int width = 1920, height = 1080, reps = 5, threads = 1;
    uint64_t memoryMiB = 3072;
    double tolerance = 2.0 / 3;
    std::vector<int> finest{6, 4, 2, 0};
    bool clutter = false;
};

struct NamedPlace {
    const char* name;
    Standpoint from;
};
constexpr NamedPlace kPlaces[] = {
    {"low50", {16384, 16384, 50, 45, 0}},        {"mid500", {16384, 16384, 500, 45, -15}},
    {"high3000", {16384, 16384, 3000, 45, -45}}, {"down5000", {32768, 32768, 5000, 0, -90}},
    {"far2000", {8192, 8192, 2000, 45, -5}},
};

/// The same eye for all: above the finest ground.
std::vector<Camera> camerasOf(const GrowthOptions& options) {
    const TerabyteSource finest(kSide, kSide, 0, 1, !options.clutter);
    std::vector<Camera> cameras;
    for (const NamedPlace& place : kPlaces)
        cameras.push_back(cameraAt(finest, place.from, options.width, options.height));
    return cameras;
}

Result<void> measureSize(const GrowthOptions& options, int finest,
                         const std::vector<Camera>& cameras, const Technique& technique,
                         std::vector<nlohmann::json>& lines) {
    auto scene = openStreamed(kSide, kSide, finest, !options.clutter, options.memoryMiB << 20);
    if (!scene) return scene.error();
    for (size_t k = 0; k < cameras.size(); ++k) {
        auto frame = bringFrame(*scene, cameras[k], options.tolerance, false);
        if (!frame) return frame.error();
        const RayFrame rays(cameras[k], scene->terrain->info().worldFromLattice, 1, scene->bend);
        TraceCounters counters;
        const Timing time = timeRuns(options.threads, options.reps, [&] {
            counters = traceFrame(technique, frame->cut.cut(), rays);
        });
        const auto count = static_cast<double>(counters.rays);
        lines.push_back({{"bench", "growth"},
                         {"posts", (kSide >> finest) + 1},
                         {"camera", kPlaces[k].name},
                         {"ms", time.ms},
                         {"cpu_ms", time.cpuMs},
                         {"hits", static_cast<double>(counters.hits) / count},
                         {"steps_per_ray", static_cast<double>(counters.steps) / count},
                         {"column_share", static_cast<double>(counters.columns) / count},
                         {"tolerance_px", frame->tolerancePx},
                         {"tiles_wanted", frame->wanted},
                         {"tiles_per_mip", frame->cut.tilesPerMip()},
                         {"bring_ms", frame->bringMs},
                         {"start_ms", scene->startMs}});
        fmt::print("{}\n", lines.back().dump());
        std::fflush(stdout);
    }
    return {};
}

void printGrowthTable(const std::vector<nlohmann::json>& lines) {
    const size_t places = std::size(kPlaces), sizes = lines.size() / places;
    fmt::print("\n{:<10}", "camera");
    for (size_t s = 0; s < sizes; ++s)
        fmt::print("{:>9} ms", lines[s * places]["posts"].get<int>());
    fmt::print("   growth\n");
    for (size_t k = 0; k < places; ++k) {
        fmt::print("{:<10}", kPlaces[k].name);
        double before = 0;
        std::string growth;
        for (size_t s = 0; s < sizes; ++s) {
            const double ms = lines[s * places + k]["cpu_ms"].get<double>();
            fmt::print("{:>12.1f}", ms);
            if (s > 0) growth += fmt::format(" {:5.2f}", ms / before);
            before = ms;
        }
        fmt::print("   {}\n", growth);
    }
}

int runGrowth(const GrowthOptions& options) {
    auto technique = makeTechnique("ray_cast");
    if (!technique) return report(technique.error());
    const std::vector<Camera> cameras = camerasOf(options);
    std::vector<nlohmann::json> lines;
    for (const int finest : options.finest) {
        const auto done = measureSize(options, finest, cameras, **technique, lines);
        if (!done) return report(done.error());
    }
    printGrowthTable(lines);
    return 0;
}

}  // namespace

void addGrowth(CLI::App& program, Job& job) {
    CLI::App* command = program.add_subcommand(
        "growth", "primary time of a frame as the posts of the same ground become finer");
    const auto options = std::make_shared<GrowthOptions>();
    command->add_option("--width", options->width)->check(CLI::Range(1, 100000));
    command->add_option("--height", options->height)->check(CLI::Range(1, 100000));
    command->add_option("--reps", options->reps)->check(CLI::Range(1, 1000));
    command->add_option("--threads", options->threads)->check(CLI::Range(1, 4096));
    command->add_option("--memory", options->memoryMiB, "MiB of tiles")->capture_default_str();
    command->add_option("--tolerance", options->tolerance, "pixels")->capture_default_str();
    command->add_option("--posts", options->finest, "log2 of metres between posts: 6 4 2 0")
        ->check(CLI::Range(0, 7));
    command->add_flag("--clutter", options->clutter, "trees and houses where posts are 1 m apart");
    command->footer("Example: terray-bench growth --reps 9");
    command->callback([options, &job] { job = [options] { return runGrowth(*options); }; });
}

}  // namespace terray::bench
