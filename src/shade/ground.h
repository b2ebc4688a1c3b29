// SPDX-License-Identifier: Apache-2.0
// What shading needs to know of the ground at hits: height, filtered normal, footprint of a pixel.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "shade/hit_batch.h"
#include "shade/normals.h"
#include "shade/shade.h"

namespace terray {

/// Rays through pixels: unit directions in picture space, and by how many metres their ends on the
/// ground move sideways for a pixel.
struct ViewBatch {
    Floats fromCentreX, fromCentreY;  ///< pixels, to the right and up
    Floats3 direction;
    Floats step;
    /// Positions of pixels from `first` on, row by row; those beyond the tile are its last pixel's.
    void setPixels(const Camera& camera, const ImageTile& tile, Vec2 offset, size_t first);
};

struct GroundBatch {
    Places place;
    Floats3 normal;    ///< unit, picture space, filtered to the footprint, upwards
    Floats2 gradient;  ///< true heights over world metres
    /// Ground covered a pixel to the right and down, world metres; only if the sampler was asked.
    Floats2 footX, footY;
    Floats height;     ///< true metres, of the drawn surface
    Floats distance;   ///< metres in picture space
    Floats footprint;  ///< width that a sample covers, mip-0 cells
};

/// Four posts of the drawn cell of a hit.
struct CellPosts {
    float h00, h10, h01, h11;
    glm::vec2 gradientAt(float u, float v) const {
        return {(h10 - h00) * (1 - v) + (h11 - h01) * v, (h01 - h00) * (1 - u) + (h11 - h10) * u};
    }
};
CellPosts cellPosts(const TerrainCut& cut, const Hit& hit);

/// Drawn cells of hits.
struct CellBatch {
    Ints x, y;             ///< first post, mip-0 cells
    Floats size, perSize;  ///< mip-0 cells a side, and 1 over that
    Floats h00, h10, h01, h11;
    Floats z0, zStep;  ///< height = z0 + zStep * h
};

/// const-shared.
class GroundSampler {
public:
    /// `footprintShare`: part of a pixel's width that one sample stands for. `withFeet`: fills
    /// footX and footY.
    GroundSampler(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays,
                  float footprintShare, bool withFeet);

    /// Directions of the rays through the pixels that are set in `view`.
    void lookThrough(ViewBatch& view) const;
    /// Ground at the hits of those rays, of which there are some.
    void at(const HitBatch& hits, const ViewBatch& view, GroundBatch& ground) const;
    /// Unit direction of the ray through a picture position.
    glm::vec3 viewAt(double px, double py) const;

private:
    void asBlock(const HitBatch& hits, const ViewBatch& view, const CellBatch& cells, int k,
                 GroundBatch& ground) const;

    const TerrainCut& cut_;
    const RayFrame& rays_;
    const Camera& camera_;
    FilteredGradient filtered_;
    float footprintShare_, exaggeration_;
    bool withFeet_;
    float gradientXi_, gradientXj_, gradientYi_, gradientYj_;  ///< world from lattice gradients
    float perCellArea_;  ///< 1 over the square metres of a mip-0 cell
    glm::vec3 right_, up_, forward_;
    float perPixelX_ = 0, perPixelY_ = 0;  ///< tangent (ortho: metres) a pixel
};

}  // namespace terray
