// SPDX-License-Identifier: Apache-2.0
// The plain plinth of --base: vertical walls from the rim of the terrain, and of its holes, down to
// a level base, as model makers build them. A decoration of pictures: no hit, AOV or query knows
// it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "shade/shade.h"

namespace terray {

/// const-shared.
class Plinth {
public:
    Plinth(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays);

    struct WallHit {
        float t = 0;          ///< distance along the ray
        glm::vec3 normal{0};  ///< unit, horizontal; of either side
    };
    /// First wall before `tMax` on a lattice ray.
    std::optional<WallHit> firstWall(const Ray& ray, double tMax) const;

private:
    bool isGround(int64_t i, int64_t j) const;
    std::optional<WallHit> wallInBlock(const Ray& ray, double tIn, double tOut) const;
    std::optional<WallHit> wallAt(const Ray& ray, double t, bool acrossI) const;

    const TerrainCut& cut_;
    int64_t cellsI_, cellsJ_;
    double baseZ_;                 ///< true metres
    glm::vec3 acrossI_, acrossJ_;  ///< unit normals of the walls at fixed i and at fixed j
    int64_t blocksI_, blocksJ_;
    std::vector<uint8_t> hasRim_;  ///< per block of cells: a wall may stand in it or on its border
};

}  // namespace terray
