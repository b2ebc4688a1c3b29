// SPDX-License-Identifier: Apache-2.0
// What fits, what is asked for instead, and rays that are followed from tile to tile.
#include "engine/residency.h"

#include <algorithm>
#include <cmath>

#include "base/interrupt.h"
#include "base/log.h"
#include "kernel/trace.h"
#include "stream/ray_tiles.h"
#include "stream/streamer.h"

namespace terray {
namespace {

constexpr int kCoarserShading = 3;        ///< mips that shading may do without
constexpr double kStep = 1.25;            ///< of the tolerance
constexpr double kLargestTolerance = 64;  ///< pixels
constexpr double kEasyShare = 0.85;       ///< of the room that is more than enough
constexpr size_t kTilesAtOnce = 12;       ///< of a ray

/// The tile of mip 0 at a lattice place; mip -1 outside.
TileId tileAt(const TilingScheme& scheme, double i, double j) {
    const double right = static_cast<double>(scheme.columns - 1);
    const double bottom = static_cast<double>(scheme.rows - 1);
    if (!(i >= 0 && j >= 0 && i <= right && j <= bottom)) return {-1, 0, 0};
    const int x = static_cast<int>(i) >> kTileCellsLog2, y = static_cast<int>(j) >> kTileCellsLog2;
    return {0, std::min(x, scheme.tilesX(0) - 1), std::min(y, scheme.tilesY(0) - 1)};
}

/// With so many steps less is asked for: first of the relief that shading shows, then of the
/// tolerance.
CutOptions reducedBy(int steps, CutOptions cut) {
    for (int k = 0; k < steps; ++k)
        (k < kCoarserShading ? cut.sampleShare : cut.tolerancePx) *=
            k < kCoarserShading ? 2 : kStep;
    return cut;
}

bool mayReduce(int steps, const CutOptions& asked) {
    if (steps < kCoarserShading) return true;
    return asked.tolerancePx > 0 && reducedBy(steps, asked).tolerancePx < kLargestTolerance;
}

/// What a picture wants, or less where there is no room for it. `steps`: of reduction. Pictures
/// that do not wait begin with those of the last one, and go back by one where there is more than
/// room enough: a resolution that comes and goes would show, and tiles with it.
Result<std::vector<TileId>> tilesThatFit(const ResidentTerrain& terrain, const Camera& camera,
                                         bool waits, int& steps, CutOptions& cut) {
    const Streamer& streamer = *terrain.streamer();
    const CutOptions asked = cut;
    const auto wantedAt = [&](int by) {
        return wantedTiles(terrain, camera, reducedBy(by, asked));
    };
    if (waits) steps = 0;
    const int before = steps;
    std::vector<TileId> wanted = wantedAt(steps);
    while (!streamer.fits(wanted) && mayReduce(steps, asked)) wanted = wantedAt(++steps);
    if (steps == before && steps > 0) {
        std::vector<TileId> more = wantedAt(steps - 1);
        if (static_cast<double>(more.size()) < kEasyShare * static_cast<double>(streamer.room())) {
            wanted = std::move(more);
            --steps;
        }
    }
    cut = reducedBy(steps, asked);
    if (!streamer.fits(wanted)) {
        const auto first = static_cast<double>(wantedAt(0).size());
        return makeError(ErrorCode::Input,
                         "this picture of '{}' takes {:.0f} tiles, but memory holds {}; raise "
                         "--memory to {:.1f} times as much",
                         terrain.info().name, first, streamer.room(),
                         1.1 * first / static_cast<double>(streamer.room()));
    }
    // The same words for every frame of a flight.
    if (cut.tolerancePx > asked.tolerancePx) {
        log::warning(
            "memory holds {} tiles, too few for a tolerance of {:.2g} pixels: drawn with a larger "
            "one (--stats tells which; raise --memory)",
            streamer.room(), asked.tolerancePx);
    } else if (steps > 0) {
        log::note(
            "memory holds {} tiles: relief that shows in shading alone is coarser (raise --memory)",
            streamer.room());
    }
    return wanted;
}

}  // namespace

Result<BroughtTiles> bringTiles(const ResidentTerrain& terrain, const Camera& camera,
                                const std::optional<Camera>& soon, const RenderOptions& options,
                                int& steps, CutOptions& cut) {
    Streamer* streamer = terrain.streamer();
    if (streamer == nullptr) return BroughtTiles{};
    auto wanted = tilesThatFit(terrain, camera, options.waitForTiles, steps, cut);
    if (!wanted) return wanted.error();
    const StreamFigures before = streamer->figures();
    if (options.waitForTiles) {
        const Result<void> brought = streamer->bring(*wanted);
        const bool isBroken = !brought && brought.error().code != ErrorCode::Interrupted;
        if (isBroken && !options.allowMissing)
            return makeError(ErrorCode::Failed, "{} (--allow-missing draws a coarser one instead)",
                             brought.error().message);
        if (!brought && !isBroken) return brought.error();
    }
    std::vector<TileId> next;
    if (soon) next = wantedTiles(terrain, *soon, cut);
    const uint64_t absent = streamer->update(*wanted, next);
    const StreamFigures& after = streamer->figures();
    const TileFigures figures{wanted->size(),
                              after.loaded - before.loaded,
                              after.evicted - before.evicted,
                              absent,
                              after.bytesRead - before.bytesRead,
                              after.latency.quantile(0.5),
                              after.latency.quantile(0.99)};
    return BroughtTiles{figures, std::move(*wanted)};
}

FinestGround::FinestGround(const ResidentTerrain& terrain) : terrain_(terrain) {
    if (terrain.streamer() == nullptr) cut_ = finestCut(terrain, kSurfaceBilinear);
}

SurfaceCell FinestGround::cellAt(double i, double j) {
    Streamer* streamer = terrain_.streamer();
    if (streamer == nullptr) return surfaceCellAt(cut_.cut(), i, j);
    const TileId id = tileAt(terrain_.info().scheme, i, j);
    if (id.mip < 0) return {};
    if (version_ == streamer->version()) {
        const SurfaceCell cell = surfaceCellAt(cut_.cut(), i, j);
        if (cell.slot != kNoSlot && cell.mip == 0) return cell;
    }
    const bool isHere = streamer->bring(std::span(&id, 1)).ok();
    cut_ = isHere ? cutOf(terrain_, kSurfaceBilinear, std::span(&id, 1))
                  : finestCut(terrain_, kSurfaceBilinear);
    version_ = streamer->version();
    return surfaceCellAt(cut_.cut(), i, j);
}

Result<void> firstHitsFar(
    const ResidentTerrain& terrain, SurfaceKind surface, std::span<const Ray> rays,
    const std::function<Result<void>(size_t, const TerrainCut&, const Hit&)>& found) {
    Streamer& streamer = *terrain.streamer();
    const size_t atOnce = std::min(kTilesAtOnce, streamer.room());
    for (size_t k = 0; k < rays.size(); ++k) {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        const std::vector<RayTile> along = tilesAlong(terrain, rays[k], surface);
        // Each part begins with the last tile of the one before: walls stand between tiles.
        for (size_t begin = 0; begin < along.size(); begin += atOnce - 1) {
            const size_t end = std::min(begin + atOnce, along.size());
            std::vector<TileId> tiles;
            for (size_t n = begin; n < end; ++n) tiles.push_back(along[n].id);
            TERRAY_TRY(streamer.bring(tiles));
            const FrameCut cut = cutOf(terrain, surface, tiles);
            Hit hit{};
            TraceCounters counters;
            firstHits(cut.cut(), rays.subspan(k, 1), std::span(&hit, 1), counters);
            const bool isLast = end == along.size();
            if (isHit(hit) && (isLast || static_cast<double>(hit.t) < along[end].enter)) {
                TERRAY_TRY(found(k, cut.cut(), hit));
                break;
            }
            if (isLast) break;
        }
    }
    return {};
}

}  // namespace terray
