// SPDX-License-Identifier: Apache-2.0
// From finished heights and measurements to a whole store: edges, bounds, VRTs, hashes, manifest.
#pragma once

#include "bake/measure.h"

namespace terray {

/// Edge and bounds files from the measurements, and what they tell of the whole terrain.
Result<HeightTally> assembleMeasured(Workshop& shop);

/// All that is left once heights, edges and bounds are there.
Result<void> finishStore(Workshop& shop, const HeightTally& tally);

}  // namespace terray
