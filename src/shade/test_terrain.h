// SPDX-License-Identifier: Apache-2.0
// A small resident terrain, its finest cut, a camera and a sun, for tests of shading.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "shade/shade.h"
#include "stream/cut.h"

namespace terray::test {

/// Heights by a function of post indices.
class FunctionSource final : public HeightSource, public HeightReader {
public:
    FunctionSource(int columns, int rows, double cell, std::function<double(int64_t, int64_t)> z)
        : z_(std::move(z)) {
        info_.scheme = {columns, rows};
        info_.worldFromLattice = {{500000, 4000000}, {cell, 0}, {0, -cell}};
        info_.minZ = std::numeric_limits<float>::max();
        info_.maxZ = std::numeric_limits<float>::lowest();
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < columns; ++i) {
                const auto v = static_cast<float>(z_(i, j));
                if (std::isnan(v)) continue;
                info_.minZ = std::min(info_.minZ, v);
                info_.maxZ = std::max(info_.maxZ, v);
            }
        }
    }
    const TerrainInfo& info() const override { return info_; }
    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        return std::unique_ptr<HeightReader>(std::make_unique<FunctionSource>(*this));
    }
    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                      std::span<float> posts) override {
        for (int64_t y = 0; y < height; ++y)
            for (int64_t x = 0; x < width; ++x)
                posts[static_cast<size_t>(y * width + x)] =
                    static_cast<float>(z_(column + x, row + y));
        return {};
    }
    Result<void> readCodes(int64_t, int64_t, int64_t, int64_t, std::span<uint16_t>) override {
        return Error{ErrorCode::Failed, "these posts are floats"};
    }

private:
    TerrainInfo info_;
    std::function<double(int64_t, int64_t)> z_;
};

/// Heights of a small hilly terrain.
inline double hills(int64_t i, int64_t j) {
    const double x = static_cast<double>(i), y = static_cast<double>(j);
    return 900 + 160 * std::sin(x * 0.05 + std::sin(y * 0.03)) * std::cos(y * 0.07) +
           12 * std::sin(x * 0.9) * std::sin(y * 0.7);
}

/// Everything that a shader borrows.
struct ShadeScene {
    std::unique_ptr<ResidentTerrain> terrain;
    FrameCut cut;
    RayFrame rays;
    ShadeSettings settings;

    ShadeScene(const FunctionSource& source, const Camera& camera, double exaggeration = 1,
               double bend = 0)
        : terrain(build(source)),
          cut(finestCut(*terrain, kSurfaceBilinear)),
          rays(camera, source.info().worldFromLattice, exaggeration, bend) {
        const double azimuth = radFromDeg(315), elevation = radFromDeg(28);
        settings.sun.towards = {std::sin(azimuth) * std::cos(elevation),
                                std::cos(azimuth) * std::cos(elevation), std::sin(elevation)};
        settings.sun.centre = source.info().worldFromLattice.origin;
    }
    std::unique_ptr<Shader> shader(const Photo* photo = nullptr) const {
        auto made = Shader::make(*terrain, cut.cut(), rays, photo, settings);
        return made.ok() ? std::move(*made) : nullptr;
    }
    ImageTile tile() const { return {0, 0, rays.camera().width, rays.camera().height}; }
    std::vector<Hit> hits(Vec2 offset = {0.5, 0.5}) const {
        std::vector<Ray> all;
        for (int y = 0; y < tile().height; ++y)
            for (int x = 0; x < tile().width; ++x)
                all.push_back(rays.rayThrough(x + offset.x, y + offset.y));
        std::vector<Hit> found(all.size());
        TraceCounters counters;
        firstHits(cut.cut(), all, found, counters);
        return found;
    }

private:
    static std::unique_ptr<ResidentTerrain> build(const FunctionSource& source) {
        BuildStats stats;
        auto built = ResidentTerrain::build(source, uint64_t{1} << 30, stats);
        return std::move(*built);
    }
};

/// A camera above the middle of the source, looking down at an angle to the north.
inline Camera cameraOver(const FunctionSource& source, int width, int height) {
    const TerrainInfo& info = source.info();
    const Vec2 middle = info.worldFromLattice.worldFromLattice(
        {static_cast<double>(info.scheme.columns) / 2, static_cast<double>(info.scheme.rows) / 2});
    const double size =
        info.worldFromLattice.columnLength() * static_cast<double>(info.scheme.rows);
    Camera camera;
    camera.width = width;
    camera.height = height;
    camera.eye = {middle.x, middle.y - 0.7 * size, info.maxZ + 0.5 * size};
    const double pitch = radFromDeg(-35);
    camera.forward = {0, std::cos(pitch), std::sin(pitch)};
    camera.up = {0, -std::sin(pitch), std::cos(pitch)};
    camera.right = {1, 0, 0};
    return camera;
}

}  // namespace terray::test
