// SPDX-License-Identifier: Apache-2.0
// A terrain to measure: a DEM file or a synthetic one, resident, with the bend of its rays.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "stream/resident.h"

namespace terray::bench {

struct Scene {
    std::string name;
    std::unique_ptr<ResidentTerrain> terrain;
    BuildStats build;
    double bend = 0;  ///< 1/m: curvature less refraction; of a middling Earth if there is no CRS
};

/// Names of the surfaces, by SurfaceKind.
constexpr const char* kSurfaceNames[] = {"bilinear", "constant", "triangles"};

/// Name of the synthetic source of a kind ("fractal", "town") with `size` posts a side.
std::string syntheticName(const std::string& kind, int64_t size, double cell,
                          const std::string& format);

/// Opens a DEM file or a synthetic source and builds all mips.
Result<Scene> loadScene(const std::string& source);

/// Prints the error; returns its exit code.
int report(const Error& error);

}  // namespace terray::bench
