// SPDX-License-Identifier: Apache-2.0
// Makes a frame's shader: survey of the heights, ramp, sky light, air, photo mips.
#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "shade/deferred.h"
#include "shade/modes.h"
#include "shade/ramp_builtin.h"

namespace terray {
namespace {

/// Width that a sample stands for: the samples of a pixel share it, a little overlapping.
bool needsRamp(Shading shading) {
    return shading == Shading::Photo || shading == Shading::Ramp || shading == Shading::Grid;
}

/// Map makers model gentle ground more strongly than the sun does, so that plains still read. Only
/// under the map maker's sun: with a time or a sun of the user's the light is the true one.
float modellingFor(double meanSlope, double exaggeration, const RenderOptions& options) {
    if (!options.time.empty() || options.sunAzElDeg) return 1.0f;
    constexpr double kWellModelled = 0.42, kMost = 2.5;
    const double slope = std::max(meanSlope * exaggeration, 1e-6);
    return static_cast<float>(std::clamp(std::sqrt(kWellModelled / slope), 1.0, kMost));
}

/// Photos and lines need the shape of what a pixel covers; light only its size.
bool needsFeet(const ShadeSettings& settings) {
    return settings.shading == Shading::Photo || settings.shading == Shading::Grid ||
           settings.options.contoursM > 0;
}

/// Whether to sweep the sun over the drawn tiles, once for each sample's place on its disc, rather
/// than to cast every shadow ray. A cell swept costs about a thirtieth of what a ray gains; half of
/// the pixels may well be sky.
bool sweepPays(const ResidentTerrain& terrain, const TerrainCut& cut, const Camera& camera,
               const ShadeSettings& settings) {
    constexpr double kCellsPerPixel = 12;
    if (!settings.options.shadows || settings.sun.belowHorizon) return false;
    const size_t tiles = drawnSlots(cut).size();
    const double pixels = static_cast<double>(camera.width) * camera.height;
    const auto samples = static_cast<uint64_t>(std::max(settings.options.samples, 1));
    return static_cast<double>(tiles) * kSlotCells * kSlotCells <= kCellsPerPixel * pixels &&
           SunSweep::bytesFor(tiles) * samples <= mostSunSweepBytes(terrain);
}

}  // namespace

float shadeSampleShare(int samples) {
    return std::min(1.0f, 1.25f / std::sqrt(static_cast<float>(std::max(samples, 1))));
}

uint64_t mostSunSweepBytes(const ResidentTerrain& terrain) {
    return terrain.residentBytes() / (terrain.streamer() == nullptr ? 2 : 4);
}

Result<std::unique_ptr<Shader>> Shader::make(const ResidentTerrain& terrain, const TerrainCut& cut,
                                             const RayFrame& rays, DrapedPhoto photo,
                                             const ShadeSettings& settings, ShadeCache* cache) {
    if (settings.shading == Shading::Photo && !photo)
        return makeError(ErrorCode::Usage,
                         "--shading photo needs a photo; give one with --photo RASTER");
    auto background = parseBackground(settings.options.background);
    if (!background) return background.error();
    auto shader =
        std::make_unique<DeferredShader>(terrain, cut, rays, photo, settings, *background);
    ShadeCache own;
    if (auto prepared = shader->prepare(cache ? *cache : own); !prepared) return prepared.error();
    return std::unique_ptr<Shader>(std::move(shader));
}

DeferredShader::DeferredShader(const ResidentTerrain& terrain, const TerrainCut& cut,
                               const RayFrame& rays, DrapedPhoto photo,
                               const ShadeSettings& settings, const Background& background)
    : terrain_(terrain),
      cut_(cut),
      rays_(rays),
      settings_(settings),
      background_(background),
      ground_(cut, terrain.info(), rays, shadeSampleShare(settings.options.samples),
              needsFeet(settings)),
      sunRays_(settings.sun, rays),
      reach_(computeReach(rays.camera(), terrain.info(), rays.exaggeration())),
      light_(makeLight(settings.sun)),
      air_(makeAir(reach_, rays.camera(), settings)),
      display_(&DisplayCurve::forPictures(isLit(settings.shading))),
      photo_(photo),
      sampleShare_(shadeSampleShare(settings.options.samples)) {}

Result<void> DeferredShader::prepare(ShadeCache& cache) {
    if (!isLit(settings_.shading)) return {};
    const TerrainInfo& info = terrain_.info();
    if (sweepPays(terrain_, cut_, rays_.camera(), settings_))
        sunSweeps_ = settings_.sunSweeps
                         ? settings_.sunSweeps
                         : std::make_shared<SunSweepCache>(mostSunSweepBytes(terrain_));
    std::optional<Overview> overview;
    const bool voids = cut_.hasHoles != 0 && background_.kind == Background::Kind::Sky;
    if (settings_.options.base || voids)
        (settings_.options.base ? plinth_ : voids_)
            .emplace(cut_, info, rays_, *cache.rims(cut_, info, overview));
    const auto survey = cache.survey(cut_, info, overview);
    if (needsRamp(settings_.shading)) {
        auto ramp = cache.ramp(settings_.options.ramp, survey->heights);
        if (!ramp) return ramp.error();
        ramp_ = std::move(*ramp);
    }
    modelling_ = modellingFor(survey->meanSlope, rays_.exaggeration(), settings_.options);
    sky_ = cache.skyLight(cut_, info, rays_.exaggeration(), overview, skyMs_);
    if (settings_.shading == Shading::Photo) {
        photoFilter_ = cache.photoFilter(photo_);
        photoMap_.emplace(info.worldFromLattice, photo_.worldFromPixel(),
                          static_cast<double>(sampleShare_));
    }
    return {};
}

void DeferredShader::shadeTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                               float weight, std::span<Colour> sum, ShadeCounters& counters) const {
    if (!isLit(settings_.shading)) {
        shadeFlat(tile, offset, hits, weight, sum, counters);
        return;
    }
    const Scratch& shaded = shadeLit(tile, offset, hits, counters);
    for (size_t first = 0; first < hits.size(); first += kBatch) {
        const size_t count = std::min<size_t>(kBatch, hits.size() - first);
        addBatch(shaded.lit[first / kBatch], std::span(shaded.dark).subspan(first, count), weight,
                 sum.subspan(first, count));
    }
}

void DeferredShader::showTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                              std::span<uint8_t> rgba, ShadeCounters& counters) const {
    if (!isLit(settings_.shading)) {
        std::vector<Colour> sum(hits.size());
        shadeFlat(tile, offset, hits, 1.0f, sum, counters);
        toDisplay(sum, rgba);
        return;
    }
    const Scratch& shaded = shadeLit(tile, offset, hits, counters);
    const CpuStopwatch watch;
    for (size_t first = 0; first < hits.size(); first += kBatch) {
        const size_t count = std::min<size_t>(kBatch, hits.size() - first);
        display_->show(shaded.lit[first / kBatch], std::span(shaded.dark).subspan(first, count),
                       rgba.subspan(4 * first, 4 * count));
    }
    counters.displayMs += watch.elapsedMs();
}

Colour DeferredShader::missColour(const glm::vec3& view) const {
    if (background_.kind == Background::Kind::Transparent) return {};
    rules::Rgb c = background_.kind == Background::Kind::Colour ? background_.colour
                                                                : rules::skyColour(air_, view.z);
    if (!isLit(settings_.shading))
        c = {rules::displayFromScene(c.r), rules::displayFromScene(c.g),
             rules::displayFromScene(c.b)};
    return {c.r, c.g, c.b, 1.0f};
}

std::span<const RampName> rampTable() {
    static const std::vector<RampName> kNames = [] {
        std::vector<RampName> names;
        for (const BuiltinRamp& ramp : builtinRamps())
            names.push_back({std::string(ramp.name), std::string(ramp.line)});
        return names;
    }();
    return kNames;
}

}  // namespace terray
