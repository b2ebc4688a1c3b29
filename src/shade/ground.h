// SPDX-License-Identifier: Apache-2.0
// What shading needs to know of the ground at a hit: height, filtered normal, footprint of a pixel.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "shade/normals.h"
#include "shade/shade.h"

namespace terray {

struct Ground {
    double i = 0, j = 0;        ///< lattice place
    glm::vec3 normal{0, 0, 1};  ///< picture space, filtered to the footprint, upwards
    glm::vec2 gradient{0, 0};   ///< true heights over world metres
    /// Ground covered a pixel to the right and down, world metres; only if the sampler was asked.
    glm::vec2 footX{0}, footY{0};
    float height = 0;     ///< true metres, of the drawn surface
    float distance = 0;   ///< metres in picture space
    float footprint = 0;  ///< width that a sample covers, mip-0 cells
    float slope() const { return glm::length(gradient); }
};

/// Four posts of the drawn cell of a hit.
struct CellPosts {
    float h00, h10, h01, h11;
    glm::vec2 gradientAt(float u, float v) const {
        return {(h10 - h00) * (1 - v) + (h11 - h01) * v, (h01 - h00) * (1 - u) + (h11 - h10) * u};
    }
    float heightAt(float u, float v) const {
        return (h00 * (1 - u) + h10 * u) * (1 - v) + (h01 * (1 - u) + h11 * u) * v;
    }
    float nearest(float u, float v) const {
        return v < 0.5f ? (u < 0.5f ? h00 : h10) : (u < 0.5f ? h01 : h11);
    }
};
CellPosts cellPosts(const TerrainCut& cut, const Hit& hit);

/// const-shared.
class GroundSampler {
public:
    /// `footprintShare`: part of a pixel's width that one sample stands for. `withFeet`: fills
    /// Ground::footX and footY.
    GroundSampler(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays,
                  float footprintShare, bool withFeet);

    /// Ground at a valid hit of the ray through a picture position.
    Ground at(const Hit& hit, double px, double py) const;
    /// Unit direction of the ray through a picture position.
    glm::vec3 viewAt(double px, double py) const;

    glm::vec2 worldGradient(glm::vec2 lattice) const {
        return {gradientXi_ * lattice.x + gradientXj_ * lattice.y,
                gradientYi_ * lattice.x + gradientYj_ * lattice.y};
    }
    glm::vec3 pictureNormal(glm::vec2 worldGradient) const {
        return glm::normalize(
            glm::vec3{-exaggeration_ * worldGradient.x, -exaggeration_ * worldGradient.y, 1.0f});
    }

private:
    /// Direction of a ray and how its end moves with the pixel, before it meets the ground.
    struct PixelRay {
        glm::vec3 direction, right, down;
        float area;  ///< of the pixel, across the ray
    };
    PixelRay pixelRay(double px, double py, float t) const;
    static glm::vec2 onGround(const PixelRay& ray, const glm::vec3& normal, const glm::vec3& move);

    void asBlock(const Hit& hit, const PixelRay& ray, double px, double py, Ground& ground) const;

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
