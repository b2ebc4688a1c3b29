// SPDX-License-Identifier: Apache-2.0
// Rays from the ground to the sun, in lattice space: bent like every ray, from a sun whose
// elevation changes along a curved earth, through an exaggerated picture.
#pragma once

#include <glm/vec3.hpp>

#include "kernel/sweep/sun.h"
#include "shade/ground.h"
#include "shade/shade.h"

namespace terray {

/// const-shared.
class SunRays {
public:
    SunRays(const Sun& sun, const RayFrame& rays);

    /// Unit vector towards the sun in picture space at a lattice place.
    glm::vec3 towardsAt(double i, double j) const;
    /// All rays to the sun. `onDisc` in -1..1 moves the aim over the sun's disc: the samples of a
    /// pixel together give shadows a soft edge.
    SunDirection direction(Vec2 onDisc = {0, 0}) const;

    /// max(0, N.L) on ground whose slopes are `modelling` times as steep.
    void facing(const GroundBatch& ground, float modelling, Floats& facing) const;
    /// Hits on ground that faces the sun ask whether it reaches them; `asks` is clear before.
    static void ask(const HitBatch& hits, const Floats& facing, const Floats& height,
                    SunAsks& asks);

private:
    double riseAt(double i, double j) const;

    Affine2 worldFromLattice_;
    Vec2 centre_, horizontal_;  ///< horizontal part of the unit vector to the sun
    double sine_, cosine_;      ///< of its elevation at `centre`
    double exaggeration_, bend_;
};

}  // namespace terray
