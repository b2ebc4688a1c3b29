// SPDX-License-Identifier: Apache-2.0
// terrain.json: what a store holds, as JSON and back.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "store/in_place.h"
#include "store/photo_layer.h"
#include "store/shard_codec.h"
#include "tile/terrain_info.h"

namespace terray {

struct StoreManifest {
    TerrainInfo info;  ///< name is not stored
    std::string crsName, dataCrsWkt, dataCrsName;
    double maxError = 0;  ///< metres, of every stored post; 0: lossless
    uint64_t holes = 0;   ///< posts of mip 0 without a height
    std::vector<StoreSource> sources;
    std::optional<InPlaceSource> inPlace;  ///< sources[0] is mip 0, and there are no files of it
    std::optional<PhotoLayer> photo;
    std::vector<StoreSource> photoSources;
    std::vector<std::string> notes;  ///< what was assumed of the sources
    std::vector<std::string> files;  ///< all others, in the order of hashes.bin
    std::string hashes;              ///< hash of hashes.bin
    std::string plan;                ///< hash of all that the store's bytes depend on
};

/// Opens the blocks of a shard, of a file of the store in `folder` or of the source in place.
Result<std::unique_ptr<ShardFile>> openShard(const std::string& folder,
                                             const StoreManifest& manifest, ShardId shard);

/// The same manifest always gives the same text. It ends with the hash of itself.
std::string manifestText(const StoreManifest& manifest);

/// Error Input: damaged, not a manifest, of another version, or with values that cannot be. `name`
/// is the file's, for the sentence.
Result<StoreManifest> parseManifest(const std::string& name, const std::string& text);

}  // namespace terray
