// SPDX-License-Identifier: Apache-2.0
// What all picture formats share: counting rows, checking their type, publishing the file.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "image/partial_file.h"
#include "image/writer.h"

namespace terray {

/// Base of the formats: they only put rows and close. confined.
class BandedWriter : public ImageWriter {
public:
    Result<void> writeRows(std::span<const uint8_t> pixels) final;
    Result<void> writeRows(std::span<const float> pixels) final;
    Result<void> finish() final;

protected:
    BandedWriter(ImageSpec spec, std::unique_ptr<PartialFile> file)
        : spec_(std::move(spec)), file_(std::move(file)) {}

    /// Puts the next `rows` rows, the first of which is row `firstRow`.
    virtual Result<void> putRows(const std::byte* pixels, int firstRow, int rows) = 0;
    /// All rows are there: writes whatever is still to be written.
    virtual Result<void> close() = 0;

    const ImageSpec& spec() const { return spec_; }
    PartialFile& file() { return *file_; }
    size_t rowBytes() const;

private:
    Result<void> put(PixelType type, const std::byte* pixels, size_t bytes);

    ImageSpec spec_;
    std::unique_ptr<PartialFile> file_;
    int rowsWritten_ = 0;
    bool failed_ = false;
};

Result<std::unique_ptr<ImageWriter>> makePngWriter(const ImageSpec& spec,
                                                   std::unique_ptr<PartialFile> file);
Result<std::unique_ptr<ImageWriter>> makeJpegWriter(const ImageSpec& spec,
                                                    std::unique_ptr<PartialFile> file);
Result<std::unique_ptr<ImageWriter>> makeExrWriter(const ImageSpec& spec,
                                                   std::unique_ptr<PartialFile> file);
Result<std::unique_ptr<ImageWriter>> makeTiffWriter(const ImageSpec& spec,
                                                    std::unique_ptr<PartialFile> file);

}  // namespace terray
