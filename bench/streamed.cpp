// SPDX-License-Identifier: Apache-2.0
// Opening, looking and waiting.
#include "streamed.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"
#include "base/stopwatch.h"
#include "shade/shade_cache.h"
#include "stream/streamer.h"

namespace terray::bench {
namespace {

constexpr double kRefraction = 0.13, kEarthRadius = 6371000;
constexpr uint32_t kSeed = 1;
constexpr double kHalfFieldDeg = 30;
constexpr uint64_t kOther = uint64_t{64} << 20;  ///< of the budget, for codecs and frames

}  // namespace

Result<StreamedScene> openStreamed(int64_t width, int64_t height, int finestMip, bool isBare,
                                   uint64_t memoryBytes) {
    const Stopwatch watch;
    auto source = std::make_unique<TerabyteSource>(width, height, finestMip, kSeed, isBare);
    StreamedScene scene;
    scene.source = source.get();
    scene.bend = (1 - kRefraction) / (2 * kEarthRadius);
    const int kept = ShadeCache::overviewMip(source->info().scheme);
    BuildStats stats;
    const uint64_t tileBytes = memoryBytes - std::min(kOther, memoryBytes / 4);
    auto terrain = ResidentTerrain::stream(std::move(source), kept, tileBytes, stats);
    if (!terrain) return terrain.error();
    scene.terrain = std::move(*terrain);
    scene.startMs = watch.elapsedMs();
    return scene;
}

double groundHeight(const TerabyteSource& source, double x, double y) {
    const TerrainInfo& info = source.info();
    const LatticePoint at = info.worldFromLattice.latticeFromWorld({x, y});
    float z = 0;
    source.makePosts(0, std::lround(at.i), std::lround(at.j), 1, 1, &z);
    return static_cast<double>(z);
}

Camera cameraAt(const TerabyteSource& source, const Standpoint& from, int width, int height) {
    View view;
    view.width = width;
    view.height = height;
    view.fovDeg = degFromRad(2 * std::atan(std::tan(radFromDeg(kHalfFieldDeg)) * height / width));
    view.eye = Place{from.x, from.y, groundHeight(source, from.x, from.y) + from.above, false};
    view.headingDeg = from.headingDeg;
    view.pitchDeg = from.pitchDeg;
    SceneBox box;
    const TerrainInfo& info = source.info();
    const Vec2 corner =
        info.worldFromLattice.worldFromLattice({static_cast<double>(info.scheme.columns - 1), 0});
    box.max = {corner.x, corner.y, static_cast<double>(info.maxZ)};
    box.min.z = static_cast<double>(info.minZ);
    auto camera = makeCamera(view, box);
    TERRAY_ASSERT(camera.ok());
    return *camera;
}

Result<StreamedFrame> bringFrame(const StreamedScene& scene, const Camera& camera,
                                 double tolerancePx, bool isShaded) {
    constexpr double kMost = 16, kUnshaded = 1e6;
    const Stopwatch watch;
    StreamedFrame frame;
    CutOptions options;
    options.bend = scene.bend;
    options.tolerancePx = tolerancePx;
    if (!isShaded) options.sampleShare = kUnshaded;
    Streamer& streamer = *scene.terrain->streamer();
    std::vector<TileId> wanted = wantedTiles(*scene.terrain, camera, options);
    for (int k = 0; k < 3 && !streamer.fits(wanted); ++k) {
        options.sampleShare *= 2;
        wanted = wantedTiles(*scene.terrain, camera, options);
    }
    while (!streamer.fits(wanted) && options.tolerancePx < kMost * tolerancePx) {
        options.tolerancePx *= 1.25;
        wanted = wantedTiles(*scene.terrain, camera, options);
    }
    if (!streamer.fits(wanted))
        return makeError(
            ErrorCode::Input,
            "--memory: {} tiles are wanted and {} fit; give more, or a smaller picture",
            wanted.size(), streamer.room());
    TERRAY_TRY(streamer.bring(wanted));
    frame.cut = selectCut(*scene.terrain, camera, options);
    frame.tolerancePx = options.tolerancePx;
    frame.wanted = wanted.size();
    frame.bringMs = watch.elapsedMs();
    return frame;
}

}  // namespace terray::bench
