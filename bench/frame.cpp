// SPDX-License-Identifier: Apache-2.0
// `terray-bench frame`: whole frames of one view into memory, again and again, and where their time
// goes.
#include <fmt/format.h>
#include <tbb/info.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "cameras.h"
#include "commands.h"
#include "engine/places.h"
#include "image/writer.h"
#include "scene.h"
#include "terray/process.h"
#include "terray/renderer.h"
#include "timing.h"

namespace terray::bench {
namespace {

struct FrameOptions {
    std::string source;  ///< empty: the fractal
    int64_t size = 4096;
    double cell = 10;
    std::string format = "int16", camera, photo, technique = "ray_cast";
    std::vector<std::string> shadings{"ramp", "photo"};
    int width = 1920, height = 1080, reps = 7, samples = 1;
    std::vector<int> threads;
    double tolerance = 2.0 / 3.0;
    bool noShadows = false;
};

/// Medians over the repetitions, milliseconds; parts are CPU time over the number of threads.
struct FrameFigures {
    double firstMs = 0, ms = 0, cpuMs = 0;
    double setupMs = 0, primaryMs = 0, shadowMs = 0, shadeMs = 0, displayMs = 0;
    RenderStats last;
};

/// A photo of 4096 x 4096 pixels in a file that is gone with it: fields, noise, hard edges.
class SyntheticPhoto {
public:
    static Result<std::unique_ptr<SyntheticPhoto>> make() {
        auto photo = std::make_unique<SyntheticPhoto>();
        ImageSpec spec;
        spec.width = spec.height = kSide;
        spec.channels = 3;
        auto writer = makeImageWriter(photo->path(), spec);
        if (!writer) return writer.error();
        std::vector<uint8_t> row(size_t{kSide} * 3);
        for (unsigned y = 0; y < kSide; ++y) {
            for (unsigned x = 0; x < kSide; ++x) {
                const unsigned field = (x / 96 * 2654435761u) ^ (y / 64 * 40503u * 65537u);
                const unsigned noise = (x * 73856093u ^ y * 19349663u) * 2246822519u;
                for (unsigned c = 0; c < 3; ++c)
                    row[3 * x + c] = static_cast<uint8_t>(60 + ((field >> (8 * c)) & 127) +
                                                          ((noise >> (27 - c)) & 31));
            }
            TERRAY_TRY((*writer)->writeRows(std::span<const uint8_t>(row)));
        }
        TERRAY_TRY((*writer)->finish());
        return photo;
    }
    ~SyntheticPhoto() {
        std::error_code ignored;
        std::filesystem::remove(path(), ignored);
    }
    const std::string& path() const { return path_; }

private:
    static constexpr unsigned kSide = 4096;
    std::string path_ = (std::filesystem::temp_directory_path() /
                         fmt::format("terray-bench-{}.tif",
                                     std::chrono::steady_clock::now().time_since_epoch().count()))
                            .string();
};

Result<Shading> shadingOf(const std::string& name) {
    if (name == "photo") return Shading::Photo;
    if (name == "ramp") return Shading::Ramp;
    if (name == "hillshade") return Shading::Hillshade;
    if (name == "light") return Shading::Light;
    return makeError(ErrorCode::Usage, "--shading {}: give ramp, photo, hillshade or light", name);
}

/// The camera's view with places as the source's CRS writes them.
Result<View> viewOf(const Terrain& terrain, const NamedCamera& named) {
    auto places = PlaceResolver::make(terrain.state(), false, Surface::Bilinear);
    if (!places) return places.error();
    View view = named.view;
    auto eye = places->dataFromWorld({view.eye->x, view.eye->y});
    if (!eye) return eye.error();
    view.eye->x = eye->x;
    view.eye->y = eye->y;
    return view;
}

Result<FrameFigures> measure(const Terrain& terrain, const View& view, const RenderOptions& options,
                             int reps) {
    std::vector<uint8_t> rgba(static_cast<size_t>(view.width) * static_cast<size_t>(view.height) *
                              4);
    FrameFigures figures;
    std::vector<double> ms, cpu, setup, primary, shadow, shade, display;
    for (int rep = -1; rep < reps; ++rep) {
        const double cpuStart = cpuMs();
        const Stopwatch watch;
        auto stats = render(terrain, view, options, rgba);
        if (!stats) return stats.error();
        if (rep < 0) {
            figures.firstMs = watch.elapsedMs();
            continue;
        }
        ms.push_back(watch.elapsedMs());
        cpu.push_back(cpuMs() - cpuStart);
        setup.push_back(stats->setupMs);
        primary.push_back(stats->primaryMs);
        shadow.push_back(stats->shadowMs);
        display.push_back(stats->displayMs);
        shade.push_back(stats->shadeMs - stats->shadowMs - stats->displayMs);
        figures.last = *stats;
    }
    figures.ms = median(ms);
    figures.cpuMs = median(cpu);
    figures.setupMs = median(setup);
    figures.primaryMs = median(primary);
    figures.shadowMs = median(shadow);
    figures.shadeMs = median(shade);
    figures.displayMs = median(display);
    return figures;
}

nlohmann::json jsonOf(const FrameOptions& options, const std::string& source,
                      const std::string& shading, const std::string& camera, int threads,
                      const FrameFigures& f) {
    const double pixels = static_cast<double>(options.width) * options.height;
    const auto perPixel = [&](double ms) { return ms * threads * 1e6 / pixels; };
    return {{"bench", "frame"},
            {"terrain", source},
            {"technique", options.technique},
            {"target", f.last.simd},
            {"shading", shading},
            {"camera", camera},
            {"width", options.width},
            {"height", options.height},
            {"samples", options.samples},
            {"tolerance_px", options.tolerance},
            {"threads", threads},
            {"reps", options.reps},
            {"first_ms", f.firstMs},
            {"ms", f.ms},
            {"cpu_ms", f.cpuMs},
            {"frames_per_s", 1e3 / f.ms},
            {"setup_ms", f.setupMs},
            {"primary_ms", f.primaryMs},
            {"shadow_ms", f.shadowMs},
            {"shade_ms", f.shadeMs},
            {"display_ms", f.displayMs},
            {"primary_ns", perPixel(f.primaryMs)},
            {"shadow_ns", perPixel(f.shadowMs)},
            {"shade_ns", perPixel(f.shadeMs)},
            {"display_ns", perPixel(f.displayMs)},
            {"hits", f.last.hits},
            {"shadow_rays", f.last.shadowRays}};
}

void printFrameTable(const std::vector<nlohmann::json>& lines) {
    fmt::print(
        "{:<9} {:<9} {:>7} {:>8} {:>8} {:>8} {:>7} {:>8} | core ns a pixel: {:>7} {:>7} {:>7} "
        "{:>7}\n",
        "shading", "camera", "threads", "first ms", "ms", "cpu ms", "fps", "setup ms", "primary",
        "shadow", "shade", "display");
    for (const nlohmann::json& line : lines) {
        const auto number = [&](const char* key) { return line[key].get<double>(); };
        fmt::print(
            "{:<9} {:<9} {:>7} {:>8.1f} {:>8.2f} {:>8.1f} {:>7.1f} {:>8.2f} | {:>24.1f} {:>7.1f} "
            "{:>7.1f} {:>7.1f}\n",
            line["shading"].get<std::string>(), line["camera"].get<std::string>(),
            line["threads"].get<int>(), number("first_ms"), number("ms"), number("cpu_ms"),
            number("frames_per_s"), number("setup_ms"), number("primary_ns"), number("shadow_ns"),
            number("shade_ns"), number("display_ns"));
    }
}

Result<void> measureTerrain(const FrameOptions& options, const std::string& source,
                            const std::string& photo, int threads,
                            std::vector<nlohmann::json>& lines) {
    OpenOptions open;
    open.threads = threads;
    open.photo = photo;
    auto terrain = Terrain::open(source, open);
    if (!terrain) return terrain.error();
    RenderOptions render;
    render.technique = options.technique;
    render.samples = options.samples;
    render.tolerancePx = options.tolerance;
    render.shadows = !options.noShadows;
    for (const std::string& name : options.shadings) {
        auto shading = shadingOf(name);
        if (!shading) return shading.error();
        render.shading = *shading;
        for (const NamedCamera& named :
             speedCameras(*terrain->state().resident, options.width, options.height)) {
            if (!options.camera.empty() && named.name != options.camera) continue;
            auto view = viewOf(*terrain, named);
            if (!view) return view.error();
            auto figures = measure(*terrain, *view, render, options.reps);
            if (!figures) return figures.error();
            lines.push_back(jsonOf(options, source, name, named.name, threads, *figures));
        }
    }
    return {};
}

int runFrame(const FrameOptions& options) {
    setQuiet(true);
    const std::string source = options.source.empty() ? syntheticName("fractal", options.size,
                                                                      options.cell, options.format)
                                                      : options.source;
    std::unique_ptr<SyntheticPhoto> synthetic;
    std::string photo = options.photo;
    const auto& shadings = options.shadings;
    if (photo.empty() && std::find(shadings.begin(), shadings.end(), "photo") != shadings.end()) {
        auto made = SyntheticPhoto::make();
        if (!made) return report(made.error());
        synthetic = std::move(*made);
        photo = synthetic->path();
    }
    std::vector<int> threadCounts = options.threads;
    if (threadCounts.empty()) {
        threadCounts = {1};
        if (const int cores = tbb::info::default_concurrency(); cores > 1)
            threadCounts.push_back(cores);
    }
    std::vector<nlohmann::json> lines;
    for (const int threads : threadCounts)
        if (auto done = measureTerrain(options, source, photo, threads, lines); !done)
            return report(done.error());
    fmt::print("{}, {} x {}, {} samples a pixel, median of {}\n", source, options.width,
               options.height, options.samples, options.reps);
    printFrameTable(lines);
    for (const nlohmann::json& line : lines) fmt::print("{}\n", line.dump());
    return 0;
}

}  // namespace

void addFrame(CLI::App& program, Job& job) {
    CLI::App* command =
        program.add_subcommand("frame", "whole frames into memory and their parts, six cameras");
    const auto options = std::make_shared<FrameOptions>();
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
    command->add_option("--shading", options->shadings, "ramp, photo, hillshade, light")
        ->delimiter(',')
        ->capture_default_str();
    command->add_option("--photo", options->photo, "photo to drape (default: a synthetic one)");
    command->add_option("--samples", options->samples, "rays a pixel")
        ->check(CLI::IsMember({1, 2, 4, 8, 16}))
        ->capture_default_str();
    command->add_option("--reps", options->reps, "timed frames; the median counts")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--width", options->width)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--height", options->height)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--camera", options->camera, "one camera only")
        ->check(CLI::IsMember(speedCameraNames()));
    command->add_option("--threads", options->threads, "thread counts (default: 1 and all cores)")
        ->delimiter(',')
        ->check(CLI::Range(1, 4096));
    command->add_option("--technique", options->technique)->capture_default_str();
    command->add_option("--tolerance", options->tolerance, "pixels of error allowed; 0: finest mip")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command->add_flag("--no-shadows", options->noShadows, "without the sun's shadows");
    command->footer("Example: terray-bench frame --camera mid500 --shading ramp --threads 2");
    command->callback([options, &job] { job = [options] { return runFrame(*options); }; });
}

}  // namespace terray::bench
