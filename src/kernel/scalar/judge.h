// SPDX-License-Identifier: Apache-2.0
// Judges a kernel's hit by the oracle's: the tolerances of docs/surface.md, for tests and
// bench/exactness.
#pragma once

#include <string>

#include "kernel/layout/layout.h"
#include "kernel/scalar/oracle.h"

namespace terray::oracle {

enum class Fault {
    None,
    Tie,       ///< allowed: right for a ray that runs 1e-9 aside, as at posts, walls and rims
    HitMiss,   ///< one hits, the other misses
    Cell,      ///< another cell, and the place is not on the border of that cell
    Distance,  ///< t differs by more than max(1 mm, 1e-5 t, 2 eps / |f'|)
    Place,     ///< u, v or mip do not fit the ray's place
    Flags,     ///< another side of the sheet, or a strip taken for the sheet
};

Fault judge(const TerrainCut& cut, const Ray& ray, const Hit& hit, const ExactHit& exact);

/// The same for a shadow ray: None, Tie, or HitMiss.
Fault judgeShadow(const TerrainCut& cut, const Hit& hit, const Ray& ray, bool answer);

inline bool isViolation(Fault fault) { return fault != Fault::None && fault != Fault::Tie; }

/// One line for people: the fault, both hits and the ray in full precision.
std::string describe(Fault fault, const Ray& ray, const Hit& hit, const ExactHit& exact);

}  // namespace terray::oracle
