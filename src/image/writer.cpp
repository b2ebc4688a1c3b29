// SPDX-License-Identifier: Apache-2.0
// Chooses the format by extension and checks that it can hold the picture.
#include "image/writer.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>

#include "base/assert.h"
#include "image/banded_writer.h"

namespace terray {
namespace {

enum class Format { Png, Jpeg, Exr, Tiff, Unknown };

Format formatOf(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".png") return Format::Png;
    if (extension == ".jpg" || extension == ".jpeg") return Format::Jpeg;
    if (extension == ".exr") return Format::Exr;
    if (extension == ".tif" || extension == ".tiff") return Format::Tiff;
    return Format::Unknown;
}

Error cannotHold(const std::string& path, const char* what, const char* instead) {
    return makeError(ErrorCode::Usage, "'{}' cannot hold {}; use {}", path, what, instead);
}

Result<void> checkFormat(const std::string& path, Format format, const ImageSpec& spec) {
    constexpr int kJpegMax = 65500;
    if (format == Format::Unknown) {
        return makeError(ErrorCode::Usage,
                         "'{}' has no known picture extension; use .png, .jpg, .exr or .tif", path);
    }
    const bool isFloat = spec.type == PixelType::Float;
    if (isFloat && (format == Format::Png || format == Format::Jpeg)) {
        return cannotHold(path, "floating-point values", ".tif or .exr");
    }
    if (!isFloat && format == Format::Exr) {
        return cannotHold(path, "8-bit pixels", ".png or .tif");
    }
    if (format == Format::Jpeg && spec.channels != 3) {
        return cannotHold(path, "transparency or a single channel", ".png or .tif");
    }
    if (format == Format::Jpeg && std::max(spec.width, spec.height) > kJpegMax) {
        return cannotHold(path, "more than 65500 pixels a side", ".png or .tif");
    }
    return {};
}

}  // namespace

Result<void> ImageWriter::writeRows(std::span<const uint8_t>) {
    return makeError(ErrorCode::Usage, "this picture takes no 8-bit rows");
}

Result<void> ImageWriter::writeRows(std::span<const float>) {
    return makeError(ErrorCode::Usage, "this picture takes no floating-point rows");
}

bool isLinearFormat(const std::string& path) { return formatOf(path) == Format::Exr; }

Result<std::unique_ptr<ImageWriter>> makeImageWriter(const std::string& path,
                                                     const ImageSpec& spec) {
    TERRAY_ASSERT(spec.width >= 1 && spec.height >= 1);
    TERRAY_ASSERT(spec.channels == 1 || spec.channels == 3 || spec.channels == 4);
    const Format format = formatOf(path);
    TERRAY_TRY(checkFormat(path, format, spec));
    Result<std::unique_ptr<PartialFile>> file = PartialFile::create(path);
    if (!file) return file.error();
    switch (format) {
        case Format::Png: return makePngWriter(spec, std::move(*file));
        case Format::Jpeg: return makeJpegWriter(spec, std::move(*file));
        case Format::Exr: return makeExrWriter(spec, std::move(*file));
        case Format::Tiff:
        case Format::Unknown: break;
    }
    return makeTiffWriter(spec, std::move(*file));
}

}  // namespace terray
