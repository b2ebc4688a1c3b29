// SPDX-License-Identifier: Apache-2.0
// What a bake is to make, before it starts: all that its bytes depend on.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "store/files.h"
#include "store/manifest.h"
#include "store/shard_codec.h"
#include "tile/height_source.h"
#include "tile/photo_source.h"

namespace terray {

struct BakePlan {
    const HeightSource* source = nullptr;
    const PhotoSource* photo = nullptr;  ///< manifest.photo tells its lattice
    StoreManifest manifest;  ///< info (but for minZ, maxZ), names, sources, notes; no files yet
    HeightCodec codec;
    uint64_t memoryBytes = 0;
    const FileCalls* calls = &systemFileCalls();

    const TerrainInfo& info() const { return manifest.info; }
    /// All that the store's bytes depend on, as JSON: an unfinished bake goes on only under the
    /// same text.
    std::string text() const;
};

}  // namespace terray
