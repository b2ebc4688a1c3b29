// SPDX-License-Identifier: Apache-2.0
// Opening a terrain: header, memory check, tiles, photo.
#include "terray/terrain.h"

#include <oneapi/tbb/info.h>

#include <algorithm>
#include <new>

#include "base/interrupt.h"
#include "base/log.h"
#include "base/stopwatch.h"
#include "engine/describe.h"
#include "engine/memory_rule.h"
#include "engine/open_store.h"
#include "engine/terrain_state.h"
#include "raster/dem.h"
#include "shade/shade.h"
#include "store/photo_reader.h"

namespace terray {
namespace {

Result<void> loadPhotoOf(Terrain::State& state, const OpenOptions& options, uint64_t maxBytes) {
    if (options.photo.empty()) return {};
    const TerrainInfo& info = state.resident->info();
    // Shading keeps coarser mips of the photo: a third more.
    auto photo = loadPhoto(options.photo, options, info.crsWkt, info.metresPerCrsUnit,
                           state.worldMin(), state.worldMax(), maxBytes / 4 * 3, state.dataCrsWkt);
    if (!photo) return photo.error();
    state.photo = std::move(*photo);
    state.facts.photo = state.photo->description;
    return {};
}

/// What is the same for a DEM and a store once its tiles are resident.
Result<void> finish(Terrain::State& state, const std::string& source, const OpenOptions& options,
                    uint64_t photoBytes) {
    state.sunSweeps = std::make_shared<SunSweepCache>(mostSunSweepBytes(*state.resident));
    state.ground = std::make_unique<FinestGround>(*state.resident);
    describeLattice(state.resident->info(), state.facts);
    state.facts.hasRange = true;
    state.facts.minHeight = static_cast<double>(state.resident->info().minZ);
    state.facts.maxHeight = static_cast<double>(state.resident->info().maxZ);
    state.facts.holes = static_cast<int64_t>(state.build.holes);
    if (state.isEmpty())
        log::warning("'{}' has no sample with a height: there is nothing to see", source);
    return loadPhotoOf(state, options, photoBytes);
}

/// The tiles of a store: all of them, or on demand. Bytes that are left to a photo.
Result<uint64_t> makeResident(Terrain::State& state, std::unique_ptr<Store> store,
                              const OpenOptions& options, uint64_t physical, bool hasPhoto) {
    const uint64_t required = ResidentTerrain::requiredBytes(store->info());
    // Of a remote store only what is seen is read.
    if (!store->isRemote() && fitsWhole(required, options.memoryBytes, physical)) {
        auto plan = planMemory(store->path(), required, options.memoryBytes, physical);
        if (!plan) return plan.error();
        auto resident = ResidentTerrain::build(*store, plan->budget, state.build);
        if (!resident) return resident.error();
        state.resident = std::move(*resident);
        return plan->photo;
    }
    const StreamPlan plan = planStreaming(hasPhoto, options.memoryBytes, physical);
    const int kept = ShadeCache::overviewMip(store->info().scheme);
    auto resident = ResidentTerrain::stream(std::move(store), kept, plan.tiles, state.build);
    if (!resident) return resident.error();
    state.resident = std::move(*resident);
    return plan.photo;
}

Result<void> openStoreInto(Terrain::State& state, const std::string& source,
                           const OpenOptions& options, uint64_t physical) {
    const Stopwatch watch;
    auto store = openStore(source, options);
    if (!store) return store.error();
    const double headerMs = watch.elapsedMs();
    const StoreManifest manifest = (*store)->manifest();
    const bool showsOwnPhoto = manifest.photo && options.photo.empty() && options.storedPhoto;
    state.dataCrsWkt = manifest.dataCrsWkt;
    state.facts = describeStore(**store);
    state.facts.photo.clear();  // unless it is loaded
    auto photoBytes = makeResident(state, std::move(*store), options, physical,
                                   showsOwnPhoto || !options.photo.empty());
    if (!photoBytes) return photoBytes.error();
    const Stopwatch photoWatch;
    TERRAY_TRY(finish(state, source, options, *photoBytes));
    if (showsOwnPhoto) {
        auto photo = ResidentPhoto::open(std::make_unique<StorePhoto>(source, *manifest.photo),
                                         *photoBytes, loaderThreads());
        if (!photo) return photo.error();
        state.storedPhoto = std::move(*photo);
        state.facts.photo = state.storedPhoto->description();
    }
    state.build.loadMs += headerMs + photoWatch.elapsedMs();
    return {};
}

Result<void> openInto(Terrain::State& state, const std::string& source,
                      const OpenOptions& options) {
    const Stopwatch watch;
    const uint64_t physical = physicalMemoryBytes();
    initialiseGdal(gdalCacheBytes(options.memoryBytes, physical));
    if (isStore(source)) return openStoreInto(state, source, options, physical);
    auto dem = openDem(source, options);
    if (!dem) return dem.error();
    const uint64_t required = ResidentTerrain::requiredBytes(dem->source->info());
    auto plan = planMemory(source, required, options.memoryBytes, physical);
    if (!plan) return plan.error();
    const double headerMs = watch.elapsedMs();

    auto resident = ResidentTerrain::build(*dem->source, plan->budget, state.build);
    if (!resident) return resident.error();
    state.resident = std::move(*resident);
    state.dataCrsWkt = dem->dataCrsWkt;
    state.facts = std::move(dem->facts);
    const Stopwatch photoWatch;
    TERRAY_TRY(finish(state, source, options, plan->photo));
    state.build.loadMs += headerMs + photoWatch.elapsedMs();
    if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
    return {};
}

}  // namespace

Result<Terrain> Terrain::open(const std::string& source, const OpenOptions& options) {
    try {
        if (options.threads < 0)
            return makeError(ErrorCode::Usage,
                             "--threads: {} is not a number of threads; give 1 or more",
                             options.threads);
        auto state = std::make_unique<State>();
        const int cores = tbb::info::default_concurrency();
        state->threads = options.threads > 0 ? std::min(options.threads, cores) : cores;
        state->arena.initialize(state->threads);
        Result<void> opened;
        state->arena.execute([&] { opened = openInto(*state, source, options); });
        if (!opened) return opened.error();
        return Terrain(std::move(state));
    } catch (const std::bad_alloc&) {
        return makeError(ErrorCode::Resource, "'{}': the machine ran out of memory", source);
    }
}

Terrain::Terrain(std::unique_ptr<State> state) : state_(std::move(state)) {}
Terrain::~Terrain() = default;
Terrain::Terrain(Terrain&&) noexcept = default;
Terrain& Terrain::operator=(Terrain&&) noexcept = default;

const SourceInfo& Terrain::info() const { return state_->facts; }

Result<GeoFrame> Terrain::State::makeGeoFrame() const {
    return GeoFrame::make(dataCrsWkt, resident->info().crsWkt);
}

namespace {

template <class Pick>
Vec2 cornerOf(const TerrainInfo& info, Pick pick) {
    const double right = static_cast<double>(info.scheme.columns - 1);
    const double bottom = static_cast<double>(info.scheme.rows - 1);
    const Affine2& map = info.worldFromLattice;
    Vec2 corner = map.worldFromLattice({0, 0});
    for (const LatticePoint p : {LatticePoint{right, 0}, {0, bottom}, {right, bottom}}) {
        const Vec2 w = map.worldFromLattice(p);
        corner = {pick(corner.x, w.x), pick(corner.y, w.y)};
    }
    return corner;
}

}  // namespace

bool Terrain::State::isEmpty() const {
    const TilingScheme& scheme = resident->info().scheme;
    return build.holes >= static_cast<uint64_t>(scheme.columns * scheme.rows);
}

Vec2 Terrain::State::worldMin() const {
    return cornerOf(resident->info(), [](double a, double b) { return std::min(a, b); });
}

Vec2 Terrain::State::worldMax() const {
    return cornerOf(resident->info(), [](double a, double b) { return std::max(a, b); });
}

}  // namespace terray
