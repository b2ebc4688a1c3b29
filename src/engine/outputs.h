// SPDX-License-Identifier: Apache-2.0
// The files of one render: picture and AOVs, complete or not at all.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/bands.h"
#include "image/writer.h"

namespace terray {

/// confined.
class OutputFiles {
public:
    /// Makes the temporary files; fails at once where nothing can be written.
    static Result<OutputFiles> make(int width, int height, bool hasAlpha,
                                    const OutputOptions& outputs,
                                    const std::optional<GeoReference>& georeference);

    BandDemand demand() const;
    Result<void> writeBand(const Band& band);
    /// Gives all files their names.
    Result<void> finish();
    double writeMs() const { return writeMs_; }

private:
    Result<void> writePicture(const Band& band);

    bool linear_ = false;
    int channels_ = 3;
    bool onWhite_ = false;  ///< the format has no alpha, the picture has
    std::unique_ptr<ImageWriter> picture_;
    std::vector<AovOutput> aovs_;
    std::vector<std::unique_ptr<ImageWriter>> aovWriters_;
    std::vector<uint8_t> bytes_;
    std::vector<float> floats_;
    double writeMs_ = 0;
};

}  // namespace terray
