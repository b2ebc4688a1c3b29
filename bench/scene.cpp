// SPDX-License-Identifier: Apache-2.0
// Loading of benchmark terrains.
#include "scene.h"

#include <fmt/format.h>

#include <cstdio>
#include <limits>

#include "raster/dem.h"
#include "raster/synthetic.h"

namespace terray::bench {
namespace {

constexpr double kRefraction = 0.13, kEarthRadius = 6371000;
constexpr uint64_t kGdalCache = uint64_t{64} << 20;

Result<std::unique_ptr<HeightSource>> openSource(const std::string& source) {
    auto synthetic = makeSynthetic(source);
    if (!synthetic) return synthetic.error();
    if (*synthetic) return std::move(*synthetic);
    initialiseGdal(kGdalCache);
    auto dem = openDem(source, OpenOptions{});
    if (!dem) return dem.error();
    return std::move(dem->source);
}

}  // namespace

std::string syntheticName(const std::string& kind, int64_t size, double cell,
                          const std::string& format) {
    return fmt::format("synthetic:{}?size={}&cell={}&seed=1&format={}", kind, size, cell, format);
}

Result<Scene> loadScene(const std::string& source) {
    auto heights = openSource(source);
    if (!heights) return heights.error();
    Scene scene;
    scene.name = source;
    auto terrain =
        ResidentTerrain::build(**heights, std::numeric_limits<uint64_t>::max(), scene.build);
    if (!terrain) return terrain.error();
    scene.terrain = std::move(*terrain);
    const double radius = scene.terrain->info().ellipsoidRadius;
    scene.bend = (1 - kRefraction) / (2 * (radius > 0 ? radius : kEarthRadius));
    return scene;
}

int report(const Error& error) {
    std::fprintf(stderr, "terray-bench: %s\n", error.message.c_str());
    return static_cast<int>(error.code);
}

}  // namespace terray::bench
