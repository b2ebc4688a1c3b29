// SPDX-License-Identifier: Apache-2.0
// Several DEMs as one: tiles of one lattice joined without resampling, as a VRT in memory.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "terray/options.h"

namespace terray {

/// Holds the VRT as long as it lives.
class Mosaic {
public:
    /// DEMs of one CRS, type, unit and pixel size whose pixels coincide; where several have a
    /// height, that of the last named one counts; between them are holes. Null if they are not
    /// alike: openUnlikeDems() warps such. Errors: Input, Usage, naming the DEM.
    static Result<std::unique_ptr<Mosaic>> join(std::span<const std::string> names,
                                                const OpenOptions& options);
    ~Mosaic();
    Mosaic(const Mosaic&) = delete;
    Mosaic& operator=(const Mosaic&) = delete;

    /// What openDem() opens.
    const std::string& path() const { return path_; }

private:
    explicit Mosaic(std::string path) : path_(std::move(path)) {}
    std::string path_;
};

}  // namespace terray
