// SPDX-License-Identifier: Apache-2.0
// loadPhoto: which pixels of the photo lie over the terrain, on which lattice they come, and how.
#include "raster/photo.h"

#include <cpl_conv.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "raster/georeference.h"
#include "raster/photo_pixels.h"
#include "raster/photo_resample.h"
#include "raster/raster_header.h"
#include "raster/source_map.h"

namespace terray {
namespace {

constexpr int kGrid = 33;   // places a side at which extents are mapped
constexpr int kMargin = 3;  // pixels around what is needed, for the filters

struct Box {
    Vec2 lo{std::numeric_limits<double>::infinity()}, hi{-std::numeric_limits<double>::infinity()};
    void add(Vec2 p) { lo = glm::min(lo, p), hi = glm::max(hi, p); }
    bool isEmpty() const { return !(lo.x < hi.x && lo.y < hi.y); }
    Vec2 size() const { return hi - lo; }
};

Box overlap(const Box& a, const Box& b) { return {glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)}; }

/// The bounds of a mapped box; `complete` is false where the map had no answer.
template <class Map>
Box mapBox(const Box& box, const Map& map, bool& complete) {
    Box mapped;
    complete = true;
    for (int j = 0; j < kGrid; ++j) {
        for (int i = 0; i < kGrid; ++i) {
            const Vec2 p = map(box.lo + box.size() * Vec2(i, j) / double(kGrid - 1));
            if (std::isfinite(p.x) && std::isfinite(p.y)) {
                mapped.add(p);
            } else {
                complete = false;
            }
        }
    }
    return mapped;
}

/// A photo opened, with all that the ways to read it have in common.
struct Opened {
    std::string path;
    DatasetHandle dataset;
    RasterHeader header;  // name, transform, crsWkt only
    Box world;            // the rectangle asked for
    uint64_t maxBytes = 0;
    bool takesTerrainsCrs = false;  // it has coordinates but names no CRS

    int columns() const { return dataset->GetRasterXSize(); }
    int rows() const { return dataset->GetRasterYSize(); }
    Box raster() const { return {{0, 0}, {columns(), rows()}}; }
};

const char* assumption(const Opened& photo) {
    return photo.takesTerrainsCrs
               ? " (it has no CRS: its coordinates are taken as those of the terrain)"
               : "";
}

Error doesNotTouch(const Opened& photo) {
    return makeError(ErrorCode::Input,
                     "the photo '{}' does not touch the terrain{}; give one that lies over it, or "
                     "set its georeference with gdal_edit",
                     photo.path, assumption(photo));
}

/// Pixels (not samples) of the raster's corner-based geotransform.
Affine2 dataFromPixel(const Opened& photo) {
    const std::array<double, 6>& t = *photo.header.transform;
    return {{t[0], t[3]}, {t[1], t[4]}, {t[2], t[5]}};
}

/// Whole pixels over a box of pixels, with a margin, inside the raster; empty: width 0.
PhotoWindow windowOver(const Opened& photo, Box pixels, double margin) {
    pixels.lo -= margin, pixels.hi += margin;
    pixels = overlap(pixels, photo.raster());
    PhotoWindow window;
    if (pixels.isEmpty()) return window;
    window.x = static_cast<int>(std::floor(pixels.lo.x));
    window.y = static_cast<int>(std::floor(pixels.lo.y));
    window.width = static_cast<int>(std::ceil(pixels.hi.x)) - window.x;
    window.height = static_cast<int>(std::ceil(pixels.hi.y)) - window.y;
    window.outWidth = window.width;
    window.outHeight = window.height;
    return window;
}

double pixelCount(const PhotoWindow& w) {
    return static_cast<double>(w.width) * static_cast<double>(w.height);
}

int shrink(double length, double factor) {
    return std::max(1, static_cast<int>(std::ceil(length / factor)));
}

/// Places of the window's (reduced) samples: sample (i, j) is the centre of its pixels.
Affine2 placesOfSamples(const Affine2& pixels, const PhotoWindow& window) {
    const double stepX = static_cast<double>(window.width) / window.outWidth;
    const double stepY = static_cast<double>(window.height) / window.outHeight;
    return {pixels.worldFromLattice({window.x + stepX / 2, window.y + stepY / 2}),
            pixels.column * stepX, pixels.row * stepY};
}

Affine2 scaled(const Affine2& map, double factor) {
    return {map.origin * factor, map.column * factor, map.row * factor};
}

std::string reducedBy(double factor) {
    return factor > 1 ? fmt::format(", reduced 1:{:.3g} to fit the memory", factor) : "";
}

/// Reads the pixels as they lie: same CRS, or stretched over the terrain.
Result<Photo> loadDirect(Opened& photo, PhotoPixels& pixels, const Affine2& worldFromPixel,
                         const std::string& how) {
    bool complete = false;
    const Box needed = mapBox(
        photo.world,
        [&](Vec2 p) {
            const LatticePoint place = worldFromPixel.latticeFromWorld(p);
            return Vec2(place.i, place.j);
        },
        complete);
    if (overlap(needed, photo.raster()).isEmpty()) {
        return doesNotTouch(photo);
    }
    PhotoWindow window = windowOver(photo, needed, kMargin);
    const double factor =
        std::sqrt(std::max(1.0, 4 * pixelCount(window) / static_cast<double>(photo.maxBytes)));
    window.outWidth = shrink(window.width, factor);
    window.outHeight = shrink(window.height, factor);

    Photo result;
    result.width = window.outWidth;
    result.height = window.outHeight;
    result.rgba.resize(static_cast<size_t>(result.width) * static_cast<size_t>(result.height) * 4);
    result.worldFromPixel = placesOfSamples(worldFromPixel, window);
    TERRAY_TRY(pixels.read(window, result.rgba.data()));
    result.description =
        fmt::format("{}: {} x {} pixels, {}, {}{}{}", photo.path, result.width, result.height,
                    pixels.description(), how, assumption(photo), reducedBy(factor));
    return result;
}

/// The lattice of a warped photo and the window of the file that it needs.
struct Warp {
    PhotoWindow window;
    WarpPlan plan;  // CRSs, dataFromSample of the window, lattice
    double factor = 1;
};

/// Ground size of a pixel at the middle of a window: the shorter side, metres.
double groundSize(const GeoFrame& frame, const Affine2& data, const PhotoWindow& window) {
    const Vec2 middle(window.x + window.width / 2.0, window.y + window.height / 2.0);
    const auto world = [&](double i, double j) {
        const Result<Vec2> place = frame.worldFromData(data.worldFromLattice({i, j}));
        return place ? *place : Vec2(std::numeric_limits<double>::quiet_NaN());
    };
    const Vec2 here = world(middle.x, middle.y);
    return std::min(glm::length(world(middle.x + 1, middle.y) - here),
                    glm::length(world(middle.x, middle.y + 1) - here));
}

Result<Warp> planWarp(const Opened& photo, const std::string& workingCrs) {
    Warp warp;
    const Affine2 data = dataFromPixel(photo);
    warp.plan.dataCrs = photo.header.crsWkt;
    warp.plan.workingCrs = workingCrs;
    warp.plan.dataCentre = data.worldFromLattice({photo.columns() / 2.0, photo.rows() / 2.0});
    const Result<GeoFrame> frame = warp.plan.makeFrame();
    if (!frame) return frame.error();
    const Vec2 nowhere(std::numeric_limits<double>::quiet_NaN());

    bool complete = false;
    const auto pixelFromWorld = [&](Vec2 p) {
        const Result<Vec2> place = frame->dataFromWorld(p);
        if (!place) return nowhere;
        const LatticePoint pixel = data.latticeFromWorld(*place);
        return Vec2(pixel.i, pixel.j);
    };
    const Box needed = mapBox(photo.world, pixelFromWorld, complete);
    if (overlap(needed, photo.raster()).isEmpty()) return doesNotTouch(photo);
    const Vec2 size = needed.size();
    warp.window = windowOver(photo, needed, kMargin + 0.02 * std::max(size.x, size.y));

    const Box windowBox{{warp.window.x, warp.window.y},
                        {warp.window.x + warp.window.width, warp.window.y + warp.window.height}};
    const auto worldFromPixel = [&](Vec2 p) {
        const Result<Vec2> place = frame->worldFromData(data.worldFromLattice({p.x, p.y}));
        return place ? *place : nowhere;
    };
    const Box footprint = mapBox(windowBox, worldFromPixel, complete);
    const Box covered = complete ? overlap(photo.world, footprint) : photo.world;
    double step = groundSize(*frame, data, warp.window);
    if (covered.isEmpty() || !(step > 0)) return doesNotTouch(photo);

    const Vec2 extent = covered.size();
    const double latticePixels = std::ceil(extent.x / step) * std::ceil(extent.y / step);
    const double bytes = 4 * (pixelCount(warp.window) + latticePixels);
    warp.factor = std::sqrt(std::max(1.0, bytes / static_cast<double>(photo.maxBytes)));
    warp.window.outWidth = shrink(warp.window.width, warp.factor);
    warp.window.outHeight = shrink(warp.window.height, warp.factor);
    step *= warp.factor;
    warp.plan.columns = shrink(extent.x, step);
    warp.plan.rows = shrink(extent.y, step);
    warp.plan.dataFromSample = placesOfSamples(data, warp.window);
    warp.plan.worldFromLattice = {
        {covered.lo.x + step / 2, covered.hi.y - step / 2}, {step, 0}, {0, -step}};
    return warp;
}

Result<Photo> loadWarped(Opened& photo, PhotoPixels& pixels, const std::string& workingCrs) {
    const Result<Warp> warp = planWarp(photo, workingCrs);
    if (!warp) return warp.error();
    const PhotoWindow& window = warp->window;
    std::vector<uint8_t> source(static_cast<size_t>(window.outWidth) *
                                static_cast<size_t>(window.outHeight) * 4);
    TERRAY_TRY(pixels.read(window, source.data()));
    const Result<SourceMap> map = SourceMap::make(warp->plan);
    if (!map) return map.error();
    Photo result;
    result.width = static_cast<int>(warp->plan.columns);
    result.height = static_cast<int>(warp->plan.rows);
    result.worldFromPixel = warp->plan.worldFromLattice;
    result.rgba.resize(static_cast<size_t>(result.width) * static_cast<size_t>(result.height) * 4);
    resamplePhoto({source.data(), window.outWidth, window.outHeight}, *map, result);
    result.description =
        fmt::format("{}: {} x {} pixels of {:.4g} m, {}, warped to the working CRS{}{}", photo.path,
                    result.width, result.height, warp->plan.worldFromLattice.column.x,
                    pixels.description(), assumption(photo), reducedBy(warp->factor));
    return result;
}

Result<Opened> openPhoto(const std::string& path, Vec2 worldMin, Vec2 worldMax, uint64_t maxBytes) {
    Result<OpenedRaster> opened = openRaster(path);
    if (!opened) return opened.error();
    Opened photo{path, std::move(opened->dataset), {}, {worldMin, worldMax}, maxBytes};
    photo.header.name = path;
    TERRAY_TRY(readGeoreference(*photo.dataset, photo.header));
    const bool hasMore =
        photo.dataset->GetGCPCount() > 0 || photo.dataset->GetMetadata("RPC") != nullptr;
    if (!photo.header.transform && hasMore) {
        return makeError(
            ErrorCode::Input,
            "the photo '{}' is placed by control points or RPCs that are no plane map; "
            "make a map of it first with gdalwarp",
            path);
    }
    return photo;
}

/// The photo's rows run from the top of the rectangle, its pixels fill it.
Affine2 stretchedOver(const Opened& photo) {
    const Vec2 size = photo.world.size();
    return {{photo.world.lo.x, photo.world.hi.y},
            {size.x / photo.columns(), 0},
            {0, -size.y / photo.rows()}};
}

}  // namespace

Result<Photo> loadPhoto(const std::string& path, const OpenOptions& options,
                        const std::string& workingCrsWkt, double metresPerCrsUnit, Vec2 worldMin,
                        Vec2 worldMax, uint64_t maxBytes, const std::string& dataCrsWkt) {
    ensureGdal();
    // for this thread and call: decode on all cores, and copy uncompressed GeoTIFFs past the cache
    const CPLConfigOptionSetter allCores("GDAL_NUM_THREADS", "ALL_CPUS", true);
    const CPLConfigOptionSetter pastTheCache("GTIFF_DIRECT_IO", "YES", true);
    Result<Opened> photo = openPhoto(path, worldMin, worldMax, std::max<uint64_t>(maxBytes, 4096));
    if (!photo) return photo.error();
    Result<PhotoPixels> pixels = PhotoPixels::make(*photo->dataset, path, options);
    if (!pixels) return pixels.error();
    if (!photo->header.transform) {
        return loadDirect(*photo, *pixels, stretchedOver(*photo),
                          "without georeference, stretched over the terrain");
    }
    const Affine2 asWorld = scaled(dataFromPixel(*photo), metresPerCrsUnit);
    photo->takesTerrainsCrs = photo->header.crsWkt.empty();
    if (photo->takesTerrainsCrs) photo->header.crsWkt = dataCrsWkt;
    const std::string& crs = photo->header.crsWkt;
    if (crs.empty() || workingCrsWkt.empty()) {
        const char* const how = crs.empty() == workingCrsWkt.empty()
                                    ? "laid by its coordinates"
                                    : "laid by its coordinates (only one of photo and terrain has "
                                      "a CRS)";
        return loadDirect(*photo, *pixels, asWorld, how);
    }
    const Result<GeoFrame> frame = GeoFrame::make(crs, workingCrsWkt);
    if (!frame) {
        return makeError(frame.error().code, "the photo '{}': {}", path, frame.error().message);
    }
    if (frame->isSameCrs()) return loadDirect(*photo, *pixels, asWorld, "in the working CRS");
    return loadWarped(*photo, *pixels, workingCrsWkt);
}

}  // namespace terray
