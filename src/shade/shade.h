// SPDX-License-Identifier: Apache-2.0
// Hits to colour, deferred: everything that a pixel shows is decided here, from hits alone.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "base/result.h"
#include "kernel/sweep/sun_cache.h"
#include "kernel/trace.h"
#include "raster/photo.h"
#include "stream/photo_pages.h"
#include "stream/resident.h"
#include "terray/options.h"
#include "view/ray_frame.h"

namespace terray {

/// Linear-light colour (sRGB primaries), premultiplied by alpha; scene-referred: 1 is diffuse white
/// in sun.
struct Colour {
    float r = 0, g = 0, b = 0, a = 0;
};

/// Sun as shading and shadows use it, at the terrain's centre.
struct Sun {
    Vec3 towards{0, 0, 1};  ///< unit, true world axes (unexaggerated); grid north is +y
    Vec2 centre{
        0, 0};  ///< world place where `towards` holds; elevation elsewhere follows the curvature
    bool belowHorizon = false;
};

/// Memory that the sun sweeps of a terrain may take: half of its own, a quarter where tiles come
/// and go.
uint64_t mostSunSweepBytes(const ResidentTerrain& terrain);

struct ShadeSettings {
    Shading shading = Shading::Ramp;
    RenderOptions options;  ///< look options as given
    Sun sun;
    std::string crsWkt;  ///< for nothing but legend text
    /// Kept by who draws several frames, so that a sun is swept once; null: the shader's own. Of
    /// mostSunSweepBytes, so that the sweeps of all samples fit.
    std::shared_ptr<SunSweepCache> sunSweeps;
};

struct ShadeCounters {
    PhotoUse photo;  ///< prepared by Shader::prepareUse
    uint64_t shadowRays = 0;
    double shadowMs = 0;   ///< casting them, in lit pictures
    double displayMs = 0;  ///< to 8 bits, where that is part of shading
};

class HeightRamp;
class ShadeCache;

/// What is draped over the terrain: one of the two, or nothing. Borrowed.
struct DrapedPhoto {
    DrapedPhoto() = default;
    DrapedPhoto(std::nullptr_t) {}
    DrapedPhoto(const Photo* photo) : whole(photo) {}
    DrapedPhoto(const ResidentPhoto* photo) : inBlocks(photo) {}
    explicit operator bool() const { return whole != nullptr || inBlocks != nullptr; }
    const Affine2& worldFromPixel() const {
        return whole != nullptr ? whole->worldFromPixel : inBlocks->worldFromPixel();
    }
    const Photo* whole = nullptr;
    const ResidentPhoto* inBlocks = nullptr;
};

/// Of a pixel's width, what one of `samples` covers.
float shadeSampleShare(int samples);

/// All that is prepared once per frame: ramp, sky-light field, photo mips, haze. const-shared.
class Shader {
public:
    /// `photo` may be nothing (required for Shading::Photo: Error Usage). Borrowed things outlive
    /// the shader. `cache`: of this terrain and photo, for what need not be made again; null: none.
    static Result<std::unique_ptr<Shader>> make(const ResidentTerrain& terrain,
                                                const TerrainCut& cut, const RayFrame& rays,
                                                DrapedPhoto photo, const ShadeSettings& settings,
                                                ShadeCache* cache = nullptr);
    virtual ~Shader() = default;

    /// Empties what sampling notes of the photo; before its first tile.
    virtual void prepareUse(PhotoUse& use) const = 0;

    /// Notes which blocks of the photo a picture wants that is `rays` in small: each of its pixels
    /// stands for `pixels` x `pixels` of the frame's.
    virtual void scoutPhoto(const RayFrame& rays, int pixels, PhotoUse& use) const = 0;

    /// Adds weight * colour of every pixel of the tile to `sum` (row by row). `offset` is the
    /// sample's.
    virtual void shadeTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                           float weight, std::span<Colour> sum, ShadeCounters& counters) const = 0;

    /// Pixels of one sample each, straight to the 8 bits that toDisplay() would give them.
    virtual void showTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                          std::span<uint8_t> rgba, ShadeCounters& counters) const = 0;

    /// Scene-linear to display: soft filmic shoulder, sRGB, straight alpha; 8 bit.
    /// `out` has 4 bytes a pixel. Inspection modes (normal, mip, ...) pass through without the
    /// shoulder.
    virtual void toDisplay(std::span<const Colour> in, std::span<uint8_t> out) const = 0;

    /// Values of an AOV for the hits through pixel centres; `channels` (1 or 3) floats a pixel, NaN
    /// = miss.
    virtual void fillAov(Aov aov, const ImageTile& tile, std::span<const Hit> hits,
                         std::span<float> out) const = 0;

    /// The ramp that tints heights, for the legend; null in modes without one.
    virtual const HeightRamp* ramp() const { return nullptr; }

    /// Milliseconds spent on sky sweeps while making it.
    virtual double skyMs() const = 0;
};

constexpr int aovChannels(Aov aov) { return aov == Aov::Position || aov == Aov::Normal ? 3 : 1; }

/// Built-in ramps for `terray render --ramp`.
struct RampName {
    std::string name, line;
};
std::span<const RampName> rampTable();

}  // namespace terray
