// SPDX-License-Identifier: Apache-2.0
// `terray-bench peers`: Terray's tracers beside Embree's, the same terrain, cameras and rays, in
// turns.
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cameras.h"
#include "commands.h"
#include "peers/agreement.h"
#include "peers/embree_casters.h"
#include "peers/embree_scene.h"
#include "peers/tables.h"
#include "peers/terray_casters.h"
#include "scene.h"
#include "stream/cut.h"
#include "stream/pool.h"

namespace terray::bench {
namespace {

struct PeersOptions {
    std::string source;  ///< empty: the fractal
    int64_t size = 4096;
    double cell = 10;
    std::string format = "int16", target, camera, technique = "ray_cast", json, markdown;
    std::string surface = "triangles", isa;
    int width = 1920, height = 1080, reps = 5;
    std::vector<int> threads;
    double tolerance = 0, triangleGiB = 6;
    bool robust = false, oracle = true;
};

/// What Embree is expected to need at its peak while it builds triangles; measured 225.
constexpr double kTrianglePeakBytes = 230;

using Lines = std::vector<nlohmann::json>;

/// Embree's scenes: triangles where they fit, and the grid.
struct EmbreeScenes {
    std::unique_ptr<EmbreeScene> triangles, grid;
};

class Comparison {
public:
    Comparison(const PeersOptions& options, const Scene& scene, const Technique& technique)
        : options_(options), scene_(scene), technique_(technique) {
        posts_ = static_cast<double>(scene.terrain->info().scheme.columns) *
                 static_cast<double>(scene.terrain->info().scheme.rows);
        threadCounts_ = options.threads;
        if (threadCounts_.empty()) threadCounts_ = {1, tbb::this_task_arena::max_concurrency()};
        std::sort(threadCounts_.begin(), threadCounts_.end());
    }

    Result<void> build();
    void compare(const NamedCamera& named);
    const Lines& lines() const { return lines_; }

private:
    Result<std::unique_ptr<EmbreeScene>> buildEmbree(EmbreeGeometry geometry,
                                                     const std::string& who);
    double timePyramids(int threads) const;
    std::vector<Contender> primaryContenders(const TerrainCut& cut, const RayFrame& frame) const;
    std::vector<Contender> shadowContenders(const TerrainCut& cut, const RayFrame& frame,
                                            std::vector<Hit> hits,
                                            const std::vector<float>& distances) const;
    void measure(const std::string& kind, const std::string& camera,
                 const std::vector<Contender>& contenders, const Lines& extras);
    nlohmann::json lineOf(const std::string& kind, const std::string& who, int threads) const;
    void note(const nlohmann::json& line) { lines_.push_back(line); }

    const PeersOptions& options_;
    const Scene& scene_;
    const Technique& technique_;
    double posts_ = 0;
    std::vector<int> threadCounts_;
    EmbreeScenes embree_;
    Lines lines_;
};

nlohmann::json Comparison::lineOf(const std::string& kind, const std::string& who,
                                  int threads) const {
    return {{"bench", "peers"},
            {"kind", kind},
            {"who", who},
            {"threads", threads},
            {"terrain", scene_.name},
            {"posts", static_cast<int64_t>(posts_)},
            {"surface", options_.surface},
            {"target", activeSimdTarget()},
            {"isa", options_.isa},
            {"embree", RTC_VERSION_STRING}};
}

/// Milliseconds for the pyramids of mip 0 alone, which is all that exact rays need.
double Comparison::timePyramids(int threads) const {
    const ResidentTerrain::Pool& pool = scene_.terrain->pool();
    const auto tiles = static_cast<uint32_t>(pool.scheme.tileCount(0));
    tbb::enumerable_thread_specific<std::vector<uint32_t>> bounds(
        std::vector<uint32_t>(kSlotBounds, 0));
    tbb::task_arena arena(threads);
    const auto buildAll = [&] {
        tbb::parallel_for(uint32_t{0}, tiles, [&](uint32_t slot) {
            const TileId id = pool.ids[slot];
            TileDesc tile = pool.tiles[slot];
            uint32_t* out = bounds.local().data();
            if (pool.format == PostFormat::Int16)
                buildPyramid(pool.postsOf<uint16_t>(slot), pool.cellsX(id), pool.cellsY(id), tile,
                             out);
            else
                buildPyramid(pool.postsOf<float>(slot), pool.cellsX(id), pool.cellsY(id), tile,
                             out);
        });
    };
    std::vector<Timing> timings;
    for (int rep = 0; rep < options_.reps; ++rep) timings.push_back(timeOnce(arena, buildAll));
    return medianOf(timings).ms;
}

/// Builds with each number of threads, one scene at a time; the last one stays.
Result<std::unique_ptr<EmbreeScene>> Comparison::buildEmbree(EmbreeGeometry geometry,
                                                             const std::string& who) {
    std::unique_ptr<EmbreeScene> scene;
    for (const int threads : threadCounts_) {
        scene.reset();
        auto built =
            EmbreeScene::build(*scene_.terrain, {geometry, threads, options_.robust, options_.isa});
        if (!built) return built.error();
        scene = std::move(*built);
        nlohmann::json line = lineOf("build", who, threads);
        line["ms"] = scene->figures().commitMs;
        line["bytes"] = scene->figures().bytes;
        line["peak_bytes"] = scene->figures().peakBytes;
        line["bytes_per_post"] = static_cast<double>(scene->figures().bytes) / posts_;
        note(line);
    }
    return scene;
}

Result<void> Comparison::build() {
    const BuildStats& stats = scene_.build;
    nlohmann::json whole =
        lineOf("build", "terray, all mips", tbb::this_task_arena::max_concurrency());
    whole["ms"] = stats.buildMs;
    whole["load_ms"] = stats.loadMs;
    whole["bytes"] = stats.residentBytes;
    whole["bytes_per_post"] = static_cast<double>(stats.residentBytes) / posts_;
    note(whole);
    for (const int threads : threadCounts_) {
        nlohmann::json line = lineOf("build", "terray, pyramids of mip 0", threads);
        line["ms"] = timePyramids(threads);
        note(line);
    }
    if (posts_ * kTrianglePeakBytes <= options_.triangleGiB * (1 << 30)) {
        auto triangles = buildEmbree(EmbreeGeometry::Triangles, "embree triangles");
        if (!triangles) return triangles.error();
        embree_.triangles = std::move(*triangles);
    } else {
        fmt::print("Embree's triangles would need about {:.1f} GiB (--triangle-memory): left out\n",
                   posts_ * kTrianglePeakBytes / (1 << 30));
    }
    auto grid = buildEmbree(EmbreeGeometry::Grid, "embree grid");
    if (!grid) return grid.error();
    embree_.grid = std::move(*grid);
    return {};
}

std::vector<Contender> Comparison::primaryContenders(const TerrainCut& cut,
                                                     const RayFrame& frame) const {
    std::vector<Contender> all;
    all.push_back({options_.technique, makeTechniqueCaster(technique_, cut, frame)});
    all.push_back({"packets", makePacketCaster(cut, frame)});
    if (options_.oracle) all.push_back({"oracle", makeOracleCaster(cut, frame), false});
    for (const int lanes : {1, 8, 16})
        if (embree_.triangles)
            all.push_back({fmt::format("embree triangles i{}", lanes),
                           makeEmbreeCaster(*embree_.triangles, frame, lanes)});
    for (const int lanes : {1, 8, 16})
        all.push_back(
            {fmt::format("embree grid i{}", lanes), makeEmbreeCaster(*embree_.grid, frame, lanes)});
    return all;
}

std::vector<Contender> Comparison::shadowContenders(const TerrainCut& cut, const RayFrame& frame,
                                                    std::vector<Hit> hits,
                                                    const std::vector<float>& distances) const {
    std::vector<Contender> all;
    all.push_back({"occluded", makeShadowCaster(cut, frame, std::move(hits))});
    if (embree_.triangles)
        all.push_back(
            {"embree triangles o16", makeEmbreeShadowCaster(*embree_.triangles, frame, distances)});
    all.push_back({"embree grid o16", makeEmbreeShadowCaster(*embree_.grid, frame, distances)});
    return all;
}

/// All contenders take turns, frame by frame, with each number of threads. `extras`: what is
/// already known of each.
void Comparison::measure(const std::string& kind, const std::string& camera,
                         const std::vector<Contender>& contenders, const Lines& extras) {
    const int width = options_.width, height = options_.height;
    for (const int threads : threadCounts_) {
        tbb::task_arena arena(threads);
        std::vector<std::vector<Timing>> timings(contenders.size());
        std::vector<TraceCounters> counters(contenders.size());
        for (int rep = -1; rep < options_.reps; ++rep)  // the first one warms up
            for (size_t k = 0; k < contenders.size(); ++k) {
                if (!contenders[k].everyPixel && rep != 0) continue;  // slow and steady
                tbb::enumerable_thread_specific<Scratch> scratches;
                const Timing timing = timeOnce(arena, [&] {
                    castTiles(width, height, scratches, [&](const ImageTile& tile, Scratch& own) {
                        contenders[k].caster->castTile(tile, own);
                    });
                });
                if (rep < 0) continue;
                timings[k].push_back(timing);
                counters[k] = {};
                for (const Scratch& own : scratches) counters[k].add(own.counters);
            }
        for (size_t k = 0; k < contenders.size(); ++k) {
            const Timing median = medianOf(timings[k]);
            const auto rays = static_cast<double>(counters[k].rays);
            nlohmann::json line = lineOf(kind, contenders[k].name, threads);
            line.update(extras[k]);
            line["camera"] = camera;
            line["width"] = width;
            line["height"] = height;
            line["reps"] = timings[k].size();
            line["tolerance_px"] = options_.tolerance;
            line["rays"] = counters[k].rays;
            line["ms"] = median.ms;
            line["cpu_ms"] = median.cpuMs;
            line["mrays_per_s"] = rays / median.ms / 1e3;
            line["mrays_per_cpu_s"] = rays / median.cpuMs / 1e3;
            if (counters[k].steps != 0) {
                line["steps_per_ray"] = static_cast<double>(counters[k].steps) / rays;
                line["redone_share"] = static_cast<double>(counters[k].redone) / rays;
            }
            note(line);
        }
    }
}

void Comparison::compare(const NamedCamera& named) {
    CutOptions choice;
    choice.tolerancePx = options_.tolerance;
    choice.surface = options_.surface == "triangles" ? kSurfaceTriangles : kSurfaceBilinear;
    const FrameCut cut = selectCut(*scene_.terrain, named.camera, choice);
    // Embree's rays are straight, so ours are here, too.
    const RayFrame frame(named.camera, scene_.terrain->info().worldFromLattice, 1, 0);
    const EmbreeScene& judge = embree_.triangles ? *embree_.triangles : *embree_.grid;
    const std::vector<float> distances =
        readPicture(*makeEmbreeCaster(judge, frame, 16), options_.width, options_.height);

    const std::vector<Contender> primary = primaryContenders(cut.cut(), frame);
    Lines extras(primary.size(), nlohmann::json::object());
    for (size_t k = 0; k < primary.size(); ++k) {
        if (!primary[k].everyPixel) continue;
        const Agreement agreement = compareDistances(
            readPicture(*primary[k].caster, options_.width, options_.height), distances);
        extras[k] = {{"far_share", agreement.farShare},
                     {"flip_share", agreement.flipShare},
                     {"worst_m", agreement.worst}};
    }
    measure("primary", named.name, primary, extras);

    // Light that comes through the sheet's underside: dark by our rules, lit by Embree's.
    std::vector<Hit> hits = castHits(technique_, cut.cut(), frame);
    std::vector<bool> seenFromAbove;
    for (const Hit& hit : hits)
        seenFromAbove.push_back(isHit(hit) && (hit.flags & kHitFromBelow) == 0);
    const std::vector<Contender> shadows =
        shadowContenders(cut.cut(), frame, std::move(hits), distances);
    const std::vector<float> dark = readPicture(*makeEmbreeShadowCaster(judge, frame, distances),
                                                options_.width, options_.height);
    extras.assign(shadows.size(), nlohmann::json::object());
    for (size_t k = 0; k < shadows.size(); ++k)
        extras[k]["different_share"] = shareOfDifferent(
            readPicture(*shadows[k].caster, options_.width, options_.height), dark, seenFromAbove);
    measure("shadow", named.name, shadows, extras);
}

/// Writes a text file if one is wanted.
Result<void> writeText(const std::string& path, const std::string& text) {
    if (path.empty()) return {};
    std::ofstream file(path);
    if (!(file << text << std::flush))
        return makeError(ErrorCode::Failed, "'{}' cannot be written", path);
    return {};
}

int runPeers(const PeersOptions& options) {
    // What Embree calls it, and Highway.
    const std::string target = options.isa == "avx2" ? "AVX2" : options.target;
    if (!setSimdTarget(target))
        return report(makeError(ErrorCode::Usage, "SIMD target {}: this machine has {}", target,
                                fmt::join(simdTargets(), ", ")));
    auto technique = makeTechnique(options.technique);
    if (!technique) return report(technique.error());
    auto scene = loadScene(options.source.empty() ? syntheticName("fractal", options.size,
                                                                  options.cell, options.format)
                                                  : options.source);
    if (!scene) return report(scene.error());
    Comparison comparison(options, *scene, **technique);
    if (const auto built = comparison.build(); !built) return report(built.error());
    std::vector<NamedCamera> cameras = speedCameras(*scene->terrain, options.width, options.height);
    for (NamedCamera& side : sideCameras(*scene->terrain, options.width, options.height))
        cameras.push_back(std::move(side));
    for (const NamedCamera& named : cameras)
        if (options.camera.empty() || named.name == options.camera) comparison.compare(named);
    const std::string tables = markdownTables(comparison.lines());
    fmt::print("{}", tables);
    std::string lines;
    for (const nlohmann::json& line : comparison.lines()) lines += line.dump() + "\n";
    if (const auto written = writeText(options.json, lines); !written)
        return report(written.error());
    if (const auto written = writeText(options.markdown, tables); !written)
        return report(written.error());
    return 0;
}

}  // namespace

void addPeers(CLI::App& program, Job& job) {
    CLI::App* command = program.add_subcommand("peers", "speed and memory beside Embree's");
    const auto options = std::make_shared<PeersOptions>();
    command->add_option(
        "source", options->source,
        "DEM file or synthetic:... (default: the fractal of --size, --cell, --format)");
    command->add_option("--size", options->size, "posts a side of the fractal")
        ->check(CLI::Range(2, 32767))
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
    command
        ->add_option("--isa", options->isa,
                     "instructions that both are held to (default: each has the machine's best)")
        ->check(CLI::IsMember({"avx2"}));
    command->add_option("--target", options->target, "SIMD target of Terray (default: the best)")
        ->excludes("--isa");
    command->add_option("--camera", options->camera, "one camera only")
        ->check(CLI::IsMember({"low50", "mid500", "high3000", "down5000", "valley", "mountain",
                               "rolled", "outside"}));
    command->add_option("--threads", options->threads, "thread counts (default: 1 and all cores)")
        ->delimiter(',')
        ->check(CLI::Range(1, 4096));
    command->add_option("--technique", options->technique)->capture_default_str();
    command->add_option("--tolerance", options->tolerance, "pixels of error allowed; 0: finest mip")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command
        ->add_option("--triangle-memory", options->triangleGiB,
                     "GiB that Embree may take for building triangles")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command->add_option("--surface", options->surface, "of Terray; Embree has triangles only")
        ->check(CLI::IsMember({"triangles", "bilinear"}))
        ->capture_default_str();
    command->add_flag("--robust", options->robust, "Embree's robust mode (its default is without)");
    command->add_flag("!--no-oracle", options->oracle, "without the oracle, which is slow");
    command->add_option("--json", options->json, "file for the measurements, one JSON line each");
    command->add_option("--markdown", options->markdown, "file for the tables");
    command->footer("Example: terray-bench peers dem.tif --threads 1,2 --json peers.jsonl");
    command->callback([options, &job] { job = [options] { return runPeers(*options); }; });
}

}  // namespace terray::bench
