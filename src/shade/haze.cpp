// SPDX-License-Identifier: Apache-2.0
// Sets up the air of a frame.
#include "shade/haze.h"

#include <algorithm>
#include <cmath>

#include "shade/rules/lines.h"

namespace terray {

SceneReach computeReach(const Camera& camera, const TerrainInfo& info, double exaggeration) {
    const Affine2& map = info.worldFromLattice;
    const auto columns = static_cast<double>(info.scheme.columns - 1);
    const auto rows = static_cast<double>(info.scheme.rows - 1);
    const LatticePoint eye = map.latticeFromWorld({camera.eye.x, camera.eye.y});
    const Vec2 beside =
        map.worldFromLattice({std::clamp(eye.i, 0.0, columns), std::clamp(eye.j, 0.0, rows)});
    const double low = info.minZ * exaggeration, high = info.maxZ * exaggeration;
    const double above = camera.eye.z - std::clamp(camera.eye.z, low, high);
    SceneReach reach;
    reach.nearest =
        static_cast<float>(std::hypot(beside.x - camera.eye.x, beside.y - camera.eye.y, above));
    double farthest = 0;
    for (const LatticePoint corner :
         {LatticePoint{0, 0}, {columns, 0}, {0, rows}, {columns, rows}}) {
        const Vec2 place = map.worldFromLattice(corner);
        const Vec3 away{place.x - camera.eye.x, place.y - camera.eye.y,
                        0.5 * (low + high) - camera.eye.z};
        const double distance = glm::length(away);
        if (distance <= farthest) continue;
        farthest = distance;
        reach.farSine = static_cast<float>(away.z / distance);
    }
    reach.farthest = static_cast<float>(std::max(farthest, 1e-3));
    return reach;
}

rules::Air makeAir(const SceneReach& reach, const Camera& camera, const ShadeSettings& settings) {
    constexpr float kVisual = 3.912023f;  // contrast of 2 % at the visual range (Koschmieder)
    rules::Air air;
    const float daylight = settings.sun.belowHorizon ? 0.35f : 1.0f;
    air.horizon = rules::sceneFromCodes(229, 233, 236) * daylight;
    air.zenith = rules::sceneFromCodes(122, 160, 201) * daylight;
    air.below = rules::sceneFromCodes(226, 225, 222) * daylight;
    air.near = rules::sceneFromCodes(186, 204, 220) * daylight;
    if (camera.projection == Projection::Ortho) return air;
    air.horizonSine = std::clamp(reach.farSine, -0.5f, 0.0f);
    if (settings.options.hazeKm) {
        const auto range = static_cast<float>(*settings.options.hazeKm * 1000.0);
        air.extinction = range > 0 ? kVisual / range : 0.0f;
        return air;
    }
    // Clear air up to the terrain: a model seen from outside is not veiled at its near edge, and
    // its far edge keeps most of its contrast; from within a landscape the far edge keeps a third.
    const float outside = rules::smoothStep(0.05f, 0.45f, reach.nearest / reach.farthest);
    const float kept = 1.0f / 3.0f + outside * (0.88f - 1.0f / 3.0f);
    air.start = 0.9f * reach.nearest;
    air.extinction = -std::log(kept) / std::max(reach.farthest - air.start, 1e-3f);
    return air;
}

}  // namespace terray
