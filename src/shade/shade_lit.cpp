// SPDX-License-Identifier: Apache-2.0
// Lit pictures: hits to ground, ground to shadow rays, and all of it to colour through the air.
#include <algorithm>
#include <array>

#include "base/stopwatch.h"
#include "kernel/height.h"
#include "shade/deferred.h"
#include "shade/rules/lines.h"

namespace terray {

using rules::Rgb;

namespace {

const Rgb kRock = rules::sceneFromCodes(136, 131, 123);
const Rgb kClay = rules::sceneFromCodes(217, 215, 211);
const Rgb kPlinth = rules::sceneFromCodes(198, 194, 187);
const Rgb kContour = rules::sceneFromCodes(92, 68, 50);
const Rgb kGridLine = rules::sceneFromCodes(36, 42, 52);

/// Scene value that displays as a photo's linear value: rules::sceneFromDisplay by table.
float sceneFromPhoto(float v) {
    constexpr size_t kLast = 1024;
    static const std::array<float, kLast + 1> kTable = [] {
        std::array<float, kLast + 1> table{};
        for (size_t k = 0; k <= kLast; ++k)
            table[k] = rules::sceneFromDisplay(static_cast<float>(k) / static_cast<float>(kLast));
        return table;
    }();
    const float x = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(kLast);
    const size_t k = std::min(static_cast<size_t>(x), kLast - 1);
    const float f = x - static_cast<float>(k);
    return kTable[k] + f * (kTable[k + 1] - kTable[k]);
}

}  // namespace

void DeferredShader::prepareLit(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                                Scratch& scratch) const {
    const size_t count = hits.size();
    scratch.lit.resize(count);
    scratch.hits.resize(count);
    scratch.rays.resize(count);
    scratch.dark.assign(count, 0);
    const bool sun = light_.sun.g > 0;
    const bool shadows = sun && settings_.options.shadows;
    const bool soft = settings_.options.samples > 1;
    const Vec2 onDisc = soft ? 2.0 * (offset - Vec2{0.5, 0.5}) : Vec2{0, 0};
    size_t k = 0;
    for (int y = 0; y < tile.height; ++y) {
        const double py = tile.y + y + offset.y;
        for (int x = 0; x < tile.width; ++x, ++k) {
            const Hit& hit = hits[k];
            scratch.hits[k].flags = 0;
            if (!isHit(hit)) continue;
            Lit& lit = scratch.lit[k];
            lit.ground = ground_.at(hit, tile.x + x + offset.x, py);
            lit.facing = 0;
            if (!sun) continue;
            const Ground& g = lit.ground;
            const glm::vec3 modelled = glm::normalize(
                glm::vec3{g.normal.x * modelling_, g.normal.y * modelling_, g.normal.z});
            lit.facing = std::max(0.0f, glm::dot(modelled, sunRays_.towardsAt(g.i, g.j)));
            if (!shadows || lit.facing <= 0) continue;
            scratch.hits[k] = hit;
            scratch.rays[k] = sunRays_.from(g.i, g.j, static_cast<double>(g.height), onDisc);
        }
    }
}

void DeferredShader::shadeLit(const ImageTile& tile, Vec2 offset, std::span<const Hit> hits,
                              float weight, std::span<Colour> sum, ShadeCounters& counters) const {
    thread_local Scratch scratch;
    if (plinth_) {
        cutOverhang(tile, offset, hits, scratch.carried);
        hits = scratch.carried;
    }
    prepareLit(tile, offset, hits, scratch);
    if (light_.sun.g > 0 && settings_.options.shadows) {
        const Stopwatch watch;
        TraceCounters traced;
        occluded(cut_, scratch.hits, scratch.rays, scratch.dark, traced);
        counters.shadowRays += traced.rays;
        counters.shadowMs += watch.elapsedMs();
    }
    size_t k = 0;
    for (int y = 0; y < tile.height; ++y) {
        for (int x = 0; x < tile.width; ++x, ++k) {
            const double px = tile.x + x + offset.x, py = tile.y + y + offset.y;
            Colour add;
            if (const auto base = plinthColour(hits[k], px, py)) {
                add = {base->r, base->g, base->b, 1.0f};
            } else if (isHit(hits[k])) {
                const Rgb c = litColour(hits[k], scratch.lit[k], scratch.dark[k] ? 0.0f : 1.0f);
                add = {c.r, c.g, c.b, 1.0f};
            } else {
                add = missColour(ground_.viewAt(px, py));
            }
            sum[k].r += weight * add.r;
            sum[k].g += weight * add.g;
            sum[k].b += weight * add.b;
            sum[k].a += weight * add.a;
        }
    }
}

Rgb DeferredShader::litColour(const Hit& hit, const Lit& lit, float sunlit) const {
    const Ground& ground = lit.ground;
    const float openSky = sky_->at(ground.i, ground.j, ground.footprint);
    const Rgb light = rules::lightOn(light_, lit.facing, sunlit, openSky, ground.normal.z);
    Rgb colour;
    switch (settings_.shading) {
        case Shading::Photo: colour = photoColour(ground, light); break;
        case Shading::Light: colour = kClay * light; break;
        default: colour = rampAlbedo(ground) * light; break;
    }
    if (settings_.options.contoursM > 0) {
        const float perPixel = glm::length(glm::vec2{glm::dot(ground.gradient, ground.footX),
                                                     glm::dot(ground.gradient, ground.footY)});
        const float cover = rules::contourCover(ground.height, perPixel,
                                                static_cast<float>(settings_.options.contoursM));
        colour = glm::mix(colour, kContour * light, cover);
    }
    if (settings_.shading == Shading::Grid)
        colour = glm::mix(colour, kGridLine, 0.8f * gridCover(hit, ground));
    return rules::throughAir(air_, colour, ground.distance);
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

Rgb DeferredShader::rampAlbedo(const Ground& ground) const {
    const Tint tint = ramp_->at(ground.height);
    const float steep = tint.rock * rules::smoothStep(0.55f, 1.30f, ground.slope());
    const Rgb bare = glm::mix(kClay, tint.colour, tint.cover);
    return glm::mix(bare, kRock, steep);
}

Rgb DeferredShader::photoColour(const Ground& ground, const Rgb& light) const {
    const Affine2& map = photo_->worldFromPixel;
    const Vec2 world = rays_.worldFromLattice().worldFromLattice({ground.i, ground.j});
    const LatticePoint place = map.latticeFromWorld(world);
    const auto pixels = [&](const glm::vec2& metres) {
        const LatticePoint p = map.latticeDirection(Vec2(metres * sampleShare_));
        return glm::vec2{p.i, p.j};
    };
    const PhotoSample photo =
        photoFilter_->at({place.i, place.j}, pixels(ground.footX), pixels(ground.footY));
    Rgb colour{0.0f};
    if (photo.cover > 0) {
        const Rgb shown = photo.colour / photo.cover;
        const Rgb scene{sceneFromPhoto(shown.r), sceneFromPhoto(shown.g), sceneFromPhoto(shown.b)};
        const auto relief = static_cast<float>(settings_.options.reliefOnPhotoPercent / 100.0);
        colour = scene * glm::mix(Rgb{1.0f}, light, relief) * photo.cover;
    }
    const float bare = 1.0f - photo.cover;
    return bare > 0.002f ? colour + rampAlbedo(ground) * light * bare : colour;
}

float DeferredShader::gridCover(const Hit& hit, const Ground& ground) const {
    const Affine2& map = rays_.worldFromLattice();
    const LatticePoint right = map.latticeDirection(Vec2(ground.footX));
    const LatticePoint down = map.latticeDirection(Vec2(ground.footY));
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
