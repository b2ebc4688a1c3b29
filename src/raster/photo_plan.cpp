// SPDX-License-Identifier: Apache-2.0
// Planning a photo: same lattice as the file where CRSs agree, else one that is north up.
#include "raster/photo_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raster/georeference.h"

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

Box raster(const PhotoPlan& photo) {
    return {{0, 0}, {photo.dataset->GetRasterXSize(), photo.dataset->GetRasterYSize()}};
}

Box worldOf(const PhotoPlace& place) { return {place.worldMin, place.worldMax}; }

const char* assumption(const PhotoPlan& photo) {
    return photo.takesTerrainsCrs
               ? " (it has no CRS: its coordinates are taken as those of the terrain)"
               : "";
}

Error doesNotTouch(const PhotoPlan& photo) {
    return makeError(ErrorCode::Input,
                     "the photo '{}' does not touch the terrain{}; give one that lies over it, or "
                     "set its georeference with gdal_edit",
                     photo.path, assumption(photo));
}

/// Pixels (not samples) of the raster's corner-based geotransform.
Affine2 dataFromPixel(const PhotoPlan& photo) {
    const std::array<double, 6>& t = *photo.header.transform;
    return {{t[0], t[3]}, {t[1], t[4]}, {t[2], t[5]}};
}

/// Whole pixels over a box of pixels, with a margin, inside the raster; empty: width 0.
PhotoWindow windowOver(const PhotoPlan& photo, Box pixels, double margin) {
    pixels.lo -= margin, pixels.hi += margin;
    pixels = overlap(pixels, raster(photo));
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

/// The pixels as they lie: same CRS, or stretched over the terrain.
Result<void> planDirect(const PhotoPlace& place, const Affine2& worldFromPixel, const char* how,
                        PhotoPlan& photo) {
    bool complete = false;
    const Box needed = mapBox(
        worldOf(place),
        [&](Vec2 p) {
            const LatticePoint pixel = worldFromPixel.latticeFromWorld(p);
            return Vec2(pixel.i, pixel.j);
        },
        complete);
    if (overlap(needed, raster(photo)).isEmpty()) return doesNotTouch(photo);
    PhotoWindow& window = photo.window;
    window = windowOver(photo, needed, kMargin);
    photo.factor =
        std::sqrt(std::max(1.0, 4 * pixelCount(window) / static_cast<double>(place.maxBytes)));
    window.outWidth = shrink(window.width, photo.factor);
    window.outHeight = shrink(window.height, photo.factor);
    photo.columns = window.outWidth;
    photo.rows = window.outHeight;
    photo.worldFromPixel = placesOfSamples(worldFromPixel, window);
    photo.how = how;
    return {};
}

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

Result<void> planWarp(const PhotoPlace& place, PhotoPlan& photo) {
    WarpPlan& warp = photo.warp.emplace();
    PhotoWindow& window = photo.window;
    const Box world = worldOf(place), pixels = raster(photo);
    const Affine2 data = dataFromPixel(photo);
    warp.dataCrs = photo.header.crsWkt;
    warp.workingCrs = place.workingCrsWkt;
    warp.dataCentre = data.worldFromLattice({0.5 * pixels.hi.x, 0.5 * pixels.hi.y});
    const Result<GeoFrame> frame = warp.makeFrame();
    if (!frame) return frame.error();
    const Vec2 nowhere(std::numeric_limits<double>::quiet_NaN());

    bool complete = false;
    const auto pixelFromWorld = [&](Vec2 p) {
        const Result<Vec2> found = frame->dataFromWorld(p);
        if (!found) return nowhere;
        const LatticePoint pixel = data.latticeFromWorld(*found);
        return Vec2(pixel.i, pixel.j);
    };
    const Box needed = mapBox(world, pixelFromWorld, complete);
    if (overlap(needed, pixels).isEmpty()) return doesNotTouch(photo);
    const Vec2 size = needed.size();
    window = windowOver(photo, needed, kMargin + 0.02 * std::max(size.x, size.y));

    const Box windowBox{{window.x, window.y}, {window.x + window.width, window.y + window.height}};
    const auto worldFromPixel = [&](Vec2 p) {
        const Result<Vec2> found = frame->worldFromData(data.worldFromLattice({p.x, p.y}));
        return found ? *found : nowhere;
    };
    const Box footprint = mapBox(windowBox, worldFromPixel, complete);
    const Box covered = complete ? overlap(world, footprint) : world;
    double step = groundSize(*frame, data, window);
    if (covered.isEmpty() || !(step > 0)) return doesNotTouch(photo);

    const Vec2 extent = covered.size();
    const double latticePixels = std::ceil(extent.x / step) * std::ceil(extent.y / step);
    const double bytes = 4 * (pixelCount(window) + latticePixels);
    photo.factor = std::sqrt(std::max(1.0, bytes / static_cast<double>(place.maxBytes)));
    window.outWidth = shrink(window.width, photo.factor);
    window.outHeight = shrink(window.height, photo.factor);
    step *= photo.factor;
    warp.columns = shrink(extent.x, step);
    warp.rows = shrink(extent.y, step);
    warp.dataFromSample = placesOfSamples(data, window);
    warp.worldFromLattice = {
        {covered.lo.x + step / 2, covered.hi.y - step / 2}, {step, 0}, {0, -step}};
    photo.columns = static_cast<int>(warp.columns);
    photo.rows = static_cast<int>(warp.rows);
    photo.worldFromPixel = warp.worldFromLattice;
    photo.how = "warped to the working CRS";
    return {};
}

/// The photo's rows run from the top of the rectangle, its pixels fill it.
Affine2 stretchedOver(const PhotoPlace& place, const PhotoPlan& photo) {
    const Vec2 size = worldOf(place).size();
    return {{place.worldMin.x, place.worldMax.y},
            {size.x / photo.dataset->GetRasterXSize(), 0},
            {0, -size.y / photo.dataset->GetRasterYSize()}};
}

}  // namespace

std::string PhotoPlan::describe(const PhotoPixels& pixels) const {
    const std::string size =
        warp ? fmt::format(" of {:.4g} m", warp->worldFromLattice.column.x) : std::string();
    const std::string reduced =
        factor > 1 ? fmt::format(", reduced 1:{:.3g} to fit the memory", factor) : std::string();
    return fmt::format("{}: {} x {} pixels{}, {}, {}{}{}", path, columns, rows, size,
                       pixels.description(), how, assumption(*this), reduced);
}

Result<PhotoPlan> openPhoto(const std::string& path) {
    Result<OpenedRaster> opened = openRaster(path);
    if (!opened) return opened.error();
    PhotoPlan photo;
    photo.path = path;
    photo.dataset = std::move(opened->dataset);
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

Result<void> planPhoto(const PhotoPlace& place, PhotoPlan& photo) {
    if (!photo.header.transform) {
        return planDirect(place, stretchedOver(place, photo),
                          "without georeference, stretched over the terrain", photo);
    }
    const Affine2 asWorld = scaled(dataFromPixel(photo), place.metresPerCrsUnit);
    photo.takesTerrainsCrs = photo.header.crsWkt.empty();
    if (photo.takesTerrainsCrs) photo.header.crsWkt = place.dataCrsWkt;
    const std::string& crs = photo.header.crsWkt;
    if (crs.empty() || place.workingCrsWkt.empty()) {
        const char* const how = crs.empty() == place.workingCrsWkt.empty()
                                    ? "laid by its coordinates"
                                    : "laid by its coordinates (only one of photo and terrain has "
                                      "a CRS)";
        return planDirect(place, asWorld, how, photo);
    }
    const Result<GeoFrame> frame = GeoFrame::make(crs, place.workingCrsWkt);
    if (!frame) {
        return makeError(frame.error().code, "the photo '{}': {}", photo.path,
                         frame.error().message);
    }
    if (frame->isSameCrs()) return planDirect(place, asWorld, "in the working CRS", photo);
    return planWarp(place, photo);
}

}  // namespace terray
