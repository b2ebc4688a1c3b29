// SPDX-License-Identifier: Apache-2.0
// Filling Embree's buffers from the posts of mip 0, and timing its build.
#include "peers/embree_scene.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/stopwatch.h"
#include "stream/pool.h"

namespace terray::bench {
namespace {

constexpr int64_t kLargestGridSide = 32767;

struct Lattice {
    int64_t columns, rows;
    Affine2 toWorld;
    WorldPoint origin;
};

/// Posts as vertices, row by row; what touches a hole is left out by who makes the topology.
void fillVertices(const ResidentTerrain& terrain, const Lattice& lattice, float* vertices) {
    const MipRows posts(terrain.pool(), 0);
    tbb::parallel_for(tbb::blocked_range<int64_t>(0, lattice.rows), [&](const auto& range) {
        std::vector<float> heights(static_cast<size_t>(lattice.columns));
        for (int64_t j = range.begin(); j < range.end(); ++j) {
            posts.read(j, 0, lattice.columns, heights.data());
            float* out = vertices + 3 * j * lattice.columns;
            for (int64_t i = 0; i < lattice.columns; ++i) {
                const Vec2 place = lattice.toWorld.worldFromLattice(
                    {static_cast<double>(i), static_cast<double>(j)});
                *out++ = static_cast<float>(place.x - lattice.origin.x);
                *out++ = static_cast<float>(place.y - lattice.origin.y);
                *out++ = static_cast<float>(static_cast<double>(heights[static_cast<size_t>(i)]) -
                                            lattice.origin.z);
            }
        }
    });
}

/// Two triangles a cell, split from post (1, 0) to post (0, 1), as Embree splits the cells of a
/// grid. Cells with a hole for a corner get degenerate ones.
void fillTriangles(const Lattice& lattice, const float* vertices, uint32_t* indices) {
    tbb::parallel_for(tbb::blocked_range<int64_t>(0, lattice.rows - 1), [&](const auto& range) {
        for (int64_t j = range.begin(); j < range.end(); ++j) {
            uint32_t* out = indices + 6 * j * (lattice.columns - 1);
            for (int64_t i = 0; i + 1 < lattice.columns; ++i) {
                const auto p00 = static_cast<uint32_t>(j * lattice.columns + i), p10 = p00 + 1,
                           p01 = p00 + static_cast<uint32_t>(lattice.columns), p11 = p01 + 1;
                const auto z = [&](uint32_t post) { return vertices[3 * size_t{post} + 2]; };
                const bool hole = std::isnan(z(p00) + z(p10) + z(p01) + z(p11));
                const uint32_t corners[6] = {p00, p10, p01, p11, p01, p10};
                for (const uint32_t corner : corners) *out++ = hole ? p00 : corner;
            }
        }
    });
}

/// Grids that cover all cells without a hole: Embree drops a grid that has one. Quartered around
/// holes, so that a terrain without any is a single grid.
class GridSplitter {
public:
    GridSplitter(const Lattice& lattice, const float* vertices)
        : lattice_(lattice), vertices_(vertices) {}
    /// Posts [column, column + width) x [row, row + height).
    void split(int64_t column, int64_t row, int64_t width, int64_t height) {
        if (width < 2 || height < 2) return;
        const int64_t holes = countHoles(column, row, width, height);
        if (holes == width * height) return;
        if (holes == 0) {
            grids_.push_back({static_cast<uint32_t>(row * lattice_.columns + column),
                              static_cast<uint32_t>(lattice_.columns), static_cast<uint16_t>(width),
                              static_cast<uint16_t>(height)});
            return;
        }
        if (width == 2 && height == 2) return;
        const int64_t left = (width + 1) / 2, top = (height + 1) / 2;  // they share a post
        split(column, row, left, top);
        split(column + left - 1, row, width - left + 1, top);
        split(column, row + top - 1, left, height - top + 1);
        split(column + left - 1, row + top - 1, width - left + 1, height - top + 1);
    }
    const std::vector<RTCGrid>& grids() const { return grids_; }

private:
    int64_t countHoles(int64_t column, int64_t row, int64_t width, int64_t height) const {
        int64_t holes = 0;
        for (int64_t j = row; j < row + height; ++j)
            for (int64_t i = column; i < column + width; ++i)
                holes += std::isnan(vertices_[3 * (j * lattice_.columns + i) + 2]) ? 1 : 0;
        return holes;
    }

    const Lattice& lattice_;
    const float* vertices_;
    std::vector<RTCGrid> grids_;
};

}  // namespace

bool EmbreeScene::countBytes(void* self, ssize_t bytes, bool) {
    auto* scene = static_cast<EmbreeScene*>(self);
    const int64_t now = scene->bytes_ += bytes;
    int64_t peak = scene->peakBytes_;
    while (now > peak && !scene->peakBytes_.compare_exchange_weak(peak, now)) {
    }
    return true;
}

Result<void> EmbreeScene::open(const EmbreeOptions& options) {
    const std::string isa = options.isa.empty() ? "" : ",isa=" + options.isa;
    device_ = rtcNewDevice(fmt::format("threads={},hugepages=1{}", options.threads, isa).c_str());
    if (device_ == nullptr)
        return makeError(ErrorCode::Resource, "Embree does not start (error {})",
                         static_cast<int>(rtcGetDeviceError(nullptr)));
    rtcSetDeviceMemoryMonitorFunction(device_, countBytes, this);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, options.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
    return {};
}

Result<RTCGeometry> EmbreeScene::makeGeometry(const ResidentTerrain& terrain, EmbreeGeometry kind) {
    const TerrainInfo& info = terrain.info();
    const Lattice lattice{info.scheme.columns, info.scheme.rows, info.worldFromLattice, origin_};
    const bool grid = kind == EmbreeGeometry::Grid;
    if (grid && std::max(lattice.columns, lattice.rows) > kLargestGridSide)
        return makeError(ErrorCode::Input, "'{}': an Embree grid has at most {} posts a side",
                         info.name, kLargestGridSide);
    RTCGeometry geometry =
        rtcNewGeometry(device_, grid ? RTC_GEOMETRY_TYPE_GRID : RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto vertexCount = static_cast<size_t>(lattice.columns * lattice.rows);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertexCount));
    if (vertices != nullptr) fillVertices(terrain, lattice, vertices);
    void* topology = nullptr;
    if (grid && vertices != nullptr) {
        GridSplitter splitter(lattice, vertices);
        splitter.split(0, 0, lattice.columns, lattice.rows);
        const std::vector<RTCGrid>& grids = splitter.grids();
        topology = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID,
                                           sizeof(RTCGrid), grids.size());
        if (topology != nullptr)
            std::copy(grids.begin(), grids.end(), static_cast<RTCGrid*>(topology));
    } else if (!grid) {
        const auto cells = static_cast<size_t>((lattice.columns - 1) * (lattice.rows - 1));
        topology = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                           3 * sizeof(uint32_t), 2 * cells);
        if (topology != nullptr && vertices != nullptr)
            fillTriangles(lattice, vertices, static_cast<uint32_t*>(topology));
    }
    if (vertices == nullptr || topology == nullptr) {
        rtcReleaseGeometry(geometry);
        return makeError(ErrorCode::Resource, "'{}': no memory for Embree's vertices", info.name);
    }
    return geometry;
}

Result<std::unique_ptr<EmbreeScene>> EmbreeScene::build(const ResidentTerrain& terrain,
                                                        const EmbreeOptions& options) {
    std::unique_ptr<EmbreeScene> made(new EmbreeScene);
    const TerrainInfo& info = terrain.info();
    const Vec2 middle =
        info.worldFromLattice.worldFromLattice({0.5 * static_cast<double>(info.scheme.columns - 1),
                                                0.5 * static_cast<double>(info.scheme.rows - 1)});
    made->origin_ = {middle.x, middle.y, 0.5 * static_cast<double>(info.minZ + info.maxZ)};
    TERRAY_TRY(made->open(options));
    auto geometry = made->makeGeometry(terrain, options.geometry);
    if (!geometry) return geometry.error();
    tbb::task_arena arena(options.threads);
    const Stopwatch watch;
    arena.execute([&] {
        rtcCommitGeometry(*geometry);
        rtcAttachGeometry(made->scene_, *geometry);
        rtcCommitScene(made->scene_);
    });
    made->figures_ = {watch.elapsedMs(), static_cast<uint64_t>(made->bytes_),
                      static_cast<uint64_t>(made->peakBytes_)};
    rtcReleaseGeometry(*geometry);
    const RTCError error = rtcGetDeviceError(made->device_);
    if (error != RTC_ERROR_NONE)
        return makeError(ErrorCode::Resource, "'{}': Embree's build fails (error {})", info.name,
                         static_cast<int>(error));
    return made;
}

EmbreeScene::~EmbreeScene() {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    if (device_ != nullptr) rtcReleaseDevice(device_);
}

}  // namespace terray::bench
