// SPDX-License-Identifier: Apache-2.0
// Stores as sources: opened under the options of a source, and described like one.
#pragma once

#include <memory>
#include <string>

#include "store/store.h"
#include "terray/options.h"
#include "terray/terrain.h"

namespace terray {

/// Error Usage if an option says what only a DEM can be told; Input if the store is damaged.
Result<std::unique_ptr<Store>> openStore(const std::string& source, const OpenOptions& options);

/// Facts but for those that describeLattice() fills.
SourceInfo describeStore(const Store& store);

}  // namespace terray
