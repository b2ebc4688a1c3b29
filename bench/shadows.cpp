// SPDX-License-Identifier: Apache-2.0
// `terray-bench shadows`: shadow rays a second by casting and by the sun sweep, and what the sweep
// costs.
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <nlohmann/json.hpp>

#include "commands.h"
#include "kernel/height.h"
#include "kernel/sweep/sun.h"
#include "measure.h"
#include "shade/sun_rays.h"

namespace terray::bench {
namespace {

struct ShadowOptions : SpeedOptions {
    double azimuthDeg = 315, elevationDeg = 30;
};

/// The shadow rays of one image tile.
struct TileRays {
    std::vector<Hit> hits;
    std::vector<Ray> rays;
    std::vector<SunAsks> asks;
    std::vector<uint8_t> cast, swept;
};

struct ShadowFigures {
    double rays = 0, dark = 0, wrong = 0;
    Timing casting, walking, sweeping;
    ShadowCounters counters;  ///< of one frame
    TraceCounters cast;
    uint64_t bytes = 0;
};

SunDirection sunOf(const Scene& scene, const RayFrame& frame, const ShadowOptions& options) {
    const double azimuth = radFromDeg(options.azimuthDeg), up = radFromDeg(options.elevationDeg);
    const TerrainInfo& info = scene.terrain->info();
    Sun sun;
    sun.towards = {std::sin(azimuth) * std::cos(up), std::cos(azimuth) * std::cos(up),
                   std::sin(up)};
    sun.centre =
        info.worldFromLattice.worldFromLattice({0.5 * static_cast<double>(info.scheme.columns),
                                                0.5 * static_cast<double>(info.scheme.rows)});
    return SunRays(sun, frame).direction();
}

std::vector<TileRays> shadowRays(const Technique& technique, const TerrainCut& cut,
                                 const RayFrame& frame, const SunDirection& sun) {
    const auto tiles = imageTiles(frame.camera().width, frame.camera().height);
    std::vector<TileRays> all(tiles.size());
    tbb::parallel_for(size_t{0}, tiles.size(), [&](size_t n) {
        TileRays& tile = all[n];
        tile.hits.resize(tiles[n].pixelCount());
        TraceCounters counters;
        technique.castTile(cut, frame, tiles[n], {0.5, 0.5}, tile.hits, counters);
        tile.rays.resize(tile.hits.size());
        tile.asks.resize((tile.hits.size() + kSunAsks - 1) / kSunAsks);
        for (SunAsks& batch : tile.asks) batch.clear();
        for (size_t k = 0; k < tile.hits.size(); ++k) {
            const Hit& hit = tile.hits[k];
            if (!isHit(hit)) continue;
            const auto height = static_cast<float>(hitHeight(cut, hit));
            tile.rays[k] = sunRay(cut, sun, hit, height);
            tile.asks[k / kSunAsks].ask(static_cast<int>(k % kSunAsks), hit, height);
        }
        tile.cast.resize(tile.hits.size());
        tile.swept.resize(tile.asks.size() * kSunAsks);
    });
    return all;
}

/// Runs a job over all tiles, with counters per thread; returns those.
template <class Counters, class Job>
std::vector<Counters> overTiles(std::vector<TileRays>& tiles, const Job& job) {
    tbb::enumerable_thread_specific<Counters> counters;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, tiles.size(), 1), [&](const auto& range) {
        for (size_t k = range.begin(); k < range.end(); ++k) job(tiles[k], counters.local());
    });
    return {counters.begin(), counters.end()};
}

ShadowFigures measure(std::vector<TileRays>& tiles, const TerrainCut& cut, const SunDirection& sun,
                      int threads, int reps) {
    ShadowFigures f;
    f.casting = timeRuns(threads, reps, [&] {
        f.cast = {};
        for (const TraceCounters& c : overTiles<TraceCounters>(
                 tiles, [&](TileRays&t, auto&c) { occluded(cut, t.hits, t.rays, t.cast, c); })) {
            f.cast.rays += c.rays;
            f.cast.steps += c.steps;
        }
    });
    std::shared_ptr<const SunSweep> sweep;
    f.sweeping = timeRuns(threads, reps, [&] {
        sweep.reset();
        sweep = SunSweep::make(cut, sun);
    });
    if (!sweep) return f;
    f.bytes = sweep->bytes();
    f.walking = timeRuns(threads, reps, [&] {
        f.counters = {};
        for (const ShadowCounters& c : overTiles<ShadowCounters>(tiles, [&](TileRays&t, auto&c) {
                 shadows(cut, *sweep, t.hits, t.asks, t.swept, c);
             })) {
            f.counters.rays += c.rays;
            f.counters.dark += c.dark;
            f.counters.cells += c.cells;
            f.counters.cast += c.cast;
        }
    });
    for (const TileRays& tile : tiles)
        for (size_t k = 0; k < tile.cast.size(); ++k) f.wrong += tile.cast[k] != tile.swept[k];
    return f;
}

nlohmann::json jsonOf(const Scene& scene, const ShadowOptions& options, const std::string& camera,
                      int threads, const ShadowFigures& f) {
    const auto rays = static_cast<double>(f.counters.rays);
    return {{"bench", "shadows"},
            {"terrain", scene.name},
            {"target", activeSimdTarget()},
            {"tolerance_px", options.tolerance},
            {"sun_azimuth", options.azimuthDeg},
            {"sun_elevation", options.elevationDeg},
            {"camera", camera},
            {"width", options.width},
            {"height", options.height},
            {"threads", threads},
            {"reps", options.reps},
            {"rays", f.counters.rays},
            {"dark_share", static_cast<double>(f.counters.dark) / rays},
            {"cast_mrays_per_cpu_s", rays / f.casting.cpuMs / 1e3},
            {"swept_mrays_per_cpu_s", rays / f.walking.cpuMs / 1e3},
            {"cast_ms", f.casting.ms},
            {"swept_ms", f.walking.ms},
            {"cast_cpu_ms", f.casting.cpuMs},
            {"swept_cpu_ms", f.walking.cpuMs},
            {"sweep_ms", f.sweeping.ms},
            {"sweep_cpu_ms", f.sweeping.cpuMs},
            {"sweep_bytes", f.bytes},
            {"first_frame_ms", f.sweeping.ms + f.walking.ms},
            {"cast_steps_per_ray", static_cast<double>(f.cast.steps) / rays},
            {"cells_per_ray", static_cast<double>(f.counters.cells) / rays},
            {"handed_on_share", static_cast<double>(f.counters.cast) / rays},
            {"differences", f.wrong}};
}

void printShadowTable(const std::vector<nlohmann::json>& lines) {
    fmt::print("{:<10} {:>7} {:>7} {:>14} {:>14} {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6}\n",
               "camera", "threads", "dark %", "cast M/(cpu s)", "swept M/(cpu s)", "ratio",
               "sweep ms", "first ms", "cast ms", "cells/ray", "cast on %", "differ");
    for (const nlohmann::json& line : lines) {
        const auto value = [&line](const char* name) { return line[name].get<double>(); };
        fmt::print(
            "{:<10} {:>7} {:>7.1f} {:>14.1f} {:>15.1f} {:>6.2f} {:>9.1f} {:>9.1f} {:>9.1f} "
            "{:>9.2f} "
            "{:>9.2f} {:>6.0f}\n",
            line["camera"].get<std::string>(), line["threads"].get<int>(),
            100 * value("dark_share"), value("cast_mrays_per_cpu_s"),
            value("swept_mrays_per_cpu_s"), value("cast_cpu_ms") / value("swept_cpu_ms"),
            value("sweep_ms"), value("first_frame_ms"), value("cast_ms"), value("cells_per_ray"),
            100 * value("handed_on_share"), value("differences"));
    }
}

int runShadows(const ShadowOptions& options) {
    auto bench = openBench(options);
    if (!bench) return report(bench.error());
    std::vector<nlohmann::json> lines;
    for (const NamedCamera& named : bench->cameras) {
        const FrameCut cut = cutFor(*bench, named.camera, options.tolerance, false);
        const RayFrame frame(named.camera, bench->scene.terrain->info().worldFromLattice, 1,
                             bench->scene.bend);
        const SunDirection sun = sunOf(bench->scene, frame, options);
        auto tiles = shadowRays(*bench->technique, cut.cut(), frame, sun);
        for (const int threads : bench->threads)
            lines.push_back(jsonOf(bench->scene, options, named.name, threads,
                                   measure(tiles, cut.cut(), sun, threads, options.reps)));
    }
    printShadowTable(lines);
    for (const nlohmann::json& line : lines) fmt::print("{}\n", line.dump());
    return 0;
}

}  // namespace

void addShadows(CLI::App& program, Job& job) {
    CLI::App* command =
        program.add_subcommand("shadows", "M shadow rays/s, cast and by the sun sweep");
    const auto options = std::make_shared<ShadowOptions>();
    addSpeedOptions(*command, *options);
    command->add_option("--azimuth", options->azimuthDeg, "of the sun, degrees from grid north")
        ->capture_default_str();
    command->add_option("--elevation", options->elevationDeg, "of the sun, degrees")
        ->check(CLI::Range(0.1, 90.0))
        ->capture_default_str();
    command->footer("Example: terray-bench shadows --camera low50 --azimuth 120 --elevation 10");
    command->callback([options, &job] { job = [options] { return runShadows(*options); }; });
}

}  // namespace terray::bench
