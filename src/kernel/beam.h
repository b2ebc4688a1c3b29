// SPDX-License-Identifier: Apache-2.0
// A bundle of rays at once: how far all of them surely stay above the surface, or above its sharp
// places.
#pragma once

#include "kernel/layout/layout.h"

namespace terray {

/// Rays between four corner rays. All share the parameter w, and at any w every ray of the bundle
/// lies inside the quadrilateral of the corners, widened by bulge * w cells (curved fronts:
/// panoramas).
struct Beam {
    Ray corners[4];
    double bulge = 0;
};

/// Walks a bundle over the maxima of the drawn surface: a box of cells a step, as large as stays
/// clear. confined.
class BeamWalk {
public:
    explicit BeamWalk(const TerrainCut& cut, const Beam& beam) : BeamWalk(cut, beam, {}) {}
    /// Only ground whose slope falls off by at least so many metres a cell of mip 0 stands in the
    /// way, see least(): blocks that hold such a place, rims of holes, borders between unlike mips,
    /// and the terrain's rim for rays that come from outside.
    struct Sharp {
        double at = 0;    ///< at the eye; 0: any ground
        double perW = 0;  ///< cells from ray to ray, per w
        /// Less where several edges of cells lie between two rays, one a cell and direction.
        double least(double w) const {
            const double cells = perW * w;
            return at / (cells < 1 ? 1 + 0.5 * cells : 1 + cells);
        }
    };
    BeamWalk(const TerrainCut& cut, const Beam& beam, const Sharp& sharp);

    /// From now on only what reaches up to these two rays, at the bundle's sides, stands in the
    /// way. They run inside the bundle and, at any w, nowhere lower than the ones before.
    void raiseFloor(const Ray& left, const Ray& right);
    /// Goes on until `wanted`, or until something may stand in the way. Every ray of the bundle is
    /// clear for all w up to the result, which may be infinite; 0 is always true.
    double clearTo(double wanted);
    /// How far it has come.
    double reached() const { return w_; }
    /// The size of block (2^level mip-0 cells) at which nothing more could be said.
    int level() const { return level_; }

private:
    struct Box {
        double x0, y0, x1, y1;
    };
    /// What the corners do at one w: their box, lowest height, and how far apart they are.
    struct Front {
        Box box;
        double lowest;
        double width;
    };
    /// What is drawn in a block.
    struct Node {
        float top;       ///< greatest height
        float sharpest;  ///< metres a cell of mip 0; infinite beside holes
        int mip;
        bool rim = false;  ///< the surface may end or jump here
    };
    Front frontAt(double w) const;
    bool hasLeft(const Box& box) const;
    Node nodeAt(int level, int64_t x, int64_t y) const;
    Node nodeInTile(const Square& square, int level, int64_t x, int64_t y) const;
    /// Sides of a tile at which a block stands.
    struct Sides {
        bool left, right, top, bottom;
    };
    bool bordersUnlike(const TileDesc& tile, int mip, const Sides& sides) const;
    float maxOver(const Box& box, double sharp) const;
    template <class Visit>
    void eachNode(const Box& box, int across, const Visit& visit) const;
    float sharpOver(const Box& box, double sharp) const;

    const TerrainCut& cut_;
    Beam beam_;
    Sharp sharp_;
    bool fromOutside_ = false;
    double speed_ = 1e-12, bend_ = 0;
    /// Least and greatest steps of the bundle's rays, its bulge included.
    double leastDx_ = 1e300, mostDx_ = -1e300, leastDy_ = 1e300, mostDy_ = -1e300;
    /// Rays begin well outside the float rays' error, where their first cells can be told.
    double clearance_ = 1e-3;
    double w_ = 0;
    int level_ = kMaxLevels;
    bool stopped_ = false;
    Front here_{};
    Ray floor_[4];  ///< the rays that tell the lowest height
};

}  // namespace terray
