// SPDX-License-Identifier: Apache-2.0
// `terray-bench terabyte`: a flight over ground that no disk here holds, beside a crop of it in
// memory.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "commands.h"
#include "stream/streamer.h"
#include "streamed.h"
#include "terabyte_check.h"
#include "tile/height_source.h"

namespace terray::bench {
namespace {

constexpr double kMiB = 1 << 20, kGB = 1e9;
constexpr size_t kFramesALine = 20;
constexpr uint64_t kOverBudget = uint64_t{64} << 20;

struct TerabyteOptions {
    int64_t width = 57344, height = 87040;  ///< metres
    int pictureWidth = 1280, pictureHeight = 720, reps = 5, checks = 40, crop = 6144, threads = 2;
    uint64_t memoryMiB = 2048;
    double gigabytes = 0.5, step = 400, above = 300, tolerance = 2.0 / 3;
};

/// A square of the terabyte's mip 0 as a DEM.
class Crop final : public HeightSource {
public:
    Crop(const TerabyteSource& source, int64_t column, int64_t row, int side)
        : source_(source), column_(column), row_(row) {
        info_ = source.info();
        info_.name = "crop";
        info_.scheme = {side + 1, side + 1};
        info_.worldFromLattice.origin = source.info().worldFromLattice.worldFromLattice(
            {static_cast<double>(column), static_cast<double>(row)});
    }
    const TerrainInfo& info() const override { return info_; }
    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        return std::unique_ptr<HeightReader>(new Reader(*this));
    }

private:
    class Reader final : public HeightReader {
    public:
        explicit Reader(const Crop& crop) : crop_(crop) {}
        Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                          std::span<float> posts) override {
            crop_.source_.makePosts(0, crop_.column_ + column, crop_.row_ + row,
                                    static_cast<int>(width), static_cast<int>(height),
                                    posts.data());
            return {};
        }
        Result<void> readCodes(int64_t, int64_t, int64_t, int64_t, std::span<uint16_t>) override {
            return makeError(ErrorCode::Usage, "the terabyte has floats");
        }

    private:
        const Crop& crop_;
    };
    const TerabyteSource& source_;
    int64_t column_, row_;
    TerrainInfo info_;
};

Result<void> checkBounds(const TerabyteSource& source, int checks) {
    auto reader = source.makeReader();
    if (!reader) return reader.error();
    std::mt19937 random(5);
    for (int k = 0; k < checks; ++k) {
        const std::string fault = faultOfBlock(source, **reader, random);
        if (!fault.empty()) return makeError(ErrorCode::Failed, "{}", fault);
    }
    const double rms = finestRms(source, std::max(1, checks / 10), random);
    fmt::print("{}\n", nlohmann::json{{"bench", "terabyte-bounds"},
                                      {"tiles", checks},
                                      {"faults", 0},
                                      {"rms_mip_0_to_1_m", rms}}
                           .dump());
    return {};
}

/// Wanders over the inner part of the ground.
class Flight {
public:
    explicit Flight(const TerabyteOptions& options) : options_(options), random_(9) {
        from_ = {static_cast<double>(options.width) * 0.4,
                 static_cast<double>(options.height) * 0.4, options.above, 30, -10};
    }
    const Standpoint& next() {
        std::uniform_real_distribution<double> turn(-6, 6);
        from_.headingDeg += turn(random_);
        for (int k = 0; k < 36; ++k, from_.headingDeg += 10) {
            const double angle = radFromDeg(from_.headingDeg);
            const double x = from_.x + options_.step * std::sin(angle);
            const double y = from_.y + options_.step * std::cos(angle);
            if (!isInside(x, static_cast<double>(options_.width)) ||
                !isInside(y, static_cast<double>(options_.height)))
                continue;
            from_.x = x;
            from_.y = y;
            break;
        }
        return from_;
    }

private:
    static bool isInside(double at, double side) { return at > 0.1 * side && at < 0.9 * side; }
    const TerabyteOptions& options_;
    std::mt19937 random_;
    Standpoint from_;
};

struct FlightFigures {
    std::vector<double> primaryMs, bringMs, tolerance;
    uint64_t loaded = 0, hits = 0, rays = 0;
};

/// Until so much has been read.
Result<FlightFigures> fly(const StreamedScene& scene, const TerabyteOptions& options,
                          const Technique& technique) {
    FlightFigures figures;
    Flight flight(options);
    const TerabyteSource::Work& work = scene.source->work();
    while (static_cast<double>(work.decodedBytes) < options.gigabytes * kGB) {
        const Camera camera =
            cameraAt(*scene.source, flight.next(), options.pictureWidth, options.pictureHeight);
        auto frame = bringFrame(scene, camera, options.tolerance, true);
        if (!frame) return frame.error();
        const RayFrame rays(camera, scene.terrain->info().worldFromLattice, 1, scene.bend);
        TraceCounters counters;
        tbb::task_arena arena(options.threads);
        const Timing time =
            timeOnce(arena, [&] { counters = traceFrame(technique, frame->cut.cut(), rays); });
        figures.primaryMs.push_back(time.cpuMs);
        figures.bringMs.push_back(frame->bringMs);
        figures.tolerance.push_back(frame->tolerancePx);
        figures.rays += counters.rays;
        figures.hits += counters.hits;
        if (figures.primaryMs.size() % kFramesALine == 0) {
            fmt::print("{}\n",
                       nlohmann::json{{"bench", "terabyte-frames"},
                                      {"frames", figures.primaryMs.size()},
                                      {"decoded_gb", static_cast<double>(work.decodedBytes) / kGB},
                                      {"primary_cpu_ms", time.cpuMs},
                                      {"tiles_wanted", frame->wanted}}
                           .dump());
            std::fflush(stdout);
        }
    }
    figures.loaded = scene.terrain->streamer()->figures().loaded;
    return figures;
}

double share(const std::vector<double>& values, double part) {
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<size_t>(part * static_cast<double>(sorted.size() - 1))];
}

void printFlight(const FlightFigures& f, const StreamedScene& scene, uint64_t peak,
                 const TerabyteOptions& options) {
    const TerabyteSource::Work& work = scene.source->work();
    const auto tiles = static_cast<double>(work.tiles);
    const auto frames = static_cast<double>(f.primaryMs.size());
    fmt::print("{}\n", nlohmann::json{{"bench", "terabyte-flight"},
                                      {"frames", f.primaryMs.size()},
                                      {"tiles_loaded", f.loaded},
                                      {"tiles_a_frame", static_cast<double>(f.loaded) / frames},
                                      {"decoded_gb", static_cast<double>(work.decodedBytes) / kGB},
                                      {"stored_gb", static_cast<double>(work.encodedBytes) / kGB},
                                      {"make_ms_a_tile", work.makeMs / tiles},
                                      {"encode_ms_a_tile", work.encodeMs / tiles},
                                      {"decode_ms_a_tile", work.decodeMs / tiles},
                                      {"primary_cpu_ms_median", median(f.primaryMs)},
                                      {"primary_cpu_ms_p95", share(f.primaryMs, 0.95)},
                                      {"bring_ms_median", median(f.bringMs)},
                                      {"tolerance_px_median", median(f.tolerance)},
                                      {"hits_share",
                                       static_cast<double>(f.hits) / static_cast<double>(f.rays)},
                                      {"budget_mib", options.memoryMiB},
                                      {"peak_above_idle_mib", static_cast<double>(peak) / kMiB}}
                           .dump());
}

/// The same cameras over the streamed ground and over a crop that holds all that they see.
Result<double> compareWithCrop(const StreamedScene& scene, const TerabyteOptions& options,
                               const Technique& technique) {
    const int64_t column = (options.width - options.crop) / 2 / kTileCells * kTileCells;
    const int64_t row = (options.height - options.crop) / 2 / kTileCells * kTileCells;
    const Crop crop(*scene.source, column, row, options.crop);
    BuildStats stats;
    auto whole = ResidentTerrain::build(crop, UINT64_MAX, stats);
    if (!whole) return whole.error();
    const double half = options.crop / 2.0;
    const Vec2 middle = crop.info().worldFromLattice.worldFromLattice({half, half});
    double worst = 0;
    for (const auto& [above, pitch] : {std::pair{100.0, -32.0}, {300.0, -40.0}, {1000.0, -50.0}}) {
        const Camera camera =
            cameraAt(*scene.source, {middle.x, middle.y - half / 3, above, 0, pitch},
                     options.pictureWidth, options.pictureHeight);
        auto frame = bringFrame(scene, camera, options.tolerance, true);
        if (!frame) return frame.error();
        CutOptions cutOptions;
        cutOptions.bend = scene.bend;
        cutOptions.tolerancePx = frame->tolerancePx;
        const FrameCut cut = selectCut(**whole, camera, cutOptions);
        const auto measure = [&](const FrameCut& drawn, const Affine2& map,
                                 TraceCounters& counters) {
            const RayFrame rays(camera, map, 1, scene.bend);
            return timeRuns(1, options.reps,
                            [&] { counters = traceFrame(technique, drawn.cut(), rays); });
        };
        TraceCounters streamed, cropped;
        const Timing a = measure(frame->cut, scene.terrain->info().worldFromLattice, streamed);
        const Timing b = measure(cut, crop.info().worldFromLattice, cropped);
        worst = std::max(worst, a.cpuMs / b.cpuMs);
        fmt::print("{}\n", nlohmann::json{{"bench", "terabyte-crop"},
                                          {"above_m", above},
                                          {"streamed_cpu_ms", a.cpuMs},
                                          {"crop_cpu_ms", b.cpuMs},
                                          {"ratio", a.cpuMs / b.cpuMs},
                                          {"streamed_hits", streamed.hits},
                                          {"crop_hits", cropped.hits},
                                          {"rays", streamed.rays},
                                          {"streamed_tiles_per_mip", frame->cut.tilesPerMip()},
                                          {"crop_tiles_per_mip", cut.tilesPerMip()}}
                               .dump());
    }
    return worst;
}

Result<void> measureTerabyte(const TerabyteOptions& options) {
    auto technique = makeTechnique("ray_cast");
    if (!technique) return technique.error();
    const uint64_t idle = peakResidentBytes();
    auto scene = openStreamed(options.width, options.height, 0, false, options.memoryMiB << 20);
    if (!scene) return scene.error();
    const TilingScheme& scheme = scene->terrain->info().scheme;
    fmt::print("{}\n", nlohmann::json{{"bench", "terabyte-start"},
                                      {"columns", scheme.columns},
                                      {"rows", scheme.rows},
                                      {"mips", scheme.mipCount()},
                                      {"start_ms", scene->startMs}}
                           .dump());
    auto flight = fly(*scene, options, **technique);
    if (!flight) return flight.error();
    const uint64_t above = peakResidentBytes() - idle;
    printFlight(*flight, *scene, above, options);
    TERRAY_TRY(checkBounds(*scene->source, options.checks));
    if (options.crop > 0) {
        auto worst = compareWithCrop(*scene, options, **technique);
        if (!worst) return worst.error();
    }
    if (flight->hits * 10 < flight->rays)
        return makeError(ErrorCode::Failed, "the flight hardly saw the ground");
    if (above > (options.memoryMiB << 20) + kOverBudget)
        return makeError(ErrorCode::Failed, "{:.0f} MiB of memory were used, of {} and 64 allowed",
                         static_cast<double>(above) / kMiB, options.memoryMiB);
    return {};
}

}  // namespace

void addTerabyte(CLI::App& program, Job& job) {
    CLI::App* command = program.add_subcommand(
        "terabyte",
        "a flight over 57 km x 87 km at 1 m, made on demand, and a crop of it in memory");
    const auto options = std::make_shared<TerabyteOptions>();
    command->add_option("--width", options->width, "metres")->check(CLI::Range(2048, 1 << 20));
    command->add_option("--height", options->height, "metres")->check(CLI::Range(2048, 1 << 20));
    command->add_option("--gigabytes", options->gigabytes, "posts to read before the flight ends")
        ->capture_default_str();
    command->add_option("--memory", options->memoryMiB, "MiB")->capture_default_str();
    command->add_option("--check", options->checks, "random tiles held against their bounds")
        ->capture_default_str();
    command->add_option("--crop", options->crop, "metres a side of the crop; 0: none")
        ->check(CLI::Range(0, 12288))
        ->capture_default_str();
    command->add_option("--step", options->step, "metres between two frames")
        ->capture_default_str();
    command->add_option("--above", options->above, "metres over the ground")->capture_default_str();
    command->add_option("--size", options->pictureWidth, "width of a frame; 16:9")
        ->check(CLI::Range(64, 8192))
        ->capture_default_str();
    command->add_option("--reps", options->reps)->check(CLI::Range(1, 1000));
    command->add_option("--threads", options->threads)->check(CLI::Range(1, 4096));
    command->footer("Example: terray-bench terabyte --gigabytes 20 --check 1000");
    command->callback([options, &job] {
        options->pictureHeight = options->pictureWidth * 9 / 16;
        job = [options] {
            const auto done = measureTerabyte(*options);
            return done ? 0 : report(done.error());
        };
    });
}

}  // namespace terray::bench
