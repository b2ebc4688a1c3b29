// SPDX-License-Identifier: Apache-2.0
// The public renderer: one frame into memory or files, with its figures.
#include "terray/renderer.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <new>

#include "base/log.h"
#include "base/stopwatch.h"
#include "device/devices.h"
#include "engine/bands.h"
#include "engine/check.h"
#include "engine/outputs.h"
#include "engine/terrain_state.h"
#include "kernel/trace.h"
#include "shade/shade.h"
#include "technique/technique.h"

namespace terray {
namespace {

void addPhotoFigures(const PhotoFigures& photo, RenderStats& s) {
    s.photoInBlocks = true;
    s.photoBlocksWanted = photo.wanted;
    s.photoBlocksLoaded = photo.loaded;
    s.photoBlocksEvicted = photo.evicted;
    s.photoBlocksAbsent = photo.absent;
    s.photoMissingPixels = photo.lateSamples;
    s.bytesRead += photo.bytesRead;
}

RenderStats collectStats(const Terrain::State& state, const Frame& frame,
                         const BandFigures& figures) {
    RenderStats s;
    s.device = figures.lostDevice ? frame.device + ", lost; then cpu" : frame.device;
    s.deviceMs = figures.device.deviceMs;
    s.deviceUploadBytes = frame.deviceFigures.uploadedBytes;
    s.technique = frame.options.technique;
    s.simd = activeSimdTarget();
    s.width = frame.camera().width;
    s.height = frame.camera().height;
    s.samples = frame.options.samples;
    s.threads = state.threads;
    s.rays = figures.trace.rays;
    s.hits = figures.trace.hits;
    s.redone = figures.trace.redone;
    s.columnRays = figures.trace.columns;
    s.beamRays = figures.trace.beams;
    s.shadowRays = figures.shade.shadowRays;
    s.loadMs = state.build.loadMs;
    s.buildMs = state.build.buildMs;
    s.skyMs = frame.shader->skyMs();
    s.primaryMs = figures.traceMs / state.threads + figures.device.castMs;
    s.setupMs = frame.setupMs;
    s.shadeMs = figures.shadeMs / state.threads;
    s.shadowMs = figures.shade.shadowMs / state.threads;
    s.displayMs = figures.displayMs / state.threads;
    if (s.primaryMs > 0) s.mraysPerS = static_cast<double>(s.rays) * 1e-3 / s.primaryMs;
    if (s.rays > 0)
        s.stepsPerRay = static_cast<double>(figures.trace.steps) / static_cast<double>(s.rays);
    s.residentBytes = state.build.residentBytes;
    const TilingScheme& scheme = state.resident->info().scheme;
    s.bytesPerSample = static_cast<double>(s.residentBytes) /
                       (static_cast<double>(scheme.columns) * static_cast<double>(scheme.rows));
    s.peakRssBytes = peakResidentBytes();
    s.tolerancePx = frame.tolerancePx;
    s.onDemand = state.resident->streamer() != nullptr;
    s.tilesWanted = frame.tiles.wanted;
    s.tilesLoaded = frame.tiles.loaded;
    s.tilesEvicted = frame.tiles.evicted;
    s.tilesAbsent = frame.tiles.absent;
    s.tilesLate = frame.cut.standIns();
    s.missingTilePixels = figures.lateHits;
    s.tileLatencyMs = frame.tiles.latencyMs;
    s.tileLatencyP99Ms = frame.tiles.latencyP99Ms;
    s.bytesRead = frame.tiles.bytesRead;
    if (frame.photo) addPhotoFigures(frame.photo->figures(), s);
    s.maxErrorMetres = static_cast<double>(frame.cut.cut().maxError);
    s.tilesPerMip = frame.cut.tilesPerMip();
    return s;
}

/// Runs work in the terrain's arena; bad_alloc becomes an Error.
template <class Work>
Result<RenderStats> inArena(const Terrain& terrain, const RenderOptions& options, Work work) {
    try {
        Result<RenderStats> result = RenderStats{};
        // Before entering the arena: a thread that waits in there may take up other work.
        const auto held = terrain.state().holdTiles();
        const auto heldDevice = terrain.state().caster.hold(options);
        terrain.state().arena.execute([&] { result = work(terrain.state()); });
        return result;
    } catch (const std::bad_alloc&) {
        return makeError(ErrorCode::Resource, "the machine ran out of memory while rendering");
    }
}

Result<RenderStats> renderInto(const Terrain::State& state, const View& view,
                               const RenderOptions& options, std::span<uint8_t> rgba) {
    const Stopwatch watch;
    auto frame = makeFrame(state, view, options);
    if (!frame) return frame.error();
    const size_t row = static_cast<size_t>(view.width) * 4;
    auto figures = renderBands(**frame, BandDemand{}, [&](const Band& band) -> Result<void> {
        std::memcpy(rgba.data() + static_cast<size_t>(band.firstRow) * row, band.display.data(),
                    band.display.size());
        return {};
    });
    if (!figures) return figures.error();
    RenderStats stats = collectStats(state, **frame, *figures);
    stats.totalMs = stats.loadMs + stats.buildMs + watch.elapsedMs();
    return stats;
}

Result<RenderStats> renderFiles(const Terrain::State& state, const View& view,
                                const RenderOptions& options, const OutputOptions& outputs) {
    const Stopwatch watch;
    auto frame = makeFrame(state, view, options);
    if (!frame) return frame.error();
    auto files = OutputFiles::make(view.width, view.height, (*frame)->hasAlpha(), outputs,
                                   (*frame)->georeference(state.resident->info()));
    if (!files) return files.error();
    auto figures = renderBands(**frame, files->demand(),
                               [&](const Band& band) { return files->writeBand(band); });
    if (!figures) return figures.error();
    TERRAY_TRY(files->finish());
    if (figures->trace.hits == 0 && !state.isEmpty())
        log::warning(
            "no ray meets the terrain: the picture does not show it; check the camera's flags");
    RenderStats stats = collectStats(state, **frame, *figures);
    stats.writeMs = files->writeMs();
    stats.totalMs = stats.loadMs + stats.buildMs + watch.elapsedMs();
    return stats;
}

/// Nobody wants a DEM overwritten by its picture.
Result<void> refuseToOverwrite(const SourceInfo& source, const OutputOptions& outputs) {
    std::vector<std::string> paths{outputs.path};
    for (const AovOutput& aov : outputs.aovs) paths.push_back(aov.path);
    for (const std::string& path : paths) {
        std::error_code ignored;
        if (!path.empty() && std::filesystem::equivalent(path, source.source, ignored))
            return makeError(ErrorCode::Usage,
                             "'{}' is the source; write the picture somewhere else", path);
    }
    return {};
}

}  // namespace

Result<RenderStats> render(const Terrain& terrain, const View& view, const RenderOptions& options,
                           std::span<uint8_t> rgba) {
    TERRAY_TRY(checkView(view));
    if (rgba.size() != static_cast<size_t>(view.width) * static_cast<size_t>(view.height) * 4)
        return makeError(ErrorCode::Usage, "render: {} bytes do not hold {}x{} pixels of 4 bytes",
                         rgba.size(), view.width, view.height);
    return inArena(terrain, options, [&](const Terrain::State& state) {
        return renderInto(state, view, options, rgba);
    });
}

Result<RenderStats> renderToFiles(const Terrain& terrain, const View& view,
                                  const RenderOptions& options, const OutputOptions& outputs) {
    TERRAY_TRY(checkOutputNames(options, outputs));
    TERRAY_TRY(refuseToOverwrite(terrain.info(), outputs));
    return inArena(terrain, options, [&](const Terrain::State& state) {
        return renderFiles(state, view, options, outputs);
    });
}

Result<void> checkRender(const View& view, const RenderOptions& options,
                         const OutputOptions& outputs) {
    TERRAY_TRY(checkView(view));
    TERRAY_TRY(checkOptions(view, options));
    TERRAY_TRY(checkOutputNames(options, outputs));
    auto files = OutputFiles::make(view.width, view.height, options.background == "transparent",
                                   outputs, std::nullopt);
    if (!files) return files.error();
    return {};
}

std::vector<NamedLine> techniques() {
    std::vector<NamedLine> lines;
    for (const TechniqueEntry& entry : techniqueTable()) lines.push_back({entry.name, entry.line});
    return lines;
}

std::vector<NamedLine> ramps() {
    std::vector<NamedLine> lines;
    for (const RampName& ramp : rampTable()) lines.push_back({ramp.name, ramp.line});
    return lines;
}

std::vector<NamedLine> devices() {
    std::vector<NamedLine> lines{{"cpu", "all cores, " + activeSimdTarget() + " (auto)"}};
    const auto found = listDevices();
    if (!found) lines.push_back({"vulkan", found.error().message});
    for (size_t k = 0; found && k < found->size(); ++k) {
        const DeviceEntry& d = (*found)[k];
        const std::string lacks = d.lacks.empty() ? "" : "; cannot be used, lacks " + d.lacks;
        lines.push_back({fmt::format("vulkan:{}", k), d.name + ", " + d.kind + lacks});
    }
    return lines;
}

std::vector<NamedLine> shadings() {
    return {
        {"photo", "the photo given by --photo, with relief"},
        {"ramp", "hypsometric tints in sun and sky light"},
        {"hillshade", "grey relief, lit from several directions, without shadows"},
        {"light", "the light alone, on white ground"},
        {"grid", "lit surface with the lines of the cells"},
        {"slope", "steepness, 0 to 90 degrees"},
        {"height", "height, dark violet lowest to yellow highest"},
        {"depth", "distance along the view axis, white near to black far"},
        {"distance", "distance along the ray, white near to black far"},
        {"normal", "the surface normal as a colour"},
        {"mip", "which resolution is drawn where"},
        {"steps", "traversal steps of each ray"},
        {"shadow-steps", "traversal steps of each shadow ray"},
    };
}

}  // namespace terray
