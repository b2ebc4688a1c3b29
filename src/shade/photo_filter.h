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
#include "stream/photo_pages.h"

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
    Ints late;  ///< 1 where a block was missing
};

/// Borrows the photo. const-shared.
class PhotoFilter {
public:
    explicit PhotoFilter(const Photo& photo);
    explicit PhotoFilter(const ResidentPhoto& photo);

    /// Mean over the parallelogram of `a` and `b` (photo pixels per picture sample) around a place
    /// given in photo pixels, centres at whole numbers.
    PhotoSample at(Vec2 place, glm::vec2 a, glm::vec2 b) const;
    /// `use` (of the resident photo's slots) learns which blocks were read, or missing: then the
    /// next coarser mip that is there stands in.
    void at(const PhotoFeet& feet, PhotoBatch& photo, PhotoUse& use) const;
    /// Makes `use` empty, and of the right size.
    void prepare(PhotoUse& use) const { use.clear(pages_ != nullptr ? pages_->slotCount : 0); }

    int mipCount() const { return static_cast<int>(mips_.size()); }

private:
    struct Mip {
        int width = 0, height = 0;
        std::vector<uint8_t> own;       ///< straight-alpha sRGB like the photo's; may be empty
        const uint8_t* rgba = nullptr;  ///< row by row; null if it lies in pages
        const PhotoPages::Mip* inPages = nullptr;
        float scale = 1;  ///< pixels of this mip per photo pixel
    };
    struct Shapes;
    struct Corners;
    template <bool kInBlocks>
    void addTap(const Mip* mip, double placeX, double placeY, float weight, PhotoSample& sum,
                PhotoUse& use) const;
    template <bool kInBlocks>
    void takeTaps(const PhotoFeet& feet, const Shapes& shapes, PhotoBatch& photo,
                  PhotoUse& use) const;
    bool findInPages(const PhotoPages::Mip& mip, Corners& corners, PhotoUse& use) const;
    static Mip halve(const Mip& fine);
    void addCoarser();

    std::vector<Mip> mips_;
    const PhotoPages* pages_ = nullptr;
    int width_ = 0, height_ = 0;
};

}  // namespace terray
