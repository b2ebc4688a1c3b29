// SPDX-License-Identifier: Apache-2.0
// The one Shader: what a frame prepares, and its three jobs (lit pictures, inspection modes, AOVs).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kernel/sweep/sun_cache.h"
#include "shade/background.h"
#include "shade/display.h"
#include "shade/ground.h"
#include "shade/haze.h"
#include "shade/light.h"
#include "shade/lit_loops.h"
#include "shade/photo_filter.h"
#include "shade/photo_map.h"
#include "shade/plinth.h"
#include "shade/ramp.h"
#include "shade/shade.h"
#include "shade/shade_cache.h"
#include "shade/sky.h"
#include "shade/sun_rays.h"

namespace terray {

/// Made by Shader::make. const-shared: shading keeps its scratch per thread.
class DeferredShader final : public Shader {
public:
    DeferredShader(const ResidentTerrain& terrain, const TerrainCut& cut, const RayFrame& rays,
                   DrapedPhoto photo, const ShadeSettings& settings, const Background& background);
    /// Survey, ramp and sky light: what can fail or takes time.
    Result<void> prepare(ShadeCache& cache);

    void prepareUse(PhotoUse& use) const override;
    void scoutPhoto(const RayFrame& rays, int pixels, PhotoUse& use) const override;

    void shadeTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits, float weight,
                   std::span<Colour> sum, ShadeCounters& counters) const override;
    void showTile(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                  std::span<uint8_t> rgba, ShadeCounters& counters) const override;
    void toDisplay(std::span<const Colour> in, std::span<uint8_t> out) const override {
        display_->apply(in, out);
    }
    void fillAov(Aov aov, const ImageTile& tile, std::span<const Hit> hits,
                 std::span<float> out) const override;
    double skyMs() const override { return skyMs_; }
    const HeightRamp* ramp() const override { return ramp_ ? &ramp_->heights : nullptr; }

private:
    /// Buffers that a thread keeps from tile to tile; whole batches of pixels.
    struct Scratch {
        std::vector<LitBatch> lit;
        std::vector<SunAsks> asks;  ///< where the sun may shine
        std::vector<uint8_t> dark;
        std::vector<Hit> carried;
        void resize(size_t pixels);
    };

    // shade_lit.cpp
    /// Light and shadow of a tile's pixels, batch by batch.
    const Scratch& shadeLit(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                            ShadeCounters& counters) const;
    void shadeBatch(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits, size_t first,
                    Scratch& scratch, PhotoUse& photo) const;
    void lightAndAsk(const HitBatch& hits, const GroundBatch& ground, LitBatch& lit, SunAsks& asks,
                     PhotoUse& photo) const;
    void colourBatch(const HitBatch& hits, const GroundBatch& ground, const LightBatch& light,
                     LitBatch& lit, PhotoUse& photo) const;
    void storeMisses(const HitBatch& hits, size_t count, const ViewBatch& view,
                     LitBatch& lit) const;
    static void setPixel(LitBatch& lit, size_t k, const Colour& colour);
    void addPlinth(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                   Scratch& scratch) const;
    void addVoids(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                  Scratch& scratch) const;
    void rampBatch(const GroundBatch& ground, FloatsRgb& albedo) const;
    void photoBatch(const HitBatch& hits, const GroundBatch& ground, FloatsRgb& own,
                    FloatsRgb& albedo, PhotoUse& photo) const;
    void contourBatch(const GroundBatch& ground, Floats& cover) const;
    float gridCover(const HitBatch& hits, const GroundBatch& ground, int k) const;
    /// Fills scratch.dark: by a sun sweep where that pays, else ray by ray.
    void findShadows(Vec2 offset, std::span<const Hit> hits, Scratch& scratch,
                     ShadeCounters& counters) const;
    void castShadows(const SunDirection& toSun, std::span<const Hit> hits, Scratch& scratch,
                     ShadeCounters& counters) const;
    /// The hits on ground that the plinth carries: rays go on where they hit what stands over it.
    void cutOverhang(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                     std::vector<Hit>& carried) const;
    /// Colour of the plinth where it stands before the hit.
    std::optional<rules::Rgb> plinthColour(const Hit& hit, double px, double py) const;

    // shade_flat.cpp
    void shadeFlat(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits, float weight,
                   std::span<Colour> sum, ShadeCounters& counters) const;
    rules::Rgb flatColour(const Hit& hit, double px, double py, const GroundBatch& ground, int k,
                          ShadeCounters& counters) const;
    bool flatNeedsGround() const;
    rules::Rgb shadowStepsColour(const Hit& hit, double px, double py,
                                 ShadeCounters& counters) const;

    /// Premultiplied colour of a ray that misses, in the mode's own scale.
    Colour missColour(const glm::vec3& view) const;

    // aov.cpp
    void shadowAov(const ImageTile& tile, std::span<const Hit> hits, std::span<float> out) const;
    void vectorAov(Aov aov, const ImageTile& tile, std::span<const Hit> hits,
                   std::span<float> out) const;
    float aovValue(Aov aov, const Hit& hit, double px, double py) const;
    /// True height of a hit: on a wall only its ray knows it.
    double heightOf(const Hit& hit, double px, double py) const;
    /// Unit, true world axes. The strips between tiles, thinner than the tolerance, have their
    /// cells'.
    Vec3 normalOf(const Hit& hit, double px, double py) const;

    const ResidentTerrain& terrain_;
    const TerrainCut& cut_;
    const RayFrame& rays_;
    ShadeSettings settings_;
    Background background_;
    GroundSampler ground_;
    SunRays sunRays_;
    std::shared_ptr<SunSweepCache> sunSweeps_;  ///< null where a sweep does not pay
    SceneReach reach_;
    rules::Light light_;
    rules::Air air_;
    const DisplayCurve* display_;
    std::shared_ptr<const ShadeCache::Ramp> ramp_;
    std::shared_ptr<const SkyLight> sky_;
    std::optional<Plinth> plinth_;
    std::optional<Plinth> voids_;  ///< not seen itself: tells rays that came through holes
    DrapedPhoto photo_;
    std::shared_ptr<const PhotoFilter> photoFilter_;
    std::optional<PhotoMap> photoMap_;
    float sampleShare_ = 1;  ///< width of a sample, in pixels
    float modelling_ = 1;    ///< factor on the slopes that the sun models
    double skyMs_ = 0;
};

}  // namespace terray
