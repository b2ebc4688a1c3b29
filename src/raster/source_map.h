// SPDX-License-Identifier: Apache-2.0
// The map from lattice posts to raster samples, exact at the corners of small rectangles and
// bilinear inside them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geo/frame.h"
#include "raster/warp.h"

namespace terray {

/// A rectangle of posts inside which the map is bilinear to within 0.01 sample. The corners are the
/// samples' places (in samples) of posts (column, row) and (column + span, row + span).
struct MapPatch {
    int64_t column = 0, row = 0;  ///< of the first corner
    int span = 1;
    std::array<Vec2, 4> corners{};  ///< (0, 0), (span, 0), (0, span), (span, span)

    /// Places along row j: `start` at the first column, `step` from post to post.
    struct Row {
        Vec2 start, step;
    };
    Row rowPlaces(int64_t j) const {
        const double scale = 1.0 / span;
        const double v = static_cast<double>(j - row) * scale;
        const Vec2 start = corners[0] + v * (corners[2] - corners[0]);
        const Vec2 end = corners[1] + v * (corners[3] - corners[1]);
        return {start, scale * (end - start)};
    }
    Vec2 place(int64_t i, int64_t j) const {
        const Row places = rowPlaces(j);
        return places.start + static_cast<double>(i - column) * places.step;
    }
};

/// confined, as its frame is.
class SourceMap {
public:
    static Result<SourceMap> make(const WarpPlan& plan);

    /// Place of a post in samples; NaN where the projection has no answer.
    Vec2 exactPlace(int64_t i, int64_t j) const;
    /// Patches whose posts (column .. column + span - 1, row ...) cover a window of posts. They are
    /// cut at fixed posts, so that the same post gets the same place from every window.
    void patches(int64_t column, int64_t row, int64_t width, int64_t height,
                 std::vector<MapPatch>& out) const;

private:
    SourceMap(const WarpPlan& plan, GeoFrame frame);
    void addPatch(const MapPatch& patch, const std::array<Vec2, 5>& middles,
                  std::vector<MapPatch>& out) const;
    void split(const MapPatch& patch, std::vector<MapPatch>& out) const;

    Affine2 dataFromSample_, worldFromLattice_;
    GeoFrame frame_;
};

}  // namespace terray
