// SPDX-License-Identifier: Apache-2.0
// The plain plinth of --base, as model makers build it: a solid block under the terrain, from its
// outer rim down to a level base. A decoration of pictures: no AOV or query knows it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "shade/rim.h"
#include "shade/shade.h"

namespace terray {

/// const-shared.
class Plinth {
public:
    Plinth(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays,
           std::span<const RimLoop> rims);

    struct Seen {
        float t = 0;            ///< distance along the ray
        glm::vec3 outwards{0};  ///< unit, picture space
        bool inHole = false;    ///< bare rock under a hole of the ground, not a face
    };
    /// What a lattice ray meets first of the block before `tMax`.
    std::optional<Seen> firstSeen(const Ray& ray, double tMax) const;

    /// Whether the block is under a lattice place: the ragged last cells of a rim stand over it.
    bool isUnder(double i, double j) const;

private:
    /// A straight vertical face.
    struct Face {
        Vec2 from, along;          ///< lattice: first corner, and from there to the second
        glm::vec3 outwards;        ///< unit normal
        size_t top = 0, tops = 0;  ///< heights of its upper edge in tops_, evenly spaced
    };
    enum class Block : uint8_t { Outside, Inside, HasFaces };
    struct Crossing {
        double t = 0;
        const Face* face = nullptr;
        bool enters = false;
    };
    void addLoop(const RimLoop& loop, const Affine2& worldFromLattice);
    void addTops(Face& face);
    template <class Visit>
    void visitBlocks(const Face& face, const Visit& visit) const;
    void sortIntoBlocks();
    std::span<const uint32_t> facesIn(int64_t block) const;
    bool isInside(double i, double j) const;
    double topAt(const Face& face, double share) const;
    std::optional<Crossing> firstCrossing(const Ray& ray, int64_t block, double tIn,
                                          double tOut) const;
    std::optional<Seen> seenAtBase(const Ray& ray, double& tOut) const;

    const TerrainCut& cut_;
    int64_t cellsI_, cellsJ_;
    double baseZ_;  ///< true metres
    std::vector<Face> faces_;
    std::vector<float> tops_;
    double blockSize_;  ///< cells a side of the blocks that faces are sorted into
    int64_t blocksI_, blocksJ_;
    std::vector<uint32_t> firstFace_, faceList_;  ///< faces of block b: list [first[b], first[b+1])
    std::vector<Block> states_;
};

}  // namespace terray
