// SPDX-License-Identifier: Apache-2.0
// Baking a height source into a store.
#pragma once

#include <string>

#include "bake/plan.h"

namespace terray {

struct BakeOutcome {
    bool wasDone = false;   ///< the store was there already and, if asked, whole
    size_t foundFiles = 0;  ///< finished by an earlier, unfinished run, or found whole
};

/// Makes the store `out`, or finishes what an earlier run of the same plan has begun. The store
/// that is there stays until the new one is whole. `repair`: a finished store of the same plan is
/// read again, and what is damaged in it is made again. Errors: Failed, Input (reading),
/// Interrupted.
Result<BakeOutcome> bakeStore(const BakePlan& plan, const std::string& out, bool repair);

}  // namespace terray
