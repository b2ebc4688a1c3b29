// SPDX-License-Identifier: Apache-2.0
// Maps footprints into a photo and mixes its colours with the ground's.
#include "shade/photo_map.h"

#include <algorithm>
#include <array>

#include "base/simd_clones.h"
#include "shade/rules/colour.h"

namespace terray {
namespace {

/// Scene value that displays as a photo's linear value: rules::sceneFromDisplay by table.
struct SceneTable {
    static constexpr int kLast = 1024;
    std::array<float, kLast + 2> scene{};
    SceneTable() {
        for (int k = 0; k <= kLast + 1; ++k)
            scene[static_cast<size_t>(k)] =
                rules::sceneFromDisplay(static_cast<float>(std::min(k, kLast)) / kLast);
    }
};
const SceneTable kScene;

struct PixelMap {
    double x0, xi, xj, y0, yi, yj;
    float xEast, xNorth, yEast, yNorth;
};

TERRAY_SIMD_CLONES
void placeFeet(const PixelMap& m, const GroundBatch& g, PhotoFeet& feet) {
    for (int k = 0; k < kBatch; ++k) {
        feet.x[k] = m.x0 + m.xi * g.place.i(k) + m.xj * g.place.j(k);
        feet.y[k] = m.y0 + m.yi * g.place.i(k) + m.yj * g.place.j(k);
    }
    for (int k = 0; k < kBatch; ++k) {
        feet.a.x[k] = m.xEast * g.footX.x[k] + m.xNorth * g.footX.y[k];
        feet.a.y[k] = m.yEast * g.footX.x[k] + m.yNorth * g.footX.y[k];
        feet.b.x[k] = m.xEast * g.footY.x[k] + m.xNorth * g.footY.y[k];
        feet.b.y[k] = m.yEast * g.footY.x[k] + m.yNorth * g.footY.y[k];
    }
}

TERRAY_SIMD_CLONES
void locateScene(const Floats& colour, const Floats& cover, Ints& entry, Floats& part) {
    for (int k = 0; k < kBatch; ++k) {
        const float shown = cover[k] > 0.0f ? colour[k] / cover[k] : 0.0f;
        const float x = (shown < 1.0f ? shown : 1.0f) * SceneTable::kLast;
        entry[k] = static_cast<int32_t>(x);
        part[k] = x - static_cast<float>(entry[k]);
    }
}

TERRAY_SIMD_CLONES
void mixPhoto(const Floats& low, const Floats& high, const Floats& part, const Floats& cover,
              float relief, Floats& own, Floats& albedo) {
    for (int k = 0; k < kBatch; ++k) {
        const float scene = (low[k] + part[k] * (high[k] - low[k])) * cover[k];
        const float bare = 1.0f - cover[k] > 0.002f ? 1.0f - cover[k] : 0.0f;
        own[k] = scene * (1.0f - relief);
        albedo[k] = albedo[k] * bare + scene * relief;
    }
}

}  // namespace

PhotoMap::PhotoMap(const Affine2& worldFromLattice, const Affine2& worldFromPixel, double share) {
    const LatticePoint origin = worldFromPixel.latticeFromWorld(worldFromLattice.origin);
    const LatticePoint i = worldFromPixel.latticeDirection(worldFromLattice.column);
    const LatticePoint j = worldFromPixel.latticeDirection(worldFromLattice.row);
    const LatticePoint east = worldFromPixel.latticeDirection({share, 0});
    const LatticePoint north = worldFromPixel.latticeDirection({0, share});
    x0_ = origin.i, xi_ = i.i, xj_ = j.i;
    y0_ = origin.j, yi_ = i.j, yj_ = j.j;
    xEast_ = static_cast<float>(east.i), xNorth_ = static_cast<float>(north.i);
    yEast_ = static_cast<float>(east.j), yNorth_ = static_cast<float>(north.j);
}

void PhotoMap::place(const GroundBatch& ground, PhotoFeet& feet) const {
    placeFeet({x0_, xi_, xj_, y0_, yi_, yj_, xEast_, xNorth_, yEast_, yNorth_}, ground, feet);
}

void showPhoto(const PhotoBatch& photo, float relief, FloatsRgb& own, FloatsRgb& albedo) {
    const auto channel = [&](const Floats& colour, Floats& ownOut, Floats& albedoOut) {
        Ints entry;
        Floats part, low, high;
        locateScene(colour, photo.cover, entry, part);
        for (int k = 0; k < kBatch; ++k) {
            const float* scene = &kScene.scene[static_cast<size_t>(entry[k])];
            low[k] = scene[0];
            high[k] = scene[1];
        }
        mixPhoto(low, high, part, photo.cover, relief, ownOut, albedoOut);
    };
    channel(photo.colour.r, own.r, albedo.r);
    channel(photo.colour.g, own.g, albedo.g);
    channel(photo.colour.b, own.b, albedo.b);
}

}  // namespace terray
