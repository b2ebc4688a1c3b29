// SPDX-License-Identifier: Apache-2.0
// Lit pictures: hits to ground, ground to shadow rays, and all of it to colour through the air.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/stopwatch.h"
#include "kernel/height.h"
#include "shade/deferred.h"
#include "shade/rules/lines.h"

namespace terray {

using rules::Rgb;

namespace {

const Rgb kRock = rules::sceneFromCodes(136, 131, 123);
const Rgb kPlinth = rules::sceneFromCodes(198, 194, 187);
const Rgb kVoid = rules::sceneFromCodes(172, 168, 153);
const Rgb kContour = rules::sceneFromCodes(92, 68, 50);
const Rgb kGridLine = rules::sceneFromCodes(36, 42, 52);

/// Where on the sun's disc the ray of a sample aims.
Vec2 discPlace(const RenderOptions& options, Vec2 offset) {
    return options.samples > 1 ? 2.0 * (offset - Vec2{0.5, 0.5}) : Vec2{0, 0};
}

}  // namespace

void DeferredShader::Scratch::resize(size_t pixels) {
    const size_t batches = (pixels + kBatch - 1) / kBatch;
    lit.resize(batches);
    asks.resize(batches);
    dark.resize(batches * kBatch);
}

void DeferredShader::findShadows(Vec2 offset, std::span<const Hit> hits, Scratch& scratch,
                                 ShadeCounters& counters) const {
    const SunDirection toSun = sunRays_.direction(discPlace(settings_.options, offset));
    const auto sweep = sunSweeps_ ? sunSweeps_->get(cut_, toSun) : nullptr;
    if (!sweep) {
        castShadows(toSun, hits, scratch, counters);
        return;
    }
    ShadowCounters walked;
    terray::shadows(cut_, *sweep, hits, scratch.asks, scratch.dark, walked);
    counters.shadowRays += walked.rays;
}

void DeferredShader::castShadows(const SunDirection& toSun, std::span<const Hit> hits,
                                 Scratch& scratch, ShadeCounters& counters) const {
    std::array<Hit, kBatch> from;
    std::array<Ray, kBatch> rays;
    TraceCounters traced;
    for (size_t first = 0; first < hits.size(); first += kBatch) {
        const SunAsks& asks = scratch.asks[first / kBatch];
        for (size_t k = 0; k < kBatch; ++k) {
            const int lane = static_cast<int>(k);
            from[k].flags = 0;
            if (!asks.asks(lane)) continue;
            from[k] = hits[first + k];
            rays[k] = sunRay(cut_, toSun, from[k], asks.z[lane]);
        }
        occluded(cut_, from, rays, std::span(scratch.dark).subspan(first, kBatch), traced);
    }
    counters.shadowRays += traced.rays;
}

const DeferredShader::Scratch& DeferredShader::shadeLit(const ImageTile& tile, Vec2 offset,
                                                        std::span<const Hit> hits,
                                                        ShadeCounters& counters) const {
    thread_local Scratch scratch;
    if (plinth_) {
        cutOverhang(tile, offset, hits, scratch.carried);
        hits = scratch.carried;
    }
    scratch.resize(hits.size());
    for (size_t first = 0; first < hits.size(); first += kBatch)
        shadeBatch(tile, offset, hits, first, scratch, counters.photo);
    if (plinth_) addPlinth(tile, offset, hits, scratch);
    if (voids_) addVoids(tile, offset, hits, scratch);
    if (light_.sun.g > 0 && settings_.options.shadows) {
        const CpuStopwatch watch;
        findShadows(offset, hits, scratch, counters);
        counters.shadowMs += watch.elapsedMs();
    } else {
        std::fill(scratch.dark.begin(), scratch.dark.end(), uint8_t{0});
    }
    return scratch;
}

void DeferredShader::shadeBatch(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                                size_t first, Scratch& scratch, PhotoUse& photo) const {
    const size_t count = std::min<size_t>(kBatch, hits.size() - first);
    ViewBatch view;
    view.setPixels(rays_.camera(), tile, offset, first);
    ground_.lookThrough(view);
    const HitBatch batch(hits.subspan(first, count));
    LitBatch& lit = scratch.lit[first / kBatch];
    SunAsks& asks = scratch.asks[first / kBatch];
    asks.clear();
    if (batch.some) {
        GroundBatch ground;
        ground_.at(batch, view, ground);
        lightAndAsk(batch, ground, lit, asks, photo);
    }
    if (!batch.all) storeMisses(batch, count, view, lit);
}

/// Colours of a batch in light, and which of its hits have to ask whether the sun reaches them.
void DeferredShader::lightAndAsk(const HitBatch& hits, const GroundBatch& ground, LitBatch& lit,
                                 SunAsks& asks, PhotoUse& photo) const {
    Floats facing{}, openSky;
    const bool sun = light_.sun.g > 0;
    if (sun) sunRays_.facing(ground, modelling_, facing);
    sky_->at(ground.place, ground.footprint, openSky);
    if (settings_.shading == Shading::Ramp && settings_.options.contoursM <= 0) {
        FloatsRgb colour;
        Floats rock;
        ramp_->tints.at(ground.height, colour, rock);
        rampedBatch({light_, air_, kRock}, facing, openSky, ground, colour, rock, lit);
    } else {
        LightBatch light;
        lightBatch(light_, facing, openSky, ground, light);
        colourBatch(hits, ground, light, lit, photo);
        hazeBatch(air_, ground.distance, lit);
        std::fill_n(lit.alpha.at, kBatch, 1.0f);
    }
    if (!sun || !settings_.options.shadows) return;
    SunRays::ask(hits, facing, ground.height, asks);
}

void DeferredShader::colourBatch(const HitBatch& hits, const GroundBatch& ground,
                                 const LightBatch& light, LitBatch& lit, PhotoUse& photo) const {
    FloatsRgb own{}, albedo;
    switch (settings_.shading) {
        case Shading::Photo: photoBatch(hits, ground, own, albedo, photo); break;
        case Shading::Light:
            for (int k = 0; k < kBatch; ++k) {
                albedo.r[k] = kClay.r;
                albedo.g[k] = kClay.g;
                albedo.b[k] = kClay.b;
            }
            break;
        default: rampBatch(ground, albedo); break;
    }
    reflectBatch(own, albedo, light, lit);
    Floats cover;
    if (settings_.options.contoursM > 0) {
        contourBatch(ground, cover);
        paintBatch(kContour, cover, &light, lit);
    }
    if (settings_.shading == Shading::Grid) {
        for (int k = 0; k < kBatch; ++k) cover[k] = 0.8f * gridCover(hits, ground, k);
        paintBatch(kGridLine, cover, nullptr, lit);
    }
}

/// Pixels without ground show the background.
void DeferredShader::storeMisses(const HitBatch& hits, size_t count, const ViewBatch& view,
                                 LitBatch& lit) const {
    FloatsRgb sky;
    if (background_.kind == Background::Kind::Sky) skyBatch(air_, view.direction.z, sky);
    for (size_t k = 0; k < count; ++k) {
        const int lane = static_cast<int>(k);
        if (hits.own[lane] != 0) continue;
        const Colour miss = background_.kind == Background::Kind::Sky
                                ? Colour{sky.r[lane], sky.g[lane], sky.b[lane], 1.0f}
                                : missColour({0, 0, 1});
        setPixel(lit, k, miss);
    }
}

void DeferredShader::setPixel(LitBatch& lit, size_t k, const Colour& colour) {
    const int lane = static_cast<int>(k % kBatch);
    lit.always.r[lane] = colour.r;
    lit.always.g[lane] = colour.g;
    lit.always.b[lane] = colour.b;
    lit.alpha[lane] = colour.a;
    lit.sun.r[lane] = lit.sun.g[lane] = lit.sun.b[lane] = 0;
}

void DeferredShader::addPlinth(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                               Scratch& scratch) const {
    const auto width = static_cast<size_t>(tile.width);
    for (size_t k = 0; k < hits.size(); ++k) {
        const double px = tile.x + static_cast<double>(k % width) + offset.x;
        const double py = tile.y + static_cast<double>(k / width) + offset.y;
        const auto base = plinthColour(hits[k], px, py);
        if (!base) continue;
        setPixel(scratch.lit[k / kBatch], k, {base->r, base->g, base->b, 1.0f});
        scratch.asks[k / kBatch].withdraw(static_cast<int>(k % kBatch));
    }
}

/// Through a hole that ground surrounds, no sky shows but a plain tint: white voids would be taken
/// for snow or water.
void DeferredShader::addVoids(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                              Scratch& scratch) const {
    const auto width = static_cast<size_t>(tile.width);
    for (size_t k = 0; k < hits.size(); ++k) {
        if (isHit(hits[k])) continue;
        const Ray ray = rays_.rayThrough(tile.x + static_cast<double>(k % width) + offset.x,
                                         tile.y + static_cast<double>(k / width) + offset.y);
        if (ray.dz >= 0) continue;
        const auto seen = voids_->firstSeen(ray, ray.tMax);
        if (!seen || !seen->inHole) continue;
        const Rgb tint =
            rules::throughAir(air_, kVoid * rules::lightOn(light_, 0.5f, 1, 0.8f, 1.0f), seen->t);
        setPixel(scratch.lit[k / kBatch], k, {tint.r, tint.g, tint.b, 1.0f});
    }
}

void DeferredShader::cutOverhang(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                                 std::vector<Hit>& carried) const {
    carried.assign(hits.begin(), hits.end());
    const auto overhangs = [&](const Hit& hit) {
        if (!isHit(hit)) return false;
        const LatticePlace place = hitPlace(cut_, hit);
        return !plinth_->isUnder(place.i, place.j);
    };
    std::vector<size_t> again;
    for (size_t k = 0; k < carried.size(); ++k)
        if (overhangs(carried[k])) again.push_back(k);
    constexpr int kMostSheets = 4;  // of overhang that one ray goes through
    const auto width = static_cast<size_t>(tile.width);
    for (int sheet = 0; sheet < kMostSheets && !again.empty(); ++sheet) {
        std::vector<Ray> rays;
        for (const size_t k : again) {
            rays.push_back(rays_.rayThrough(tile.x + static_cast<double>(k % width) + offset.x,
                                            tile.y + static_cast<double>(k / width) + offset.y));
            rays.back().tMin = static_cast<double>(carried[k].t) * (1 + 1e-6);
        }
        std::vector<Hit> next(rays.size());
        TraceCounters counters;
        firstHits(cut_, rays, next, counters);
        std::vector<size_t> still;
        for (size_t n = 0; n < again.size(); ++n) {
            carried[again[n]] = next[n];
            if (overhangs(next[n])) still.push_back(again[n]);
        }
        again = std::move(still);
    }
}

std::optional<Rgb> DeferredShader::plinthColour(const Hit& hit, double px, double py) const {
    if (!plinth_) return std::nullopt;
    const Ray ray = rays_.rayThrough(px, py);
    // What is seen of the ground from below is seen through the block.
    const bool ground = isHit(hit) && !(hit.flags & kHitFromBelow);
    const auto seen = plinth_->firstSeen(ray, ground ? static_cast<double>(hit.t) : ray.tMax);
    if (!seen) return std::nullopt;
    if (seen->inHole)
        return rules::throughAir(air_, kRock * rules::lightOn(light_, 0.5f, 1, 0.8f, 1.0f),
                                 seen->t);
    // Even light with a hint of the sun.
    const float facing =
        std::max(0.0f, 0.42f + 0.20f * glm::dot(seen->outwards, glm::vec3(settings_.sun.towards)));
    constexpr float kHalfOpen = 0.75f;  // a wall sees half of the sky and bright floor below
    return rules::throughAir(air_, kPlinth * rules::lightOn(light_, facing, 1, kHalfOpen, 0.5f),
                             seen->t);
}

void DeferredShader::rampBatch(const GroundBatch& ground, FloatsRgb& albedo) const {
    Floats rock;
    ramp_->tints.at(ground.height, albedo, rock);
    steepenBatch(kRock, rock, ground, albedo);
}

void DeferredShader::photoBatch(const HitBatch& hits, const GroundBatch& ground, FloatsRgb& own,
                                FloatsRgb& albedo, PhotoUse& use) const {
    PhotoFeet feet;
    PhotoBatch photo;
    photoMap_->place(ground, feet);
    photoFilter_->at(feet, photo, use);
    for (int k = 0; k < kBatch; ++k)
        use.lateSamples += static_cast<uint64_t>(photo.late[k] & hits.own[k]);
    rampBatch(ground, albedo);
    showPhoto(photo, static_cast<float>(settings_.options.reliefOnPhotoPercent / 100.0), own,
              albedo);
}

void DeferredShader::contourBatch(const GroundBatch& ground, Floats& cover) const {
    const auto interval = static_cast<float>(settings_.options.contoursM);
    for (int k = 0; k < kBatch; ++k) {
        const float x = ground.gradient.x[k], y = ground.gradient.y[k];
        const float right = x * ground.footX.x[k] + y * ground.footX.y[k];
        const float down = x * ground.footY.x[k] + y * ground.footY.y[k];
        cover[k] =
            rules::contourCover(ground.height[k], std::sqrt(right * right + down * down), interval);
    }
}

float DeferredShader::gridCover(const HitBatch& hits, const GroundBatch& ground, int k) const {
    const Hit hit = hits.hit(k);
    const Affine2& map = rays_.worldFromLattice();
    const LatticePoint right = map.latticeDirection(Vec2(ground.footX.x[k], ground.footX.y[k]));
    const LatticePoint down = map.latticeDirection(Vec2(ground.footY.x[k], ground.footY.y[k]));
    const double cells = 1.0 / static_cast<double>(1u << hit.mip);
    const auto perPixelI = static_cast<float>(std::hypot(right.i, down.i) * cells);
    const auto perPixelJ = static_cast<float>(std::hypot(right.j, down.j) * cells);
    const float cell = std::max(rules::isoCover(hit.u, perPixelI, 0.35f),
                                rules::isoCover(hit.v, perPixelJ, 0.35f));
    constexpr float kTile = 1.0f / kTileCells;
    const float x = (static_cast<float>(cellX(hit)) + hit.u) * kTile;
    const float y = (static_cast<float>(cellY(hit)) + hit.v) * kTile;
    const float border = std::max(rules::isoCover(x, perPixelI * kTile, 1.0f),
                                  rules::isoCover(y, perPixelJ * kTile, 1.0f));
    return std::max(0.6f * cell, border);
}

}  // namespace terray
