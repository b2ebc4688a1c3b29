// SPDX-License-Identifier: Apache-2.0
// Making and checking stores: terrains of any size on disk, with all that a view needs to know.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "terray/export.h"
#include "terray/options.h"
#include "terray/result.h"

namespace terray {

struct BakeOptions {
    OpenOptions open;  ///< what the sources do not say, and a photo; memoryBytes 0: 1 GiB
    /// Metres by which a stored height may differ from the source's; 0: none do. Default: a quarter
    /// of a step for whole numbers (those of mip 0 stay exact), else 1 cm.
    std::optional<double> maxError;
    int photoQuality = 90;  ///< of the photo's JPEG, 1 to 100; 0: without loss
    std::string exportCog;  ///< path of a COG to write besides; empty: none
    /// Use a source that lies as a store's blocks do as mip 0, instead of a copy of it.
    bool inPlace = false;
    bool resume = false;  ///< check a finished store and make what is damaged in it again
};

struct BakeReport {
    bool wasDone = false;           ///< the store held this bake already; nothing was written
    uint64_t foundFiles = 0;        ///< files that an earlier run had finished
    uint64_t files = 0, bytes = 0;  ///< of the store
    int64_t columns = 0, rows = 0;  ///< posts of mip 0
    int mips = 0;
    double maxError = 0;
    std::string photo;               ///< one line about it, if there is one
    std::vector<std::string> notes;  ///< what was assumed of the sources, one sentence each
    double seconds = 0;
};

/// Bakes DEMs into the store `out` (a folder). Where DEMs overlap, the last named one that has a
/// height counts; unlike ones are warped to the finest one's lattice. A run that is killed or fails
/// goes on when it is called again; the store that was there before stays until the new one is
/// whole. Errors: Input, Usage, Failed, Interrupted.
TERRAY_API Result<BakeReport> bake(std::span<const std::string> sources, const std::string& out,
                                   const BakeOptions& options = {});

struct VerifyReport {
    uint64_t files = 0, tiles = 0, bytes = 0;
    std::vector<std::string> damage;  ///< one line for each damaged tile or file
};

/// Reads every byte of a store. Error Input if it is none.
TERRAY_API Result<VerifyReport> verifyStore(const std::string& store);

}  // namespace terray
