// SPDX-License-Identifier: Apache-2.0
// The public side of stores: DEMs opened and baked, stores verified.
#include "terray/bake.h"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>

#include "bake/bake_store.h"
#include "bake/export_cog.h"
#include "base/stopwatch.h"
#include "dataset/gdal_setup.h"
#include "raster/dem.h"
#include "raster/dem_mosaic.h"
#include "raster/mosaic.h"
#include "raster/photo_source.h"
#include "store/store.h"
#include "store/verify.h"

namespace terray {
namespace {

constexpr uint64_t kDefaultBytes = uint64_t{1} << 30, kLeastBytes = uint64_t{64} << 20;
constexpr uint64_t kGdalCacheBytes = uint64_t{64} << 20;
constexpr uint64_t kThreadBytes = uint64_t{28} << 20;  ///< a file while it is encoded, scratch
constexpr double kDefaultError = 0.01;

/// Metres; whole numbers keep their exact values, what lies between them gets a quarter of a step.
double maxErrorOf(const BakeOptions& options, const Dem& dem) {
    if (options.maxError) return *options.maxError;
    return dem.heightStep > 0 ? 0.25 * dem.heightStep : kDefaultError;
}

uint64_t workBytes(uint64_t asked, int threads) {
    const uint64_t budget = asked != 0 ? asked : kDefaultBytes;
    const uint64_t fixed = kGdalCacheBytes + static_cast<uint64_t>(threads) * kThreadBytes;
    return std::max(budget > fixed ? budget - fixed : 0, kLeastBytes);
}

/// A photo is wanted over the rectangle of a terrain's posts.
PhotoPlace placeOf(const TerrainInfo& info, const std::string& dataCrsWkt) {
    const auto right = static_cast<double>(info.scheme.columns - 1);
    const auto bottom = static_cast<double>(info.scheme.rows - 1);
    const Affine2& map = info.worldFromLattice;
    PhotoPlace place{info.crsWkt, info.metresPerCrsUnit, map.origin, map.origin, 0, dataCrsWkt};
    for (const LatticePoint corner : {LatticePoint{right, 0}, {0, bottom}, {right, bottom}}) {
        const Vec2 world = map.worldFromLattice(corner);
        place.worldMin = glm::min(place.worldMin, world);
        place.worldMax = glm::max(place.worldMax, world);
    }
    return place;
}

/// Adds the photo to a plan; empty without one.
Result<std::unique_ptr<PhotoSource>> addPhoto(const BakeOptions& options, BakePlan& plan) {
    if (options.open.photo.empty()) return std::unique_ptr<PhotoSource>();
    StoreManifest& m = plan.manifest;
    auto photo = openPhotoSource(options.open.photo, options.open, placeOf(m.info, m.dataCrsWkt));
    if (!photo) return photo.error();
    plan.photo = photo->get();
    m.photo = PhotoLayer{(*photo)->columns(), (*photo)->rows(), (*photo)->worldFromPixel(),
                         options.photoQuality, (*photo)->description()};
    auto state = stateOf(options.open.photo);
    if (!state) return state.error();
    m.photoSources.push_back(std::move(*state));
    return photo;
}

/// The source as mip 0, if it was asked for.
Result<void> addInPlace(std::span<const std::string> sources, const Dem& dem,
                        const BakeOptions& options, const std::string& out, StoreManifest& m) {
    if (!options.inPlace) return {};
    if (!dem.plainTiles || sources.size() > 1) {
        return makeError(ErrorCode::Input,
                         "--in-place: '{}' cannot be used as it is: {}; leave the option out",
                         sources[0], sources.size() > 1 ? "there are several" : dem.notPlain);
    }
    const PlainTiles& tiles = *dem.plainTiles;
    std::string path = tiles.path;
    if (!path.starts_with("/vsi")) {
        const auto from = std::filesystem::weakly_canonical(std::filesystem::absolute(out));
        const auto to = std::filesystem::canonical(path);
        path = to.lexically_relative(from).string();
    }
    m.inPlace = InPlaceSource{path, tiles.sampleType, tiles.nodata, tiles.base, tiles.shift};
    return {};
}

Result<BakePlan> planOf(std::span<const std::string> sources, const Dem& dem,
                        const std::string& out, const BakeOptions& options, int threads) {
    BakePlan plan;
    plan.source = dem.source.get();
    StoreManifest& m = plan.manifest;
    m.info = dem.source->info();
    m.info.name.clear();
    m.crsName = dem.facts.workingCrsName;
    m.dataCrsName = dem.facts.crsName;
    m.dataCrsWkt = dem.dataCrsWkt;
    m.maxError = maxErrorOf(options, dem);
    for (const std::string& source : sources) {
        auto state = stateOf(source);
        if (!state) return state.error();
        m.sources.push_back(std::move(*state));
    }
    for (const Assumption& assumption : dem.facts.assumptions) m.notes.push_back(assumption.text);
    TERRAY_TRY(addInPlace(sources, dem, options, out, m));
    plan.codec = {m.info.format, m.info.z0, m.info.zStep, m.maxError};
    plan.memoryBytes = workBytes(options.open.memoryBytes, threads);
    return plan;
}

Result<void> describeStore(const std::string& out, BakeReport& report) {
    const auto store = Store::open(out, UINT64_MAX);
    if (!store) return store.error();
    const StoreManifest& manifest = (*store)->manifest();
    report.columns = manifest.info.scheme.columns;
    report.rows = manifest.info.scheme.rows;
    report.mips = manifest.info.scheme.mipCount();
    report.maxError = manifest.maxError;
    if (manifest.photo) report.photo = manifest.photo->description;
    report.notes = manifest.notes;
    report.files = manifest.files.size() + 2;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(out)) {
        if (entry.is_regular_file()) report.bytes += entry.file_size();
    }
    return {};
}

/// The joined DEMs go by the first one's name in what is said of them.
std::string inUsersWords(std::string text, const Mosaic& mosaic,
                         std::span<const std::string> sources) {
    const std::string name = fmt::format("{} and {} more", sources[0], sources.size() - 1);
    const size_t at = text.find(mosaic.path());
    return at == std::string::npos ? text : text.replace(at, mosaic.path().size(), name);
}

Result<BakeReport> bakeInArena(std::span<const std::string> sources, const std::string& out,
                               const BakeOptions& options, int threads) {
    initialiseGdal(kGdalCacheBytes);
    std::unique_ptr<Mosaic> mosaic;
    if (sources.size() > 1) {
        auto joined = Mosaic::join(sources, options.open);
        if (!joined) return joined.error();
        mosaic = std::move(*joined);
    }
    const bool isUnlike = sources.size() > 1 && !mosaic;
    auto dem = isUnlike
                   ? openUnlikeDems(sources, options.open)
                   : openDem(mosaic ? mosaic->path() : sources[0], options.open, RangeScan::Always);
    if (!dem) {
        Error error = dem.error();
        if (mosaic) error.message = inUsersWords(error.message, *mosaic, sources);
        return error;
    }
    for (Assumption& assumption : dem->facts.assumptions) {
        if (mosaic) assumption.text = inUsersWords(assumption.text, *mosaic, sources);
    }
    auto plan = planOf(sources, *dem, out, options, threads);
    if (!plan) return plan.error();
    const auto photo = addPhoto(options, *plan);
    if (!photo) return photo.error();
    auto outcome = bakeStore(*plan, out, options.resume);
    if (!outcome) {
        const Error& error = outcome.error();
        if (error.code != ErrorCode::Interrupted) return error;
        return makeError(error.code, "interrupted; the same command goes on with '{}'", out);
    }
    if (!options.exportCog.empty()) {
        const auto store = Store::open(out, UINT64_MAX);
        if (!store) return store.error();
        TERRAY_TRY(exportCog(**store, options.exportCog));
    }
    BakeReport report;
    report.wasDone = outcome->wasDone;
    report.foundFiles = outcome->foundFiles;
    TERRAY_TRY(describeStore(out, report));
    return report;
}

Result<void> check(std::span<const std::string> sources, const std::string& out,
                   const BakeOptions& options) {
    if (sources.empty()) return makeError(ErrorCode::Usage, "name at least one DEM to bake");
    if (out.empty()) return makeError(ErrorCode::Usage, "-o: name the store to make");
    if (options.maxError && !(*options.maxError >= 0 && std::isfinite(*options.maxError))) {
        return makeError(ErrorCode::Usage,
                         "--max-error: {} is not a distance; give 0 or more metres",
                         *options.maxError);
    }
    if (options.photoQuality < 0 || options.photoQuality > 100) {
        return makeError(ErrorCode::Usage,
                         "--photo-quality: {} is out of range; give 1 to 100, or lossless",
                         options.photoQuality);
    }
    return {};
}

}  // namespace

Result<BakeReport> bake(std::span<const std::string> sources, const std::string& out,
                        const BakeOptions& options) {
    const Stopwatch watch;
    TERRAY_TRY(check(sources, out, options));
    try {
        const int cores = tbb::info::default_concurrency();
        const int threads = options.open.threads > 0 ? options.open.threads : cores;
        tbb::task_arena arena(threads);
        Result<BakeReport> report =
            arena.execute([&] { return bakeInArena(sources, out, options, threads); });
        if (report) report->seconds = watch.elapsedMs() * 1e-3;
        return report;
    } catch (const std::bad_alloc&) {
        return makeError(ErrorCode::Resource, "'{}': the machine ran out of memory", out);
    } catch (const std::filesystem::filesystem_error& why) {
        return makeError(ErrorCode::Failed, "'{}': {}", out, why.code().message());
    }
}

Result<VerifyReport> verifyStore(const std::string& store) {
    initialiseGdal(kGdalCacheBytes);
    auto check = checkStore(store);
    if (!check) return check.error();
    return VerifyReport{check->files, check->tiles, check->bytes, std::move(check->damage)};
}

}  // namespace terray
