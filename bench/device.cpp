// SPDX-License-Identifier: Apache-2.0
// `terray-bench device`: primary rays a second of ray_cast on a device, six cameras: the device's
// clock and the whole way there and back, beside the CPU alone.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "commands.h"
#include "device/devices.h"
#include "kernel/scalar/oracle.h"
#include "measure.h"

namespace terray::bench {
namespace {

struct DeviceOptions : SpeedOptions {
    std::string device = "vulkan";
};

struct Figures {
    double deviceMs = 0, castMs = 0, cpuMs = 0;  ///< medians
    TraceCounters counters;
    uint64_t differ = 0;    ///< pixels that hit on one of the two only
    uint64_t wrong = 0;     ///< of these, the device's by the oracle's word
    uint64_t uploaded = 0;  ///< bytes, the first time
};

/// All image tiles of a picture on the CPU.
void castOnCpu(const Technique& technique, const TerrainCut& cut, const RayFrame& rays,
               std::span<const ImageTile> tiles, std::span<Hit> hits) {
    std::vector<size_t> first{0};
    for (const ImageTile& tile : tiles) first.push_back(first.back() + tile.pixelCount());
    tbb::parallel_for(size_t{0}, tiles.size(), [&](size_t k) {
        TraceCounters counters;
        technique.castTile(cut, rays, tiles[k], {0.5, 0.5},
                           hits.subspan(first[k], tiles[k].pixelCount()), counters);
    });
}

Result<Figures> measure(DeviceTechnique& device, const Technique& cpu, const TerrainCut& cut,
                        const RayFrame& rays, int reps) {
    const auto tiles = imageTiles(rays.camera().width, rays.camera().height);
    size_t pixels = 0;
    for (const ImageTile& tile : tiles) pixels += tile.pixelCount();
    std::vector<Hit> hits(pixels), onCpu(pixels);
    Figures figures;
    std::vector<double> deviceMs, castMs, cpuMs;
    for (int k = 0; k <= reps; ++k) {  // one more, to warm up
        DeviceFigures once;
        figures.counters = {};
        TERRAY_TRY(device.prepare(cut, once));
        TERRAY_TRY(device.cast(cut, rays, tiles, {0.5, 0.5}, hits, figures.counters, once));
        const Stopwatch watch;
        castOnCpu(cpu, cut, rays, tiles, onCpu);
        if (k == 0) {
            figures.uploaded = once.uploadedBytes;
            continue;
        }
        deviceMs.push_back(once.deviceMs);
        castMs.push_back(once.castMs);
        cpuMs.push_back(watch.elapsedMs());
    }
    size_t first = 0;
    for (const ImageTile& tile : tiles) {
        for (size_t k = 0; k < tile.pixelCount(); ++k) {
            const Hit& hit = hits[first + k];
            if (isHit(hit) == isHit(onCpu[first + k])) continue;
            const auto width = static_cast<size_t>(tile.width);
            const Ray ray = rays.rayThrough(tile.x + static_cast<double>(k % width) + 0.5,
                                            tile.y + static_cast<double>(k / width) + 0.5);
            ++figures.differ;
            figures.wrong += isHit(hit) != isHit(oracle::firstHit(cut, ray).hit) ? 1 : 0;
        }
        first += tile.pixelCount();
    }
    figures.deviceMs = median(deviceMs);
    figures.castMs = median(castMs);
    figures.cpuMs = median(cpuMs);
    return figures;
}

nlohmann::json jsonOf(const Scene& scene, const DeviceOptions& options, const std::string& camera,
                      const std::string& device, const Figures& f) {
    const auto rays = static_cast<double>(f.counters.rays);
    return {{"bench", "device"},
            {"terrain", scene.name},
            {"device", device},
            {"camera", camera},
            {"width", options.width},
            {"height", options.height},
            {"tolerance_px", options.tolerance},
            {"reps", options.reps},
            {"device_ms", f.deviceMs},
            {"cast_ms", f.castMs},
            {"cpu_ms", f.cpuMs},
            {"device_mrays_per_s", f.deviceMs > 0 ? rays / f.deviceMs * 1e-3 : 0},
            {"mrays_per_s", rays / f.castMs * 1e-3},
            {"rays", f.counters.rays},
            {"hits", f.counters.hits},
            {"steps_per_ray", static_cast<double>(f.counters.steps) / rays},
            {"redone_share", static_cast<double>(f.counters.redone) / rays},
            {"upload_bytes", f.uploaded},
            {"hit_on_one_only", f.differ},
            {"wrong", f.wrong}};
}

void printTable(const std::vector<nlohmann::json>& lines) {
    fmt::print("{:<10} {:>10} {:>10} {:>10} {:>16} {:>10} {:>10} {:>9} {:>7} {:>6}\n", "camera",
               "device ms", "with host", "CPU alone", "device M rays/s", "M rays/s", "steps/ray",
               "redone %", "differ", "wrong");
    for (const nlohmann::json& line : lines)
        fmt::print(
            "{:<10} {:>10.1f} {:>10.1f} {:>10.1f} {:>16.1f} {:>10.1f} {:>10.2f} {:>9.4f} {:>7} "
            "{:>6}\n",
            line["camera"].get<std::string>(), line["device_ms"].get<double>(),
            line["cast_ms"].get<double>(), line["cpu_ms"].get<double>(),
            line["device_mrays_per_s"].get<double>(), line["mrays_per_s"].get<double>(),
            line["steps_per_ray"].get<double>(), 100 * line["redone_share"].get<double>(),
            line["hit_on_one_only"].get<uint64_t>(), line["wrong"].get<uint64_t>());
}

int runDevice(const DeviceOptions& options) {
    auto bench = openBench(options);
    if (!bench) return report(bench.error());
    const auto wish = parseDevice(options.device);
    if (!wish) return report(wish.error());
    DeviceRequest request;
    request.which = wish->which;
    auto device = openTechnique(options.technique, request);
    if (!device) return report(device.error());
    std::vector<nlohmann::json> lines;
    for (const NamedCamera& named : bench->cameras) {
        const FrameCut cut = cutFor(*bench, named.camera, options.tolerance, false);
        const RayFrame rays(named.camera, bench->scene.terrain->info().worldFromLattice, 1,
                            bench->scene.bend);
        const auto figures = measure(**device, *bench->technique, cut.cut(), rays, options.reps);
        if (!figures) return report(figures.error());
        lines.push_back(
            jsonOf(bench->scene, options, named.name, (*device)->deviceName(), *figures));
    }
    printTable(lines);
    for (const nlohmann::json& line : lines) fmt::print("{}\n", line.dump());
    return 0;
}

}  // namespace

void addDevice(CLI::App& program, Job& job) {
    CLI::App* command =
        program.add_subcommand("device", "M rays/s of ray_cast on a Vulkan device, six cameras");
    const auto options = std::make_shared<DeviceOptions>();
    addSpeedOptions(*command, *options);
    command->add_option("--device", options->device, "as for terray render");
    command->footer("Example: terray-bench device --device vulkan:0 --camera mid500");
    command->callback([options, &job] { job = [options] { return runDevice(*options); }; });
}

}  // namespace terray::bench
