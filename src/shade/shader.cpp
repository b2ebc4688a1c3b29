// SPDX-License-Identifier: Apache-2.0
// Makes a frame's shader: survey of the heights, ramp, sky light, air, photo mips.
#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "shade/deferred.h"
#include "shade/modes.h"
#include "shade/overview.h"
#include "shade/ramp_builtin.h"

namespace terray {
namespace {

/// Posts of the overview that sky light and ramps are made from.
constexpr int64_t kOverviewPosts = 2'000'000;

/// Width that a sample stands for: the samples of a pixel share it, a little overlapping.
float sampleShare(int samples) {
    return std::min(1.0f, 1.25f / std::sqrt(static_cast<float>(std::max(samples, 1))));
}

bool needsRamp(Shading shading) {
    return shading == Shading::Photo || shading == Shading::Ramp || shading == Shading::Grid;
}

/// Map makers model gentle ground more strongly than the sun does, so that plains still read. Only
/// under the map maker's sun: with a time or a sun of the user's the light is the true one.
float modellingFor(const Overview& view, const TerrainInfo& info, double exaggeration,
                   const RenderOptions& options) {
    if (!options.time.empty() || options.sunAzElDeg) return 1.0f;
    constexpr double kWellModelled = 0.42, kMost = 2.5;
    const double slope = std::max(meanSlope(view, info.worldFromLattice) * exaggeration, 1e-6);
    return static_cast<float>(std::clamp(std::sqrt(kWellModelled / slope), 1.0, kMost));
}

/// Photos and lines need the shape of what a pixel covers; light only its size.
bool needsFeet(const ShadeSettings& settings) {
    return settings.shading == Shading::Photo || settings.shading == Shading::Grid ||
           settings.options.contoursM > 0;
}

}  // namespace

Result<std::unique_ptr<Shader>> Shader::make(const ResidentTerrain& terrain, const TerrainCut& cut,
                                             const RayFrame& rays, const Photo* photo,
                                             const ShadeSettings& settings) {
    if (settings.shading == Shading::Photo && !photo)
        return makeError(ErrorCode::Usage,
                         "--shading photo needs a photo; give one with --photo RASTER");
    auto background = parseBackground(settings.options.background);
    if (!background) return background.error();
    auto shader =
        std::make_unique<DeferredShader>(terrain, cut, rays, photo, settings, *background);
    if (auto prepared = shader->prepare(); !prepared) return prepared.error();
    return std::unique_ptr<Shader>(std::move(shader));
}

DeferredShader::DeferredShader(const ResidentTerrain& terrain, const TerrainCut& cut,
                               const RayFrame& rays, const Photo* photo,
                               const ShadeSettings& settings, const Background& background)
    : terrain_(terrain),
      cut_(cut),
      rays_(rays),
      settings_(settings),
      background_(background),
      ground_(cut, terrain.info(), rays, sampleShare(settings.options.samples),
              needsFeet(settings)),
      sunRays_(settings.sun, rays),
      reach_(computeReach(rays.camera(), terrain.info(), rays.exaggeration())),
      light_(makeLight(settings.sun)),
      air_(makeAir(reach_, rays.camera(), settings)),
      display_(isLit(settings.shading)),
      photo_(photo),
      sampleShare_(sampleShare(settings.options.samples)) {}

Result<void> DeferredShader::prepare() {
    if (!isLit(settings_.shading)) return {};
    const TerrainInfo& info = terrain_.info();
    Overview overview = makeOverview(cut_, info.scheme, kOverviewPosts);
    if (settings_.options.base) plinth_.emplace(cut_, info, rays_, overview);
    if (needsRamp(settings_.shading)) {
        const double cell = std::ldexp(info.worldFromLattice.columnLength(), overview.mip);
        const HeightSurvey survey = surveyHeights(
            {overview.heights, overview.width, cell, info.minZ, info.maxZ, !info.crsWkt.empty()});
        auto ramp = HeightRamp::make(settings_.options.ramp, survey);
        if (!ramp) return ramp.error();
        ramp_ = std::move(*ramp);
    }
    modelling_ = modellingFor(overview, info, rays_.exaggeration(), settings_.options);
    Stopwatch watch;
    sky_.emplace(std::move(overview), info.worldFromLattice, rays_.exaggeration());
    skyMs_ = watch.elapsedMs();
    if (settings_.shading == Shading::Photo) {
        photoFilter_.emplace(*photo_);
        constexpr size_t kEntries = 1025;
        for (size_t k = 0; k < kEntries; ++k)
            sceneFromPhoto_.push_back(
                rules::sceneFromDisplay(static_cast<float>(k) / static_cast<float>(kEntries - 1)));
    }
    return {};
}

void DeferredShader::shadeTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                               float weight, std::span<Colour> sum, ShadeCounters& counters) const {
    if (isLit(settings_.shading))
        shadeLit(tile, offset, hits, weight, sum, counters);
    else
        shadeFlat(tile, offset, hits, weight, sum, counters);
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
