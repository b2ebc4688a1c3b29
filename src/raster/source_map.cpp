// SPDX-License-Identifier: Apache-2.0
// SourceMap: exact transforms on a grid of posts, refined where the map is not bilinear enough.
#include "raster/source_map.h"

#include <cmath>
#include <limits>

namespace terray {
namespace {

constexpr int kSpan = 32;             // posts between the corners of a patch
constexpr int kHalf = kSpan / 2;      // posts between the exact places it is tested at
constexpr double kTolerance = 0.005;  // samples, at the tested places; half of what is promised

bool isBilinear(const MapPatch& patch, int64_t i, int64_t j, Vec2 exact) {
    const Vec2 error = patch.place(i, j) - exact;
    return std::abs(error.x) <= kTolerance && std::abs(error.y) <= kTolerance;
}

}  // namespace

SourceMap::SourceMap(const WarpPlan& plan, GeoFrame frame)
    : dataFromSample_(plan.dataFromSample),
      worldFromLattice_(plan.worldFromLattice),
      frame_(std::move(frame)) {}

Result<SourceMap> SourceMap::make(const WarpPlan& plan) {
    Result<GeoFrame> frame = plan.makeFrame();
    if (!frame) return frame.error();
    return SourceMap(plan, std::move(*frame));
}

Vec2 SourceMap::exactPlace(int64_t i, int64_t j) const {
    const Vec2 world =
        worldFromLattice_.worldFromLattice({static_cast<double>(i), static_cast<double>(j)});
    const Result<Vec2> data = frame_.dataFromWorld(world);
    if (!data) {
        constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
        return {kNowhere, kNowhere};
    }
    const LatticePoint place = dataFromSample_.latticeFromWorld(*data);
    return {place.i, place.j};
}

void SourceMap::split(const MapPatch& patch, std::vector<MapPatch>& out) const {
    const int half = patch.span / 2;
    for (int quarter = 0; quarter < 4; ++quarter) {
        MapPatch part{
            patch.column + (quarter % 2) * half, patch.row + (quarter / 2) * half, half, {}};
        if (half == 1) {  // its one post is its first corner: exact
            part.corners.fill(exactPlace(part.column, part.row));
            out.push_back(part);
            continue;
        }
        for (int corner = 0; corner < 4; ++corner) {
            part.corners[static_cast<size_t>(corner)] =
                exactPlace(part.column + (corner % 2) * half, part.row + (corner / 2) * half);
        }
        const int64_t i = part.column, j = part.row;
        const int q = half / 2;
        addPatch(part,
                 {exactPlace(i + q, j), exactPlace(i, j + q), exactPlace(i + q, j + q),
                  exactPlace(i + half, j + q), exactPlace(i + q, j + half)},
                 out);
    }
}

/// `middles`: exact places of the middles of the top, left, inside, right and bottom.
void SourceMap::addPatch(const MapPatch& patch, const std::array<Vec2, 5>& middles,
                         std::vector<MapPatch>& out) const {
    const int half = patch.span / 2;
    const int64_t i = patch.column, j = patch.row;
    if (isBilinear(patch, i + half, j, middles[0]) && isBilinear(patch, i, j + half, middles[1]) &&
        isBilinear(patch, i + half, j + half, middles[2]) &&
        isBilinear(patch, i + patch.span, j + half, middles[3]) &&
        isBilinear(patch, i + half, j + patch.span, middles[4])) {
        out.push_back(patch);
    } else {
        split(patch, out);
    }
}

void SourceMap::patches(int64_t column, int64_t row, int64_t width, int64_t height,
                        std::vector<MapPatch>& out) const {
    const int64_t firstX = column / kSpan, firstY = row / kSpan;
    const int64_t across = (column + width - 1) / kSpan - firstX + 1;
    const int64_t down = (row + height - 1) / kSpan - firstY + 1;
    const int64_t nodesAcross = 2 * across + 1;  // half a span apart
    std::vector<Vec2> nodes(static_cast<size_t>(nodesAcross * (2 * down + 1)));
    for (int64_t y = 0; y <= 2 * down; ++y) {
        for (int64_t x = 0; x < nodesAcross; ++x) {
            nodes[static_cast<size_t>(y * nodesAcross + x)] =
                exactPlace(firstX * kSpan + x * kHalf, firstY * kSpan + y * kHalf);
        }
    }
    const auto node = [&](int64_t x, int64_t y) {
        return nodes[static_cast<size_t>(y * nodesAcross + x)];
    };
    out.clear();
    for (int64_t y = 0; y < 2 * down; y += 2) {
        for (int64_t x = 0; x < 2 * across; x += 2) {
            const MapPatch patch{firstX * kSpan + x * kHalf,
                                 firstY * kSpan + y * kHalf,
                                 kSpan,
                                 {node(x, y), node(x + 2, y), node(x, y + 2), node(x + 2, y + 2)}};
            addPatch(patch,
                     {node(x + 1, y), node(x, y + 1), node(x + 1, y + 1), node(x + 2, y + 1),
                      node(x + 1, y + 2)},
                     out);
        }
    }
}

}  // namespace terray
