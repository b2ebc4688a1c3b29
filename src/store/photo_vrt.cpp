// SPDX-License-Identifier: Apache-2.0
// The text of a photo's VRTs: three colours, and what they cover as alpha.
#include <fmt/format.h>

#include "store/vrt.h"

namespace terray {
namespace {

/// Files of a mip as the sources of a band, and for mip 0 the coarser ones as its overviews.
std::string sources(const PhotoLayer& layer, int mip, int band, const std::string& from) {
    const BlockGrid grid = layer.grid(mip);
    std::string text;
    for (int y = 0; y < grid.blocksY; ++y) {
        for (int x = 0; x < grid.blocksX; x += kShardBlocks) {
            const int width = grid.widthOf(x, grid.blocksOf({mip, x, y}));
            const std::string size =
                fmt::format("xSize=\"{}\" ySize=\"{}\"", width, grid.heightOf(y));
            text += fmt::format(
                "    <SimpleSource>\n"
                "      <SourceFilename relativeToVRT=\"1\">{}m{}/y{}_x{}.tif</SourceFilename>\n"
                "      <SourceBand>{}</SourceBand>\n"
                "      <SourceProperties RasterXSize=\"{}\" RasterYSize=\"{}\" DataType=\"Byte\" "
                "BlockXSize=\"{}\" BlockYSize=\"{}\"/>\n"
                "      <SrcRect xOff=\"0\" yOff=\"0\" {}/>\n"
                "      <DstRect xOff=\"{}\" yOff=\"{}\" {}/>\n"
                "    </SimpleSource>\n",
                mip == 0 ? "photo/" : "", mip, y, x, from, width, grid.heightOf(y), kBlockPosts,
                kBlockPosts, size, int64_t{x} * kBlockPosts, int64_t{y} * kBlockPosts, size);
        }
    }
    for (int coarser = 1; mip == 0 && coarser < layer.mipCount(); ++coarser) {
        text += fmt::format(
            "    <Overview>\n"
            "      <SourceFilename relativeToVRT=\"1\">{}</SourceFilename>\n"
            "      <SourceBand>{}</SourceBand>\n    </Overview>\n",
            photoMipVrtPath(coarser), band);
    }
    return text;
}

}  // namespace

Result<std::string> photoVrtText(const TerrainInfo& info, const PhotoLayer& layer, int mip) {
    auto head =
        vrtHead(info, layer.grid(mip), layer.geoTransform(info.metresPerCrsUnit, mip, 0, 0));
    if (!head) return head.error();
    std::string text = std::move(*head);
    static constexpr const char* kColours[] = {"Red", "Green", "Blue", "Alpha"};
    for (int band = 1; band <= 4; ++band) {
        text += fmt::format(
            "  <VRTRasterBand dataType=\"Byte\" band=\"{}\">\n"
            "    <ColorInterp>{}</ColorInterp>\n",
            band, kColours[band - 1]);
        const bool isMask = band == 4 && !layer.isLossless();
        text += sources(layer, mip, band, isMask ? "mask,1" : std::to_string(band));
        text += "  </VRTRasterBand>\n";
    }
    return text + "</VRTDataset>\n";
}

}  // namespace terray
