// SPDX-License-Identifier: Apache-2.0
// openDem and scanDem: from a header to a source of posts in the working CRS, and to the facts.
#include "raster/dem.h"

#include <algorithm>
#include <cmath>

#include "raster/dem_description.h"
#include "raster/height_unit.h"
#include "raster/raster_source.h"
#include "raster/sample_scan.h"
#include "raster/synthetic.h"
#include "raster/warp.h"

namespace terray {
namespace {

/// Pixel centres carry the samples; GDAL has already moved the geotransform of pixel-is-point files
/// by half a pixel, so this holds for them too. Without a georeference: 1 m pixels, north up.
Affine2 placeSamples(const RasterHeader& header) {
    const std::array<double, 6> pixels{0, 1, 0, static_cast<double>(header.rows), 0, -1};
    const std::array<double, 6>& t = header.transform ? *header.transform : pixels;
    return {{t[0] + 0.5 * t[1] + 0.5 * t[2], t[3] + 0.5 * t[4] + 0.5 * t[5]},
            {t[1], t[4]},
            {t[2], t[5]}};
}

}  // namespace

Extent2 extentOf(const RasterHeader& header, const Affine2& map) {
    const auto right = static_cast<double>(header.columns - 1);
    const auto bottom = static_cast<double>(header.rows - 1);
    Extent2 extent{map.origin, map.origin};
    for (const LatticePoint corner : {LatticePoint{right, 0}, {0, bottom}, {right, bottom}}) {
        const Vec2 place = map.worldFromLattice(corner);
        extent.min = glm::min(extent.min, place);
        extent.max = glm::max(extent.max, place);
    }
    return extent;
}

namespace {

/// Coordinates that can only be degrees, though no CRS says so.
bool looksLikeDegrees(const Extent2& extent, const Affine2& map) {
    return extent.min.x >= -360 && extent.max.x <= 360 && extent.min.y >= -90 &&
           extent.max.y <= 90 && map.columnLength() < 1 && map.rowLength() < 1;
}

/// Fills the CRS (of the file or assigned) and what its absence means.
Result<void> describePlace(const OpenOptions& options, Description& d) {
    const std::string& name = d.header.name;
    const bool assigned = !options.assignCrs.empty();
    const std::string& definition = assigned ? options.assignCrs : d.header.crsWkt;
    if (!definition.empty()) {
        Result<CrsFacts> facts = describeCrs(definition);
        if (!facts && assigned) {
            return makeError(ErrorCode::Usage, "--assign-crs {}: {}", definition,
                             facts.error().message);
        }
        if (!facts) return makeError(ErrorCode::Input, "'{}': {}", name, facts.error().message);
        d.crs = std::move(*facts);
    }
    d.dataFromSample = placeSamples(d.header);
    if (d.crs) return {};
    if (!options.workingCrs.empty()) {
        return makeError(ErrorCode::Usage,
                         "--crs {}: '{}' has no CRS to warp from; name its own with --assign-crs",
                         options.workingCrs, name);
    }
    const Extent2 extent = extentOf(d.header, d.dataFromSample);
    if (d.header.transform && looksLikeDegrees(extent, d.dataFromSample)) {
        return makeError(ErrorCode::Input,
                         "'{}' has coordinates that can only be degrees ({:.6g} to {:.6g}, {:.6g} "
                         "to {:.6g}) but no CRS; name it with --assign-crs, for example "
                         "--assign-crs EPSG:4326",
                         name, extent.min.x, extent.max.x, extent.min.y, extent.max.y);
    }
    if (d.header.transform) {
        d.assumptions.push_back(
            {fmt::format("'{}' has no CRS; its coordinates are taken as metres (--assign-crs names "
                         "one)",
                         name),
             true});
    }
    return {};
}

/// Fills the unit of the heights: from --height-unit, the band, or the vertical CRS.
void describeHeights(const OpenOptions& options, Description& d) {
    const std::string& declared = d.header.unitType;
    HeightUnitFacts unit{"m", 1};
    if (options.heightUnit) {
        unit = describeHeightUnit(*options.heightUnit);
    } else if (const auto known = parseHeightUnit(declared)) {
        unit = *known;
    } else if (declared.empty() && d.crs && !d.crs->heightUnitName.empty()) {
        const auto named = parseHeightUnit(d.crs->heightUnitName);
        unit = {named ? named->name : d.crs->heightUnitName, d.crs->metresPerHeightUnit};
    } else {
        const std::string what = declared.empty()
                                     ? "does not say the unit of its heights"
                                     : fmt::format(
                                           "gives its heights in '{}', which is no unit of length "
                                           "that Terray knows",
                                           declared);
        d.assumptions.push_back({fmt::format(
            "'{}' {}; metres are assumed (--height-unit says otherwise)", d.header.name, what)});
    }
    d.heightUnit = unit.name;
    d.header.rules.metresPerUnit = unit.metres;
}

}  // namespace

Result<Description> describeDem(const std::string& path, const OpenOptions& options) {
    Result<RasterHeader> header = readHeader(path, options);
    if (!header) return header.error();
    Description d;
    d.header = std::move(*header);
    d.assumptions = d.header.assumptions;
    TERRAY_TRY(describePlace(options, d));
    describeHeights(options, d);
    return d;
}

SourceInfo factsOf(const Description& d) {
    const RasterHeader& header = d.header;
    SourceInfo facts;
    facts.source = header.name;
    facts.driver = header.driver;
    facts.columns = header.columns;
    facts.rows = header.rows;
    facts.bands = header.bands;
    facts.sampleType = header.sampleType;
    if (d.crs) {
        facts.crsName = d.crs->name;
        facts.crsWkt = d.crs->wkt;
    }
    if (header.transform)
        facts.geoTransform.assign(header.transform->begin(), header.transform->end());
    facts.pixelWidth = d.dataFromSample.columnLength();
    facts.pixelHeight = d.dataFromSample.rowLength();
    facts.horizontalUnit = d.crs ? d.crs->unitName : "metre";
    facts.pixelIsPoint = header.pixelIsPoint;
    facts.nodataRule = header.nodataRule;
    facts.heightUnit = d.heightUnit;
    facts.scale = header.rules.scale;
    facts.offset = header.rules.offset;
    facts.assumptions = d.assumptions;
    return facts;
}

Result<double> radiusAtCentre(const Description& d, const TerrainInfo& info) {
    if (!d.crs) return 0.0;
    const Result<GeoFrame> frame = GeoFrame::make(d.crs->wkt, info.crsWkt);
    if (!frame) return frame.error();
    return frame->curvatureRadius(
        info.worldFromLattice.worldFromLattice({0.5 * static_cast<double>(info.scheme.columns - 1),
                                                0.5 * static_cast<double>(info.scheme.rows - 1)}));
}

void finishFacts(const TerrainInfo& info, SourceInfo& facts) {
    facts.workingColumns = info.scheme.columns;
    facts.workingRows = info.scheme.rows;
    facts.workingCellX = info.worldFromLattice.columnLength();
    facts.workingCellY = info.worldFromLattice.rowLength();
    facts.mips = info.scheme.mipCount();
    facts.postFormat = info.format == PostFormat::Int16 ? "16 bit" : "float";
}

namespace {

void setRange(const SampleRange& range, const RasterHeader& header, SourceInfo& facts) {
    facts.hasRange = true;
    facts.holes = range.holes;
    if (!range.hasRange) {
        facts.minHeight = HUGE_VAL;
        facts.maxHeight = -HUGE_VAL;
        return;
    }
    const double a = header.rules.metres(range.rawMin), b = header.rules.metres(range.rawMax);
    facts.minHeight = std::min(a, b);
    facts.maxHeight = std::max(a, b);
    for (const double mark : {-32768.0, -32767.0, -9999.0, -99999.0}) {
        if (range.rawMin != mark) continue;
        facts.assumptions.push_back(
            {fmt::format("the lowest number in '{}' is {}, which often means no data; it is taken "
                         "as a height (--nodata {} makes it a hole)",
                         header.name, mark, mark),
             true});
    }
}

/// Integer samples become 16-bit codes if their range, seen in one pass unless the type is narrow
/// enough, fits. Rasters that will not fit into memory anyway are not read for it.
Result<std::optional<PostCodes>> findCodes(const RasterHeader& header, uint64_t budget,
                                           SourceInfo& facts) {
    std::optional<PostCodes> codes;
    const SampleRules& rules = header.rules;
    if (!rules.integer) return codes;
    codes = choosePostCodes(rules, header.typeMin, header.typeMax);
    if (codes && codes->shift > 0) return codes;
    const int64_t samples = header.columns * header.rows;
    if (static_cast<uint64_t>(samples) > budget / sizeof(uint16_t)) return codes;
    const Result<SampleRange> range = scanSamples(header);
    if (!range) return range.error();
    setRange(*range, header, facts);
    return range->hasRange ? choosePostCodes(rules, range->rawMin, range->rawMax)
                           : choosePostCodes(rules, 0, 0);
}

/// Decides whether to warp and fills the lattice of the terrain; `plan` is set if it is warped.
Result<void> placeLattice(const Description& d, const OpenOptions& options, TerrainInfo& info,
                          SourceInfo& facts, std::optional<WarpPlan>& plan) {
    const RasterHeader& header = d.header;
    info.scheme = {header.columns, header.rows};
    info.worldFromLattice = d.dataFromSample;
    facts.workingCrsName = facts.crsName;
    if (!d.crs) return {};
    const Extent2 extent = extentOf(header, d.dataFromSample);
    const Result<WorkingCrs> working =
        chooseWorkingCrs(*d.crs, extent.min, extent.max, options.workingCrs);
    if (!working) {
        return makeError(working.error().code, "'{}': {}", header.name, working.error().message);
    }
    info.crsWkt = working->same ? d.crs->wkt : working->wkt;
    facts.workingCrsName = working->name;
    if (working->same) {
        const double unit = d.crs->metresPerUnit;
        info.metresPerCrsUnit = unit;
        info.worldFromLattice = {unit * d.dataFromSample.origin, unit * d.dataFromSample.column,
                                 unit * d.dataFromSample.row};
        return {};
    }
    const Result<CrsFacts> target = describeCrs(working->wkt);
    if (!target) return target.error();
    info.metresPerCrsUnit = target->metresPerUnit;
    plan = WarpPlan{
        header, d.crs->wkt, working->wkt, d.dataFromSample, 0.5 * (extent.min + extent.max), 0,
        0,      {}};
    TERRAY_TRY(planLattice(*plan));
    info.scheme = {plan->columns, plan->rows};
    info.worldFromLattice = plan->worldFromLattice;
    facts.warped = true;
    facts.assumptions.push_back({working->reason});
    return {};
}

Dem describeSynthetic(std::unique_ptr<HeightSource> source) {
    const TerrainInfo& info = source->info();
    SourceInfo facts;
    facts.source = info.name;
    facts.driver = std::string("synthetic");
    facts.columns = info.scheme.columns;
    facts.rows = info.scheme.rows;
    facts.bands = 1;
    facts.sampleType = info.format == PostFormat::Int16 ? "Int16" : "Float32";
    facts.crsWkt = info.crsWkt;
    facts.pixelWidth = info.worldFromLattice.columnLength();
    facts.pixelHeight = info.worldFromLattice.rowLength();
    facts.horizontalUnit = std::string("metre");
    facts.nodataRule = std::string("NaN");
    facts.heightUnit = std::string("m");
    finishFacts(info, facts);
    Dem dem;
    dem.dataCrsWkt = info.crsWkt;
    dem.source = std::move(source);
    dem.facts = std::move(facts);
    dem.notPlain = "it is synthetic";
    return dem;
}

Result<void> scanSynthetic(const HeightSource& source, SourceInfo& facts) {
    const Result<std::unique_ptr<HeightReader>> reader = source.makeReader();
    if (!reader) return reader.error();
    const TilingScheme& scheme = source.info().scheme;
    double lowest = HUGE_VAL, highest = -HUGE_VAL;
    int64_t holes = 0;
    std::vector<float> posts(static_cast<size_t>(scheme.columns));
    for (int64_t row = 0; row < scheme.rows; ++row) {
        TERRAY_TRY((*reader)->read(0, row, scheme.columns, 1, posts));
        for (const float z : posts) {
            if (std::isnan(z)) {
                ++holes;
                continue;
            }
            lowest = std::min(lowest, static_cast<double>(z));
            highest = std::max(highest, static_cast<double>(z));
        }
    }
    facts.holes = holes;
    facts.hasRange = true;
    facts.minHeight = lowest;
    facts.maxHeight = highest;
    return {};
}

}  // namespace

namespace {

/// Why a DEM cannot be a store's mip 0 as it is; empty if it can.
std::string whyNotPlain(const RasterHeader& header, const TerrainInfo& info, bool isWarped,
                        bool hasCodes) {
    constexpr int kBlock = 512;
    const Affine2& map = info.worldFromLattice;
    const SampleRules& rules = header.rules;
    if (isWarped) return "its CRS does not measure well, so that it is warped";
    if (header.driver != "GTiff" || header.gdalName != header.name) return "it is no GeoTIFF";
    if (header.bands != 1) return fmt::format("it has {} bands", header.bands);
    if (header.blockColumns != kBlock || header.blockRows != kBlock) {
        return fmt::format("its blocks are {} x {} samples, not 512 x 512", header.blockColumns,
                           header.blockRows);
    }
    if (map.column.y != 0 || map.row.x != 0 || map.row.y > 0 || map.column.x < 0) {
        return "it is not north up";
    }
    if (rules.useMask) return "it marks holes by a mask";
    const bool isFloat = header.sampleType == "Float32" && rules.isIdentity() && !hasCodes;
    const bool isWhole =
        (header.sampleType == "Int16" || header.sampleType == "UInt16") && hasCodes;
    if (isFloat || isWhole) return {};
    return fmt::format("its {} samples are neither floats in metres nor whole numbers of 16 bits",
                       header.sampleType);
}

}  // namespace

Result<Dem> openDem(const std::string& path, const OpenOptions& options, RangeScan scan) {
    Result<std::unique_ptr<HeightSource>> synthetic = makeSynthetic(path);
    if (!synthetic) return synthetic.error();
    if (*synthetic) return describeSynthetic(std::move(*synthetic));

    const Result<Description> described = describeDem(path, options);
    if (!described) return described.error();
    const Description& d = *described;
    Dem dem;
    dem.facts = factsOf(d);
    dem.dataCrsWkt = dem.facts.crsWkt;
    TerrainInfo info;
    info.name = path;
    std::optional<WarpPlan> plan;
    TERRAY_TRY(placeLattice(d, options, info, dem.facts, plan));
    const Result<double> radius = radiusAtCentre(d, info);
    if (!radius) return radius.error();
    info.ellipsoidRadius = *radius;
    std::optional<PostCodes> codes;
    if (!plan) {
        const uint64_t budget =
            scan == RangeScan::Always ? UINT64_MAX : memoryBudget(options.memoryBytes);
        const Result<std::optional<PostCodes>> found = findCodes(d.header, budget, dem.facts);
        if (!found) return found.error();
        codes = *found;
    }
    if (codes) {
        info.format = PostFormat::Int16;
        info.z0 = codes->z0;
        info.zStep = codes->zStep;
        dem.heightStep = d.header.rules.scale * d.header.rules.metresPerUnit;
    }
    if (dem.facts.minHeight <= dem.facts.maxHeight) {
        info.minZ = static_cast<float>(dem.facts.minHeight);
        info.maxZ = static_cast<float>(dem.facts.maxHeight);
    }
    finishFacts(info, dem.facts);
    dem.notPlain = whyNotPlain(d.header, info, plan.has_value(), codes.has_value());
    if (dem.notPlain.empty()) {
        dem.plainTiles = PlainTiles{d.header.gdalName, d.header.sampleType, d.header.rules.nodata,
                                    codes ? codes->base : 0, codes ? codes->shift : 0};
    }
    dem.source = plan ? makeWarpedSource(std::move(info), std::move(*plan))
                      : makeRasterSource(std::move(info), d.header, codes);
    return dem;
}

Result<void> scanDem(const std::string& path, const OpenOptions& options, SourceInfo& facts) {
    if (facts.hasRange) return {};  // openDem() had to know it
    Result<std::unique_ptr<HeightSource>> synthetic = makeSynthetic(path);
    if (!synthetic) return synthetic.error();
    if (*synthetic) return scanSynthetic(**synthetic, facts);
    const Result<Description> described = describeDem(path, options);
    if (!described) return described.error();
    const Result<SampleRange> range = scanSamples(described->header);
    if (!range) return range.error();
    setRange(*range, described->header, facts);
    return {};
}

}  // namespace terray
