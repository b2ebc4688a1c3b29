// SPDX-License-Identifier: Apache-2.0
// Where the cameras stand: fractions of the terrain's extent, its lowest and highest places.
#include "cameras.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"
#include "kernel/height.h"
#include "stream/cut.h"

namespace terray::bench {
namespace {

/// Places and heights on mip 0 of a terrain.
class Ground {
public:
    explicit Ground(const ResidentTerrain& terrain)
        : info_(terrain.info()), cut_(finestCut(terrain, kSurfaceBilinear)) {}

    /// A place at fractions of the lattice, or the ground nearest to it, in rings around.
    WorldPoint onGround(double fractionX, double fractionY) const {
        constexpr int kRings = 64;
        for (int ring = 0; ring <= kRings; ++ring)
            for (int k = 0; k < std::max(8 * ring, 1); ++k) {
                const double angle = radFromDeg(360.0 * k / std::max(8 * ring, 1));
                const double x = fractionX + 0.5 * ring / kRings * std::cos(angle);
                const double y = fractionY + 0.5 * ring / kRings * std::sin(angle);
                if (std::min(x, y) < 0 || std::max(x, y) > 1) continue;
                if (!isHole(x, y)) return at(x, y);
            }
        return at(fractionX, fractionY);
    }
    /// A place at fractions of the lattice; z = ground, or the highest height in a hole.
    WorldPoint at(double fractionX, double fractionY) const {
        const double i = fractionX * cut_.cut().cellsX, j = fractionY * cut_.cut().cellsY;
        const Vec2 place = info_.worldFromLattice.worldFromLattice({i, j});
        const SurfaceCell cell = surfaceCellAt(cut_.cut(), i, j);
        const double z =
            cell.slot == kNoSlot ? static_cast<double>(info_.maxZ) : cell.height(kSurfaceBilinear);
        return {place.x, place.y, z};
    }
    /// The lowest (sign -1) or highest (+1) of 257 x 257 places in the middle of the lattice.
    WorldPoint extreme(double sign) const {
        WorldPoint best = at(0.5, 0.5);
        for (int y = 0; y <= 256; ++y)
            for (int x = 0; x <= 256; ++x) {
                const WorldPoint p = at(0.2 + 0.6 * x / 256, 0.2 + 0.6 * y / 256);
                if (sign * p.z > sign * best.z) best = p;
            }
        return best;
    }
    SceneBox box() const {
        SceneBox box;
        box.min = box.max = at(0, 0);
        for (int corner = 1; corner < 4; ++corner) {
            const WorldPoint p = at(corner & 1, corner >> 1);
            box.min.x = std::min(box.min.x, p.x), box.max.x = std::max(box.max.x, p.x);
            box.min.y = std::min(box.min.y, p.y), box.max.y = std::max(box.max.y, p.y);
        }
        box.min.z = static_cast<double>(info_.minZ);
        box.max.z = static_cast<double>(info_.maxZ);
        return box;
    }

private:
    bool isHole(double fractionX, double fractionY) const {
        const double i = fractionX * cut_.cut().cellsX, j = fractionY * cut_.cut().cellsY;
        return surfaceCellAt(cut_.cut(), i, j).slot == kNoSlot;
    }
    const TerrainInfo& info_;
    FrameCut cut_;
};

/// Heading from one place to another, degrees clockwise from grid north.
double headingTo(const WorldPoint& from, const WorldPoint& to) {
    return degFromRad(std::atan2(to.x - from.x, to.y - from.y));
}

class Placer {
public:
    Placer(const ResidentTerrain& terrain, int width, int height)
        : ground_(terrain), box_(ground_.box()), width_(width), height_(height) {
        const double tanHalf = std::tan(radFromDeg(30)) * height / width;
        fovDeg_ = degFromRad(2 * std::atan(tanHalf));
    }

    const Ground& ground() const { return ground_; }
    const SceneBox& box() const { return box_; }
    View view(WorldPoint eye, double above, double heading, double pitch) const {
        View view;
        view.width = width_;
        view.height = height_;
        view.fovDeg = fovDeg_;
        view.eye = Place{eye.x, eye.y, eye.z + above, false};
        view.headingDeg = heading;
        view.pitchDeg = pitch;
        return view;
    }
    /// From beyond a corner of the terrain, slightly down to its middle.
    View outsideView(const WorldPoint& middle) const {
        const double extent = std::hypot(box_.max.x - box_.min.x, box_.max.y - box_.min.y);
        const WorldPoint eye{box_.min.x - 0.3 * extent, box_.min.y - 0.2 * extent, box_.max.z};
        return view(eye, 0.1 * extent, headingTo(eye, middle), -12);
    }
    void add(const std::string& name, const View& view) {
        auto camera = makeCamera(view, box_);
        TERRAY_ASSERT(camera.ok());
        if (camera) cameras_.push_back({name, view, *camera});
    }
    std::vector<NamedCamera> take() { return std::move(cameras_); }

private:
    Ground ground_;
    SceneBox box_;
    int width_, height_;
    double fovDeg_ = 0;
    std::vector<NamedCamera> cameras_;
};

}  // namespace

std::vector<NamedCamera> speedCameras(const ResidentTerrain& terrain, int width, int height) {
    Placer placer(terrain, width, height);
    const WorldPoint side = placer.ground().onGround(0.25, 0.75);
    const WorldPoint middle = placer.ground().onGround(0.5, 0.5);
    const WorldPoint low = placer.ground().extreme(-1), high = placer.ground().extreme(1);
    const double inwards = headingTo(side, middle);
    placer.add("low50", placer.view(side, 50, inwards, 0));
    placer.add("mid500", placer.view(side, 500, inwards, -15));
    placer.add("high3000", placer.view(side, 3000, inwards, -45));
    placer.add("down5000", placer.view(middle, 5000, 0, -90));
    placer.add("valley", placer.view(low, 10, headingTo(low, high), 3));
    placer.add("mountain", placer.view(high, 20, headingTo(high, middle), -2));
    return placer.take();
}

std::vector<NamedCamera> sideCameras(const ResidentTerrain& terrain, int width, int height) {
    Placer placer(terrain, width, height);
    const WorldPoint side = placer.ground().onGround(0.25, 0.75);
    const WorldPoint middle = placer.ground().onGround(0.5, 0.5);
    View rolled = placer.view(side, 500, headingTo(side, middle), -15);
    rolled.rollDeg = 30;
    placer.add("rolled", rolled);
    placer.add("outside", placer.outsideView(middle));
    return placer.take();
}

std::vector<std::string> speedCameraNames() {
    return {"low50", "mid500", "high3000", "down5000", "valley", "mountain"};
}

std::vector<NamedCamera> oddCameras(const ResidentTerrain& terrain, int width, int height) {
    Placer placer(terrain, width, height);
    const WorldPoint side = placer.ground().at(0.6, 0.3), middle = placer.ground().at(0.5, 0.5);
    const SceneBox& box = placer.box();
    View rolled = placer.view(side, 300, 200, -10);
    rolled.rollDeg = 37;
    placer.add("rolled", rolled);
    placer.add("up", placer.view(middle, -200, 0, 90));
    placer.add("outside", placer.outsideView(middle));
    placer.add("under", placer.view(side, -150, 120, 10));
    View panorama = placer.view(middle, 60, 0, -5);
    panorama.projection = Projection::Panorama;
    placer.add("panorama", panorama);
    View ortho = placer.view(middle, 0, 30, -50);
    ortho.projection = Projection::Ortho;
    ortho.extent = Extent{box.min.x, box.min.y, box.max.x, box.max.y};
    ortho.eye.reset();
    placer.add("ortho", ortho);
    return placer.take();
}

}  // namespace terray::bench
