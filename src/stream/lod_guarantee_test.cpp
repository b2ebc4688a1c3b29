// SPDX-License-Identifier: Apache-2.0
// The guarantee of level of detail (docs/lod.md), judged by the oracle: every pixel's distance on
// the cut lies between the exact distances one tolerance below and above it, along the line to the
// vertical vanishing point. Pixels within a tolerance of a hole's rim are left out and counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/test_size.h"
#include "kernel/height.h"
#include "kernel/scalar/oracle.h"
#include "raster/synthetic.h"
#include "stream/cut.h"
#include "stream/test_source.h"
#include "view/ray_frame.h"

namespace terray {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Tally {
    int judged = 0, leftOut = 0, violations = 0;
    int coarse = 0;  ///< judged places that show a coarser mip
};

constexpr std::pair<int, int> kNeighbours[] = {{1, 0}, {-1, 0}, {0, 1},  {0, -1},
                                               {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};

/// A terrain, its exact surface, and the posts on the rims of its holes.
struct Subject {
    std::unique_ptr<ResidentTerrain> terrain;
    FrameCut finest;
    std::vector<std::pair<int64_t, int64_t>> rims;

    explicit Subject(const HeightSource& source)
        : terrain(test::built(source)), finest(finestCut(*terrain, kSurfaceBilinear)) {
        const TilingScheme& scheme = terrain->info().scheme;
        for (int64_t j = 0; j < scheme.rows; ++j) {
            for (int64_t i = 0; i < scheme.columns; ++i) {
                if (!valid(i, j)) continue;
                const bool rim = std::any_of(
                    std::begin(kNeighbours), std::end(kNeighbours), [&](const auto& step) {
                        const int64_t x = i + step.first, y = j + step.second;
                        return inside(x, y) && !valid(x, y);
                    });
                if (rim) rims.emplace_back(i, j);
            }
        }
    }
    bool inside(int64_t i, int64_t j) const {
        const TilingScheme& scheme = terrain->info().scheme;
        return i >= 0 && j >= 0 && i < scheme.columns && j < scheme.rows;
    }
    bool valid(int64_t i, int64_t j) const { return inside(i, j) && !std::isnan(at(i, j)); }
    float at(int64_t i, int64_t j) const {
        const TilingScheme& scheme = terrain->info().scheme;
        const int x = std::min(static_cast<int>(i / 512), scheme.tilesX(0) - 1);
        const int y = std::min(static_cast<int>(j / 512), scheme.tilesY(0) - 1);
        return postHeight(finest.cut(), finest.cut().tiles[terrain->slotOf({0, x, y})],
                          static_cast<int>(i - x * 512), static_cast<int>(j - y * 512));
    }
};

/// One picture of a subject.
class Judge {
public:
    Judge(const Subject& subject, const RayFrame& rays, double tolerancePx)
        : terrain_(subject),
          rays_(rays),
          tolerance_(tolerancePx),
          rims_(static_cast<size_t>(rays.camera().width * rays.camera().height), 0) {
        markRims();
    }

    Tally judge(const TerrainCut& cut, int count, uint32_t seed, double tolerancePx) const {
        const Camera& camera = rays_.camera();
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> x(0, camera.width), y(0, camera.height);
        Tally tally;
        for (int k = 0; k < count; ++k) {
            const double px = x(random), py = y(random);
            const oracle::ExactHit seen = oracle::firstHit(cut, rays_.rayThrough(px, py));
            // All places that show a coarser mip, and a share of the others.
            if ((isHit(seen.hit) && seen.hit.mip > 0) || k % 6 == 0) {
                judgePlace(cut, px, py, tolerancePx, tally);
            }
        }
        return tally;
    }

private:
    void judgePlace(const TerrainCut& cut, double px, double py, double tolerancePx,
                    Tally& tally) const {
        const Vec3 direction = rays_.camera().rayThrough(px, py).direction;
        const Vec2 heading = glm::normalize(Vec2{direction.x, direction.y});
        // Up in the vertical plane of the ray: its image points to the vertical vanishing point.
        const Vec3 up = glm::normalize(Vec3{0, 0, 1} - direction.z * direction);
        const Vec2 line = imageStep(px, py, direction, up);
        const Vec2 below{px - tolerancePx * line.x, py - tolerancePx * line.y};
        const Vec2 above{px + tolerancePx * line.x, py + tolerancePx * line.y};
        const bool acrossNadir = !sameWay(below, heading) || !sameWay(above, heading);
        if (acrossNadir || nearRim(px, py)) {
            ++tally.leftOut;
            return;
        }
        bool coarse = false;
        const double drawn = distance(cut, px, py, heading, coarse);
        bool ignored = false;
        const double least = distance(terrain_.finest.cut(), below.x, below.y, heading, ignored);
        const double most = distance(terrain_.finest.cut(), above.x, above.y, heading, ignored);
        const double slack = 1e-6 * (1 + std::abs(drawn));
        ++tally.judged;
        if (coarse) ++tally.coarse;
        if (drawn < least - slack || drawn > most + slack) ++tally.violations;
    }

    Vec2 imageStep(double px, double py, const Vec3& direction, const Vec3& up) const {
        const Camera& camera = rays_.camera();
        if (camera.projection == Projection::Panorama) return {0, -1};
        if (camera.projection == Projection::Ortho) {
            return glm::normalize(Vec2{camera.right.z, -camera.up.z});
        }
        const Vec3 there = *camera.project(camera.eye + (direction + 1e-6 * up));
        return glm::normalize(Vec2{there.x - px, there.y - py});
    }

    bool sameWay(Vec2 place, Vec2 heading) const {
        const Vec3 direction = rays_.camera().rayThrough(place.x, place.y).direction;
        return direction.x * heading.x + direction.y * heading.y > 0;
    }

    /// Metres along the heading from the eye's plumb line to the first hit.
    double distance(const TerrainCut& cut, double px, double py, Vec2 heading, bool& coarse) const {
        const Ray ray = rays_.rayThrough(px, py);
        const oracle::ExactHit exact = oracle::firstHit(cut, ray);
        if (!isHit(exact.hit)) return kInfinity;
        coarse = exact.hit.mip > 0;
        const WorldPoint place = rays_.pointAt(ray, exact.t), eye = rays_.camera().eye;
        return (place.x - eye.x) * heading.x + (place.y - eye.y) * heading.y;
    }

    bool nearRim(double px, double py) const {
        const Camera& camera = rays_.camera();
        const int x = std::clamp(static_cast<int>(px), 0, camera.width - 1);
        const int y = std::clamp(static_cast<int>(py), 0, camera.height - 1);
        return rims_[static_cast<size_t>(y * camera.width + x)] != 0;
    }

    /// Marks the pixels within a tolerance of the image of a rim.
    void markRims() {
        for (const auto& [i, j] : terrain_.rims) {
            for (const auto& [dx, dy] : kNeighbours) {
                if (terrain_.valid(i + dx, j + dy)) markEdge(i, j, i + dx, j + dy);
            }
        }
    }

    void markEdge(int64_t i0, int64_t j0, int64_t i1, int64_t j1) {
        const Affine2& map = rays_.worldFromLattice();
        const auto ends = [&](int64_t i, int64_t j) {
            const Vec2 ground = map.worldFromLattice({double(i), double(j)});
            const WorldPoint& eye = rays_.camera().eye;
            const double x = ground.x - eye.x, y = ground.y - eye.y;
            const double drop = rays_.bend() * (x * x + y * y);
            return WorldPoint{
                ground.x, ground.y,
                rays_.exaggeration() * (static_cast<double>(terrain_.at(i, j)) - drop)};
        };
        const WorldPoint from = ends(i0, j0), to = ends(i1, j1);
        const auto a = rays_.camera().project(from), b = rays_.camera().project(to);
        if (!a || !b || passesBy(a->x, b->x, rays_.camera().width) ||
            passesBy(a->y, b->y, rays_.camera().height)) {
            return;
        }
        const double length = std::hypot(b->x - a->x, b->y - a->y);
        const int steps = std::clamp(static_cast<int>(length) + 1, 1, 2000);
        for (int s = 0; s <= steps; ++s) {
            if (const auto p = rays_.camera().project(from + (double(s) / steps) * (to - from))) {
                markDisc(p->x, p->y);
            }
        }
    }

    /// Both ends lie on one side of the picture, far from it.
    static bool passesBy(double a, double b, int size) {
        constexpr double kMargin = 100;
        return std::max(a, b) < -kMargin || std::min(a, b) > size + kMargin;
    }

    /// Once a pixel: the disc covers those around every place in it.
    void markDisc(double px, double py) {
        const Camera& camera = rays_.camera();
        const double radius = tolerance_ + 2;
        if (!(std::abs(px) < 1e6 && std::abs(py) < 1e6)) return;
        const double atX = std::floor(px), atY = std::floor(py);
        const bool inPicture = atX >= 0 && atY >= 0 && atX < camera.width && atY < camera.height;
        if (inPicture) {
            uint8_t& mark = rims_[static_cast<size_t>(atY * camera.width + atX)];
            if (mark == kCentre) return;
            mark = kCentre;
        }
        const int x0 = std::max(0, static_cast<int>(atX - radius));
        const int y0 = std::max(0, static_cast<int>(atY - radius));
        for (int y = y0; y <= std::min(camera.height - 1.0, atY + radius); ++y) {
            for (int x = x0; x <= std::min(camera.width - 1.0, atX + radius); ++x) {
                uint8_t& mark = rims_[static_cast<size_t>(y * camera.width + x)];
                mark = std::max(mark, kNear);
            }
        }
    }

    static constexpr uint8_t kNear = 1, kCentre = 2;

    const Subject& terrain_;
    const RayFrame& rays_;
    double tolerance_;
    std::vector<uint8_t> rims_;
};

Camera turned(double heading, double pitch, double roll) {
    Camera camera;
    camera.forward = {std::sin(heading) * std::cos(pitch), std::cos(heading) * std::cos(pitch),
                      std::sin(pitch)};
    const Vec3 right{std::cos(heading), -std::sin(heading), 0};
    const Vec3 up = glm::cross(right, camera.forward);
    camera.right = std::cos(roll) * right - std::sin(roll) * up;
    camera.up = std::cos(roll) * up + std::sin(roll) * right;
    camera.heading = heading;
    camera.pitch = pitch;
    return camera;
}

Camera randomCamera(const Subject& subject, Projection projection, double exaggeration,
                    std::mt19937& random) {
    const auto pick = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const TerrainInfo& info = subject.terrain->info();
    const bool panorama = projection == Projection::Panorama;
    const bool ortho = projection == Projection::Ortho;
    const double highest = panorama ? 0.1 : ortho ? -0.6 : 0.0;
    Camera camera = turned(pick(-kPi, kPi), pick(panorama ? -0.2 : -1.4, highest),
                           panorama ? 0 : pick(-0.5, 0.5));
    // Orthographic rays must enter the terrain's box from above: a ray that enters through its side
    // under the surface sees the sheet from below, which is no part of the guarantee.
    const double margin = ortho ? 0.4 : 0;
    const double i = pick(margin, 1 - margin) * double(info.scheme.columns - 1);
    const double j = pick(margin, 1 - margin) * double(info.scheme.rows - 1);
    const SurfaceCell ground = surfaceCellAt(subject.finest.cut(), i, j);
    const double z = (ground.slot == kNoSlot ? static_cast<double>(info.maxZ)
                                             : ground.height(kSurfaceBilinear)) +
                     std::exp(pick(0.7, 8.0));
    const Vec2 place = info.worldFromLattice.worldFromLattice({i, j});
    camera.projection = projection;
    camera.width = panorama ? 400 : 160;
    camera.height = 100;
    camera.tanHalfFovY = pick(0.2, 0.7);
    camera.eye = {place.x, place.y, exaggeration * z};
    const double across =
        pick(0.1, 0.3) * info.worldFromLattice.columnLength() * double(info.scheme.columns);
    camera.orthoSize = {across, across * camera.height / camera.width};
    if (ortho) camera.eye = camera.eye + (-1e5) * camera.forward;
    return camera;
}

struct Setting {
    double tolerancePx, exaggeration, bend;
};

Tally judgeTerrain(const Subject& subject, Projection projection, const Setting& setting,
                   uint32_t seed, double judgedTolerance) {
    std::mt19937 random(seed);
    Tally sum;
    for (int view = 0; view < 8 / test::kLess; ++view) {
        const Camera camera = randomCamera(subject, projection, setting.exaggeration, random);
        const RayFrame rays(camera, subject.terrain->info().worldFromLattice, setting.exaggeration,
                            setting.bend);
        CutOptions options;
        options.tolerancePx = setting.tolerancePx;
        options.exaggeration = setting.exaggeration;
        options.bend = rays.bend();
        const FrameCut frame = selectCut(*subject.terrain, camera, options);
        const Tally tally = Judge(subject, rays, setting.tolerancePx)
                                .judge(frame.cut(), 150, seed + 1, judgedTolerance);
        sum.judged += tally.judged;
        sum.leftOut += tally.leftOut;
        sum.violations += tally.violations;
        sum.coarse += tally.coarse;
    }
    return sum;
}

std::unique_ptr<HeightSource> fractal(uint32_t seed) {
    return makeFractal({.columns = 1900, .rows = 1500, .cell = 10, .seed = seed});
}
std::unique_ptr<HeightSource> town(uint32_t seed) {
    return makeTown(
        {.columns = 1500, .rows = 1500, .cell = 1, .seed = seed, .format = PostFormat::Int16});
}

std::unique_ptr<HeightSource> rolling(uint32_t seed) {
    return std::make_unique<test::ArraySource>(
        1700, 1500, PostFormat::Float32, [hills = test::hills(seed, true)](int64_t i, int64_t j) {
            const auto x = static_cast<float>(i), y = static_cast<float>(j);
            const float smooth = 300 + 250 * std::sin(x / 90) * std::cos(y / 70);
            return std::isnan(hills(i, j)) && (i > 200 || j > 200) ? test::kNaN : smooth;
        });
}

constexpr Setting kSettings[] = {{1.5, 1, 0}, {5, 1, 7e-8}, {8, 2.5, 0}, {20, 1, 1e-6}};

void expectSandwich(Projection projection, uint32_t seed) {
    Tally sum;
    for (const auto& source : {fractal(seed), town(seed), rolling(seed)}) {
        const Subject subject(*source);
        for (const Setting& setting : kSettings) {
            const Tally tally =
                judgeTerrain(subject, projection, setting, ++seed, setting.tolerancePx);
            EXPECT_EQ(tally.violations, 0)
                << "tolerance " << setting.tolerancePx << " seed " << seed;
            sum.judged += tally.judged;
            sum.leftOut += tally.leftOut;
            sum.coarse += tally.coarse;
        }
    }
    testing::Test::RecordProperty("judged", sum.judged);
    testing::Test::RecordProperty("left_out", sum.leftOut);
    // The test is worth nothing unless many places show coarser tiles.
    EXPECT_GT(sum.coarse, sum.judged / 10) << "of " << sum.judged;
    EXPECT_LT(sum.leftOut, sum.judged) << "of " << sum.judged;
}

TEST(LodGuarantee, PerspectiveDistancesAreSandwiched) {
    expectSandwich(Projection::Perspective, 100);
}

TEST(LodGuarantee, PanoramaDistancesAreSandwiched) { expectSandwich(Projection::Panorama, 200); }

TEST(LodGuarantee, OrthoDistancesAreSandwiched) { expectSandwich(Projection::Ortho, 300); }

TEST(LodGuarantee, TheJudgeFindsErrorsBeyondTheTolerance) {
    // The same kind of cut, judged against a hundredth of its tolerance.
    const Tally tally = judgeTerrain(Subject(*fractal(7)), Projection::Ortho, {20, 1, 0}, 7, 0.2);
    EXPECT_GT(tally.violations, tally.judged / 50) << "of " << tally.judged;
}

}  // namespace
}  // namespace terray
