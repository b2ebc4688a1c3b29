// SPDX-License-Identifier: Apache-2.0
// A source file that serves as a store's mip 0 as it is, and the state of source files.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "store/format.h"

namespace terray {

/// A file that went into a store, as it was then.
struct StoreSource {
    std::string name;
    uint64_t bytes = 0;
    int64_t modified = 0;     ///< seconds since 1970
    uint64_t headerHash = 0;  ///< of the first 64 KiB
    friend bool operator==(const StoreSource&, const StoreSource&) = default;
};

/// The file as it is now. Sources that are no files (synthetic ones) have zeros.
Result<StoreSource> stateOf(const std::string& name);

/// How the samples of a tiled GeoTIFF become the posts of mip 0. Whole numbers: code = (sample -
/// base) << shift. Floats: metres as they are.
struct InPlaceSource {
    std::string path;              ///< seen from the store's folder, or from the root
    std::string type;              ///< as GDAL calls it: Int16, UInt16, Float32
    std::optional<double> nodata;  ///< sample that is a hole; floats that are no numbers always are
    int64_t base = 0;
    int shift = 0;

    /// The path to open for a store in `folder`.
    std::string pathFrom(const std::string& folder) const;
    /// Raw 16-bit samples, signed by type, into codes. What has none becomes a hole: it lies in the
    /// padding of a block, or the file is another one.
    void toCodes(std::span<uint16_t> samples) const;
    /// Raw floats into posts.
    void toPosts(std::span<float> samples) const;
};

/// Error Input if the source is not the file that it was.
Result<void> checkInPlace(const InPlaceSource& source, const StoreSource& then,
                          const std::string& folder);

}  // namespace terray
