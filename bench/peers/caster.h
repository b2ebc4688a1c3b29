// SPDX-License-Identifier: Apache-2.0
// A contender of a comparison: it casts the rays of image tiles and is timed doing so.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "frame_timing.h"
#include "kernel/trace.h"
#include "view/ray_frame.h"

namespace terray::bench {

/// What a contender leaves behind in a thread: hits or plain numbers of the tile's pixels, row by
/// row, in whichever of the two suits it.
struct Scratch {
    std::vector<Hit> hits = std::vector<Hit>(kTileWidth * kTileHeight);
    std::vector<float> values = std::vector<float>(kTileWidth * kTileHeight);
    TraceCounters counters;
};

/// Of a pixel in its tile, row by row.
inline size_t indexOf(const ImageTile& tile, int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(tile.width) + static_cast<size_t>(x);
}

/// const-shared: castTile is called from many threads.
class Caster {
public:
    virtual ~Caster() = default;
    /// Timed: sets up the tile's rays, casts them, and stores at least a distance (of a shadow ray:
    /// whether it is stopped) for each pixel.
    virtual void castTile(const ImageTile& tile, Scratch& scratch) const = 0;
    /// Not timed: what was cast, as distances (infinite: no hit), or as 1 and 0.
    virtual void readTile(const ImageTile& tile, const Scratch& scratch,
                          std::span<float> values) const = 0;
};

/// A caster with its name. `everyPixel`: false if it casts a sample of the pixels only.
struct Contender {
    std::string name;
    std::unique_ptr<Caster> caster;
    bool everyPixel = true;
};

/// The sun of the shadow rays: a place in the sky as maps like it, at 30 degrees.
inline Vec3 towardsSun() {
    const double azimuth = radFromDeg(315), elevation = radFromDeg(30);
    return {std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
            std::sin(elevation)};
}

}  // namespace terray::bench
