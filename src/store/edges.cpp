// SPDX-License-Identifier: Apache-2.0
// Layout of edge files.
#include "store/edges.h"

namespace terray {
namespace {
constexpr std::string_view kEdgesMagic = "TERRAYED";
}

Bytes encodeEdgeHeader(const TerrainInfo& info, int mip) {
    ByteWriter out;
    out.text(kEdgesMagic);
    for (const uint64_t value : {uint64_t{kStoreVersion}, static_cast<uint64_t>(mip),
                                 static_cast<uint64_t>(info.scheme.tilesX(mip)),
                                 static_cast<uint64_t>(info.scheme.tilesY(mip)),
                                 postBytes(info.format), uint64_t{kEdgePosts}}) {
        out.number(static_cast<uint32_t>(value));
    }
    return out.take();
}

BlockRange edgeRange(const TerrainInfo& info, TileId id) {
    const uint64_t size = edgeRecordBytes(info.format);
    const auto index = static_cast<uint64_t>(tileIndex(info.scheme, id));
    return {kEdgeHeaderBytes + index * size, size};
}

uint64_t edgeFileBytes(const TerrainInfo& info, int mip) {
    return kEdgeHeaderBytes +
           static_cast<uint64_t>(info.scheme.tileCount(mip)) * edgeRecordBytes(info.format);
}

std::vector<BlockRange> edgeRanges(const TerrainInfo& info, int mip) {
    std::vector<BlockRange> ranges;
    for (int y = 0; y < info.scheme.tilesY(mip); ++y) {
        for (int x = 0; x < info.scheme.tilesX(mip); ++x) {
            ranges.push_back(edgeRange(info, {mip, x, y}));
        }
    }
    return ranges;
}

}  // namespace terray
