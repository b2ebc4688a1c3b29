// SPDX-License-Identifier: Apache-2.0
// Ground at batches of hits: cells fetched from their tiles, then ray differentials on the tangent
// plane, and normals filtered to what they cover.
#include "shade/ground.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/assert.h"
#include "base/simd_clones.h"
#include "kernel/height.h"
#include "shade/rules/footprint.h"
#include "shade/rules/lines.h"

namespace terray {
namespace {

/// What is read of tiles, before any arithmetic.
struct Fetched {
    Ints tileX, tileY;
    Ints post;              ///< of the cell's first post in its tile
    Lanes<uint64_t> codes;  ///< of the four posts, from the low end
};

TERRAY_SIMD_CLONES
void placeCells(const HitBatch& h, Fetched& f, CellBatch& c) {
    for (int k = 0; k < kBatch; ++k) {
        const int32_t column = h.cell[k] & (kSlotCells - 1), row = h.cell[k] >> kTileLevels;
        c.x[k] = f.tileX[k] + (column << h.mip[k]);
        c.y[k] = f.tileY[k] + (row << h.mip[k]);
        c.size[k] = std::bit_cast<float>((127 + h.mip[k]) << 23);
        c.perSize[k] = std::bit_cast<float>((127 - h.mip[k]) << 23);
        f.post[k] = row * kPostStride + column;
    }
}

TERRAY_SIMD_CLONES
void splitCodes(const Fetched& f, CellBatch& c) {
    for (int k = 0; k < kBatch; ++k) {
        const auto top = static_cast<int32_t>(f.codes[k]);
        const auto bottom = static_cast<int32_t>(f.codes[k] >> 32);
        c.h00[k] = static_cast<float>(top & 0xFFFF);
        c.h10[k] = static_cast<float>((top >> 16) & 0xFFFF);
        c.h01[k] = static_cast<float>(bottom & 0xFFFF);
        c.h11[k] = static_cast<float>((bottom >> 16) & 0xFFFF);
    }
}

/// The posts of lanes [begin, end), whose tile's begin at `tile`.
void fetchPosts(const uint16_t* tile, int begin, int end, Fetched& f, CellBatch&) {
    for (int k = begin; k < end; ++k) {
        const uint16_t* codes = tile + f.post[k];
        f.codes[k] = fourCodes(codes, codes + kPostStride);
    }
}
void fetchPosts(const float* tile, int begin, int end, Fetched& f, CellBatch& c) {
    for (int k = begin; k < end; ++k) {
        const float* posts = tile + f.post[k];
        c.h00[k] = posts[0];
        c.h10[k] = posts[1];
        c.h01[k] = posts[kPostStride];
        c.h11[k] = posts[kPostStride + 1];
    }
}

template <class Post>
void fetchCells(const TerrainCut& cut, const HitBatch& h, CellBatch& c) {
    constexpr bool kCodes = sizeof(Post) == 2;
    const auto* pool = static_cast<const Post*>(cut.posts);
    const auto tileOf = [&](int k) -> const TileDesc& {
        return cut.tiles[static_cast<uint32_t>(h.tile[k])];
    };
    Fetched f;
    const int groups = h.alike ? 1 : kBatch, lanes = kBatch / groups;
    for (int group = 0; group < groups; ++group) {
        const TileDesc& tile = tileOf(group);
        const int begin = group * lanes;
        std::fill_n(f.tileX.at + begin, lanes, tile.x);
        std::fill_n(f.tileY.at + begin, lanes, tile.y);
        std::fill_n(c.z0.at + begin, lanes, kCodes ? tile.z0 : 0.0f);
        std::fill_n(c.zStep.at + begin, lanes, kCodes ? tile.zStep : 1.0f);
    }
    placeCells(h, f, c);
    for (int group = 0; group < groups; ++group)
        fetchPosts(pool + tileOf(group).posts, group * lanes, (group + 1) * lanes, f, c);
    if (kCodes) splitCodes(f, c);
}

/// The directions of a perspective (or, with steps of 0, ortho) camera.
struct Lens {
    float forward[3], right[3], up[3];  ///< of a pixel
    float perPixel;
};

TERRAY_SIMD_CLONES
void castView(const Lens& lens, ViewBatch& view) {
    for (int k = 0; k < kBatch; ++k) {
        const float a = view.fromCentreX[k], b = view.fromCentreY[k];
        const float x = lens.forward[0] + lens.right[0] * a + lens.up[0] * b;
        const float y = lens.forward[1] + lens.right[1] * a + lens.up[1] * b;
        const float z = lens.forward[2] + lens.right[2] * a + lens.up[2] * b;
        const float perUnit = 1.0f / std::sqrt(x * x + y * y + z * z);
        view.direction.x[k] = x * perUnit;
        view.direction.y[k] = y * perUnit;
        view.direction.z[k] = z * perUnit;
        view.step[k] = lens.perPixel * perUnit;
    }
}

/// What the loops below read of a sampler.
struct Sampler {
    float xi, xj, yi, yj;  ///< world from lattice gradients
    float exaggeration, share, perCellArea;
    float fixedArea;  ///< ortho: of a pixel; else 0
};

/// Place, height and footprint; `lattice` becomes the gradient of the drawn cell per mip-0 cell.
TERRAY_SIMD_CLONES
void place(const Sampler& s, const HitBatch& h, const CellBatch& c, const ViewBatch& view,
           GroundBatch& g, Floats2& lattice) {
    for (int k = 0; k < kBatch; ++k) {
        const float u = h.u[k], v = h.v[k];
        g.place.x[k] = c.x[k];
        g.place.y[k] = c.y[k];
        g.place.dx[k] = u * c.size[k];
        g.place.dy[k] = v * c.size[k];
        g.distance[k] = h.t[k];
        const float h00 = c.h00[k], h10 = c.h10[k], h01 = c.h01[k], h11 = c.h11[k];
        const float upper = h00 * (1 - u) + h10 * u, lower = h01 * (1 - u) + h11 * u;
        g.height[k] = c.z0[k] + c.zStep[k] * (upper * (1 - v) + lower * v);
        const float perCell = c.zStep[k] * c.perSize[k];
        lattice.x[k] = perCell * ((h10 - h00) * (1 - v) + (h11 - h01) * v);
        lattice.y[k] = perCell * ((h01 - h00) * (1 - u) + (h11 - h10) * u);
        const float planeX = s.exaggeration * (s.xi * lattice.x[k] + s.xj * lattice.y[k]);
        const float planeY = s.exaggeration * (s.yi * lattice.x[k] + s.yj * lattice.y[k]);
        const float step = h.t[k] * view.step[k];
        g.footprint[k] =
            rules::footprint(s.fixedArea + step * step, view.direction.x[k], view.direction.y[k],
                             view.direction.z[k], planeX, planeY, s.share, s.perCellArea);
    }
}

TERRAY_SIMD_CLONES
void orient(const Sampler& s, const Floats2& lattice, GroundBatch& g) {
    for (int k = 0; k < kBatch; ++k) {
        const float x = s.xi * lattice.x[k] + s.xj * lattice.y[k];
        const float y = s.yi * lattice.x[k] + s.yj * lattice.y[k];
        const float nx = -s.exaggeration * x, ny = -s.exaggeration * y;
        const float perLength = 1.0f / std::sqrt(nx * nx + ny * ny + 1.0f);
        g.gradient.x[k] = x;
        g.gradient.y[k] = y;
        g.normal.x[k] = nx * perLength;
        g.normal.y[k] = ny * perLength;
        g.normal.z[k] = perLength;
    }
}

/// Moves of the pixel, along the ray onto the tangent plane.
TERRAY_SIMD_CLONES
void stand(const Sampler& s, const ViewBatch& view, const Floats3& right, const Floats3& down,
           GroundBatch& g) {
    for (int k = 0; k < kBatch; ++k) {
        const float nx = g.normal.x[k], ny = g.normal.y[k], nz = g.normal.z[k];
        const float dx = view.direction.x[k], dy = view.direction.y[k], dz = view.direction.z[k];
        const float step = s.fixedArea > 0 ? 1.0f : g.distance[k] * view.step[k];
        const float scale = step / rules::keptFacing(nx * dx + ny * dy + nz * dz);
        const float a = scale * (nx * right.x[k] + ny * right.y[k] + nz * right.z[k]);
        const float b = scale * (nx * down.x[k] + ny * down.y[k] + nz * down.z[k]);
        g.footX.x[k] = step * right.x[k] - dx * a;
        g.footX.y[k] = step * right.y[k] - dy * a;
        g.footY.x[k] = step * down.x[k] - dx * b;
        g.footY.y[k] = step * down.y[k] - dy * b;
    }
}

}  // namespace

void ViewBatch::setPixels(const Camera& camera, const ImageTile& tile, Vec2 offset, size_t first) {
    const auto width = static_cast<size_t>(tile.width), last = tile.pixelCount() - 1;
    const auto left = static_cast<float>(tile.x + offset.x - 0.5 * camera.width);
    const auto top = static_cast<float>(0.5 * camera.height - (tile.y + offset.y));
    size_t x = first % width, y = first / width;
    if (x + kBatch <= width) {
        for (int k = 0; k < kBatch; ++k) {
            fromCentreX[k] = left + static_cast<float>(static_cast<int>(x) + k);
            fromCentreY[k] = top - static_cast<float>(y);
        }
        return;
    }
    for (int k = 0; k < kBatch; ++k) {
        fromCentreX[k] = left + static_cast<float>(x);
        fromCentreY[k] = top - static_cast<float>(y);
        if (first + static_cast<size_t>(k) < last && ++x == width) x = 0, ++y;
    }
}

CellPosts cellPosts(const TerrainCut& cut, const Hit& hit) {
    const TileDesc& tile = cut.tiles[hit.tile];
    const int x = static_cast<int>(cellX(hit)), y = static_cast<int>(cellY(hit));
    return {postHeight(cut, tile, x, y), postHeight(cut, tile, x + 1, y),
            postHeight(cut, tile, x, y + 1), postHeight(cut, tile, x + 1, y + 1)};
}

GroundSampler::GroundSampler(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays,
                             float footprintShare, bool withFeet)
    : cut_(cut),
      rays_(rays),
      camera_(rays.camera()),
      filtered_(cut, info.scheme),
      footprintShare_(footprintShare),
      exaggeration_(static_cast<float>(rays.exaggeration())),
      withFeet_(withFeet),
      right_(camera_.right),
      up_(camera_.up),
      forward_(camera_.forward) {
    const Vec2 perI = info.worldFromLattice.worldGradient(1, 0);
    const Vec2 perJ = info.worldFromLattice.worldGradient(0, 1);
    gradientXi_ = static_cast<float>(perI.x), gradientYi_ = static_cast<float>(perI.y);
    gradientXj_ = static_cast<float>(perJ.x), gradientYj_ = static_cast<float>(perJ.y);
    perCellArea_ = static_cast<float>(1.0 / std::abs(info.worldFromLattice.det()));
    if (camera_.projection == Projection::Ortho) {
        perPixelX_ = static_cast<float>(camera_.orthoSize.x / camera_.width);
        perPixelY_ = static_cast<float>(camera_.orthoSize.y / camera_.height);
    } else {
        perPixelX_ = perPixelY_ = static_cast<float>(1.0 / camera_.focalPixels());
    }
}

void GroundSampler::lookThrough(ViewBatch& view) const {
    if (camera_.projection == Projection::Panorama) {
        for (int k = 0; k < kBatch; ++k) {
            const float azimuth =
                static_cast<float>(camera_.heading) + view.fromCentreX[k] * perPixelX_;
            const float rise =
                static_cast<float>(std::tan(camera_.pitch)) + view.fromCentreY[k] * perPixelY_;
            const float perUnit = 1.0f / std::sqrt(1.0f + rise * rise);
            view.direction.x[k] = std::sin(azimuth) * perUnit;
            view.direction.y[k] = std::cos(azimuth) * perUnit;
            view.direction.z[k] = rise * perUnit;
            view.step[k] = perPixelX_ * perUnit;
        }
        return;
    }
    const bool ortho = camera_.projection == Projection::Ortho;
    const glm::vec3 right = ortho ? glm::vec3{0} : right_ * perPixelX_;
    const glm::vec3 up = ortho ? glm::vec3{0} : up_ * perPixelY_;
    castView({{forward_.x, forward_.y, forward_.z},
              {right.x, right.y, right.z},
              {up.x, up.y, up.z},
              ortho ? 0.0f : perPixelX_},
             view);
}

glm::vec3 GroundSampler::viewAt(double px, double py) const {
    const WorldRay ray = camera_.rayThrough(px, py);
    return glm::vec3(ray.direction);
}

/// Constant cells are blocks with flat tops and upright walls, as far as they can be told apart:
/// where a sample covers more than one, their mean slope shows.
void GroundSampler::asBlock(const HitBatch& hits, const ViewBatch& view, const CellBatch& cells,
                            int k, GroundBatch& ground) const {
    const Hit hit = hits.hit(k);
    const bool wall = (hit.flags & kHitStrip) != 0;
    const float upper = hit.u < 0.5f ? cells.h00[k] : cells.h10[k];
    const float lower = hit.u < 0.5f ? cells.h01[k] : cells.h11[k];
    ground.height[k] = cells.z0[k] + cells.zStep[k] * (hit.v < 0.5f ? upper : lower);
    if (wall) {
        const Ray ray =
            rays_.rayThrough(static_cast<double>(view.fromCentreX[k]) + 0.5 * camera_.width,
                             0.5 * camera_.height - static_cast<double>(view.fromCentreY[k]));
        ground.height[k] = static_cast<float>(RayFrame::heightAt(ray, static_cast<double>(hit.t)));
    }
    const float mean = rules::smoothStep(0.5f, 1.5f, ground.footprint[k] / cells.size[k]);
    const Vec3 towards{view.direction.x[k], view.direction.y[k], view.direction.z[k]};
    const glm::vec3 own = wall ? glm::vec3(rays_.wallNormal(hit, towards)) : glm::vec3{0, 0, 1};
    const glm::vec3 smooth{ground.normal.x[k], ground.normal.y[k], ground.normal.z[k]};
    const glm::vec3 normal = glm::normalize(glm::mix(own, smooth, mean));
    ground.gradient.x[k] *= mean;
    ground.gradient.y[k] *= mean;
    ground.normal.x[k] = normal.x;
    ground.normal.y[k] = normal.y;
    ground.normal.z[k] = normal.z;
}

void GroundSampler::at(const HitBatch& hits, const ViewBatch& view, GroundBatch& ground) const {
    TERRAY_ASSERT(hits.some);
    CellBatch cells;
    Floats2 lattice;
    if (cut_.format == 0)
        fetchCells<uint16_t>(cut_, hits, cells);
    else
        fetchCells<float>(cut_, hits, cells);
    const bool ortho = camera_.projection == Projection::Ortho;
    const Sampler sampler{
        gradientXi_,   gradientXj_,     gradientYi_,  gradientYj_,
        exaggeration_, footprintShare_, perCellArea_, ortho ? perPixelX_ * perPixelY_ : 0.0f};
    place(sampler, hits, cells, view, ground, lattice);
    filtered_.at(ground.place, ground.footprint, lattice);
    orient(sampler, lattice, ground);
    if (cut_.surface == kSurfaceConstant)
        for (int k = 0; k < kBatch; ++k) asBlock(hits, view, cells, k, ground);
    if (!withFeet_) return;
    Floats3 right, down;
    const float scaleX = ortho ? perPixelX_ : 1.0f, scaleY = ortho ? perPixelY_ : 1.0f;
    for (int k = 0; k < kBatch; ++k) {
        glm::vec3 r = right_ * scaleX, d = up_ * -scaleY;
        if (camera_.projection == Projection::Panorama) {
            const float x = view.direction.x[k], y = view.direction.y[k];
            r = glm::vec3{y, -x, 0} / std::sqrt(x * x + y * y);
            d = {0, 0, -1};
        }
        right.x[k] = r.x, right.y[k] = r.y, right.z[k] = r.z;
        down.x[k] = d.x, down.y[k] = d.y, down.z[k] = d.z;
    }
    stand(sampler, view, right, down, ground);
}

}  // namespace terray
