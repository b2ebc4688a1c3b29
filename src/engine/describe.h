// SPDX-License-Identifier: Apache-2.0
// Facts about the working lattice, for `terray info`.
#pragma once

#include "terray/terrain.h"
#include "tile/terrain_info.h"

namespace terray {

/// Fills the part of the facts that follows from the lattice: sizes, mips, memory.
void describeLattice(const TerrainInfo& info, SourceInfo& facts);

}  // namespace terray
