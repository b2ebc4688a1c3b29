// SPDX-License-Identifier: Apache-2.0
// Pictures out, band by band: PNG, JPEG, EXR, TIFF; complete or not at all.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "math/affine.h"

namespace terray {

/// Where an ortho picture lies: written into TIFFs.
struct GeoReference {
    std::string crsWkt;  ///< may be empty
    double originX = 0,
           originY = 0;  ///< CRS coordinates of the upper left pixel's upper left corner
    double pixelX = 1, pixelY = -1;  ///< CRS units a pixel
};

/// Writes rows from the top. The file is made under a temporary name beside the target and renamed
/// by finish(); destroyed before that, it leaves nothing. confined.
class ImageWriter {
public:
    virtual ~ImageWriter() = default;
    /// The next rows; pixels.size() is a multiple of width * channels.
    virtual Result<void> writeRows(std::span<const uint8_t> pixels);
    virtual Result<void> writeRows(std::span<const float> pixels);
    virtual Result<void> finish() = 0;
};

enum class PixelType { Byte, Float };

struct ImageSpec {
    int width = 0, height = 0;
    int channels = 3;  ///< 1, 3 or 4 (straight alpha last; EXR stores it associated)
    PixelType type = PixelType::Byte;  ///< Byte: PNG, JPEG, TIFF; Float: EXR, TIFF
    std::optional<GeoReference> georeference;
    int jpegQuality = 92;
    std::string description;                ///< one line of metadata: software, source
    std::vector<std::string> channelNames;  ///< EXR; empty: Y, or R G B (A)
    bool halfFloat = false;                 ///< EXR: 16-bit floats, enough for colour
};

/// Format by extension (.png .jpg .jpeg .exr .tif .tiff). Errors: Usage (unknown extension, format
/// that cannot hold the pixels or size), Failed (cannot write there).
Result<std::unique_ptr<ImageWriter>> makeImageWriter(const std::string& path,
                                                     const ImageSpec& spec);

/// True for .exr: the picture is written as linear floats.
bool isLinearFormat(const std::string& path);

}  // namespace terray
