// SPDX-License-Identifier: Apache-2.0
// The text of a store's VRTs.
#include "store/vrt.h"

#include <cpl_conv.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "store/format.h"

namespace terray {
namespace {

std::string escaped(const char* text) {
    char* out = CPLEscapeString(text, -1, CPLES_XML);
    std::string result = out;
    CPLFree(out);
    return result;
}

Result<std::string> crsElement(const TerrainInfo& info) {
    if (info.crsWkt.empty()) return std::string();
    OGRSpatialReference crs;
    if (crs.importFromWkt(info.crsWkt.c_str()) != OGRERR_NONE) {
        return makeError(ErrorCode::Failed, "GDAL does not understand the CRS of '{}'", info.name);
    }
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::vector<int> axes = crs.GetDataAxisToSRSAxisMapping();
    return fmt::format("  <SRS dataAxisToSRSAxisMapping=\"{}\">{}</SRS>\n", fmt::join(axes, ","),
                       escaped(info.crsWkt.c_str()));
}

std::string sourceElement(const TerrainInfo& info, ShardId shard, const BlockGrid& grid,
                          const char* folder) {
    const int width = grid.widthOf(shard.x0, grid.blocksOf(shard)), height = grid.heightOf(shard.y);
    const std::string size = fmt::format("xSize=\"{}\" ySize=\"{}\"", width, height);
    return fmt::format(
        "    <SimpleSource>\n"
        "      <SourceFilename relativeToVRT=\"1\">{}m{}/y{}_x{}.tif</SourceFilename>\n"
        "      <SourceBand>1</SourceBand>\n"
        "      <SourceProperties RasterXSize=\"{}\" RasterYSize=\"{}\" DataType=\"{}\" "
        "BlockXSize=\"{}\" BlockYSize=\"{}\"/>\n"
        "      <SrcRect xOff=\"0\" yOff=\"0\" {}/>\n"
        "      <DstRect xOff=\"{}\" yOff=\"{}\" {}/>\n"
        "    </SimpleSource>\n",
        folder, shard.mip, shard.y, shard.x0, width, height,
        info.format == PostFormat::Int16 ? "UInt16" : "Float32", kBlockPosts, kBlockPosts, size,
        int64_t{shard.x0} * kBlockPosts, int64_t{shard.y} * kBlockPosts, size);
}

/// The source's samples, made codes where posts are codes.
std::string inPlaceElement(const InPlaceSource& source, const BlockGrid& grid) {
    const bool codes = source.type != "Float32";
    std::string scaling;
    if (source.nodata) scaling += fmt::format("      <NODATA>{:.17g}</NODATA>\n", *source.nodata);
    if (codes) {
        const int64_t step = int64_t{1} << source.shift;
        scaling +=
            fmt::format("      <ScaleOffset>{}</ScaleOffset>\n      <ScaleRatio>{}</ScaleRatio>\n",
                        -source.base * step, step);
    }
    const bool isRelative = !source.path.starts_with('/');
    const std::string size =
        fmt::format("xOff=\"0\" yOff=\"0\" xSize=\"{}\" ySize=\"{}\"", grid.columns, grid.rows);
    return fmt::format(
        "    <ComplexSource>\n"
        "      <SourceFilename relativeToVRT=\"{}\">{}</SourceFilename>\n"
        "      <SourceBand>1</SourceBand>\n"
        "      <SourceProperties RasterXSize=\"{}\" RasterYSize=\"{}\" DataType=\"{}\" "
        "BlockXSize=\"{}\" BlockYSize=\"{}\"/>\n"
        "      <SrcRect {}/>\n      <DstRect {}/>\n{}    </ComplexSource>\n",
        isRelative ? 1 : 0, escaped(source.path.c_str()), grid.columns, grid.rows, source.type,
        kBlockPosts, kBlockPosts, size, size, scaling);
}

}  // namespace

Result<std::string> vrtHead(const TerrainInfo& info, const BlockGrid& grid,
                            const GeoTransform& transform) {
    const auto crs = crsElement(info);
    if (!crs) return crs.error();
    const double* t = transform.values;
    return fmt::format(
        "<VRTDataset rasterXSize=\"{}\" rasterYSize=\"{}\">\n{}"
        "  <GeoTransform>{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}"
        "</GeoTransform>\n",
        grid.columns, grid.rows, *crs, t[0], t[1], t[2], t[3], t[4], t[5]);
}

Result<std::string> vrtText(const TerrainInfo& info, int mip,
                            const std::optional<InPlaceSource>& inPlace) {
    const BlockGrid grid(info.scheme, mip);
    const bool codes = info.format == PostFormat::Int16;
    auto head = vrtHead(info, grid, geoTransformOf(info, mip, 0, 0));
    if (!head) return head.error();
    std::string text = std::move(*head);
    text += fmt::format(
        "  <VRTRasterBand dataType=\"{}\" band=\"1\">\n"
        "    <NoDataValue>{}</NoDataValue>\n    <UnitType>m</UnitType>\n",
        codes ? "UInt16" : "Float32", codes ? "65535" : "nan");
    if (codes) {
        text += fmt::format("    <Offset>{}</Offset>\n    <Scale>{}</Scale>\n",
                            static_cast<double>(info.z0), static_cast<double>(info.zStep));
    }
    const bool usesSource = mip == 0 && inPlace;
    if (usesSource) text += inPlaceElement(*inPlace, grid);
    for (int y = 0; !usesSource && y < grid.blocksY; ++y) {
        for (int x = 0; x < grid.blocksX; x += kShardBlocks) {
            text += sourceElement(info, {mip, x, y}, grid, mip == 0 ? "height/" : "");
        }
    }
    for (int coarser = 1; mip == 0 && coarser < info.scheme.mipCount(); ++coarser) {
        text += fmt::format(
            "    <Overview>\n"
            "      <SourceFilename relativeToVRT=\"1\">{}</SourceFilename>\n"
            "      <SourceBand>1</SourceBand>\n    </Overview>\n",
            mipVrtPath(coarser));
    }
    return text + "  </VRTRasterBand>\n</VRTDataset>\n";
}

}  // namespace terray
