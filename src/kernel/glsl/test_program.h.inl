// SPDX-License-Identifier: Apache-2.0
// The shader text as C++ over a cut's own pools. The includer defines SHADER_TRACE, the function's name, and
// SHADER_SPACE, where it has included layout.glsl and what C++ needs to read it. Everything but that
// function is its own, since objects of unlike flags include this.

namespace terray::SHADER_SPACE {
namespace {

struct Pools {
    const terray::TerrainCut& pools;

    DirectoryLevel fetchLevel(int level) const {
        return std::bit_cast<DirectoryLevel>(pools.levels[level]);
    }
    Square fetchSquare(uint index) const { return std::bit_cast<Square>(pools.squares[index]); }
    TileDesc fetchTile(uint slot) const { return std::bit_cast<TileDesc>(pools.tiles[slot]); }
    uint fetchBounds(Address bounds, uint index) const {
        return pools.bounds[std::bit_cast<uint64_t>(bounds) + index];
    }
    uint fetchPost(Address posts, uint index) const {
        const uint64_t at = std::bit_cast<uint64_t>(posts) + index;
        return pools.format == kPostsInt16 ? static_cast<const uint16_t*>(pools.posts)[at]
                                           : static_cast<const uint*>(pools.posts)[at];
    }
};

struct Program : Pools {
#include "kernel/glsl/trace.glsl"
};

}  // namespace
}  // namespace terray::SHADER_SPACE

namespace terray::test {

TraceHit SHADER_TRACE(const TerrainCut& cut, const TraceCut& constants, const TraceRay& ray,
                      const RaySlack& slack) {
    SHADER_SPACE::Program program{{cut}};
    return std::bit_cast<TraceHit>(program.traceRay(std::bit_cast<SHADER_SPACE::TraceCut>(constants),
                                                    std::bit_cast<SHADER_SPACE::TraceRay>(ray),
                                                    std::bit_cast<SHADER_SPACE::RaySlack>(slack)));
}

}  // namespace terray::test
