// SPDX-License-Identifier: Apache-2.0
// A photo filtered to a pixel's footprint: mips in linear light, taps along the footprint's longer
// axis (Dick et al. 2009, section 3.3, docs/papers.md; after Feline, McCormack et al. 1999).
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "raster/photo.h"
#include "shade/batch.h"
#include "shade/rules/colour.h"

namespace terray {

/// Linear light, premultiplied by the share that the photo covers.
struct PhotoSample {
    rules::Rgb colour{0.0f};
    float cover = 0;
};

/// Places of kBatch samples in photo pixels, centres at whole numbers, and the two sides of the
/// parallelogram that each covers.
struct PhotoFeet {
    Doubles x, y;
    Floats2 a, b;
};
struct PhotoBatch {
    FloatsRgb colour;
    Floats cover;
};

/// Borrows the photo's finest pixels. const-shared.
class PhotoFilter {
public:
    explicit PhotoFilter(const Photo& photo);

    /// Mean over the parallelogram of `a` and `b` (photo pixels per picture sample) around a place
    /// given in photo pixels, centres at whole numbers.
    PhotoSample at(Vec2 place, glm::vec2 a, glm::vec2 b) const;
    void at(const PhotoFeet& feet, PhotoBatch& photo) const;

    int mipCount() const { return static_cast<int>(mips_.size()); }

private:
    struct Mip {
        int width = 0, height = 0;
        std::vector<uint8_t> own;  ///< straight-alpha sRGB like the photo's; empty for mip 0
        const uint8_t* rgba = nullptr;
        float scale = 1;  ///< pixels of this mip per photo pixel
    };
    struct Shapes;
    static void addTap(const Mip& mip, double placeX, double placeY, float weight,
                       PhotoSample& sum);
    static Mip halve(const Mip& fine);

    std::vector<Mip> mips_;
    int width_ = 0, height_ = 0;
};

}  // namespace terray
