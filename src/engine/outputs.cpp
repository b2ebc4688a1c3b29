// SPDX-License-Identifier: Apache-2.0
// Writing bands into files.
#include "engine/outputs.h"

#include <algorithm>
#include <cctype>

#include "base/stopwatch.h"
#include "terray/version.h"

namespace terray {
namespace {

bool isJpeg(std::string path) {
    std::transform(path.begin(), path.end(), path.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return path.ends_with(".jpg") || path.ends_with(".jpeg");
}

ImageSpec baseSpec(int width, int height, const std::optional<GeoReference>& georeference) {
    ImageSpec spec;
    spec.width = width;
    spec.height = height;
    spec.georeference = georeference;
    spec.description = std::string("Terray ") + version();
    return spec;
}

}  // namespace

Result<OutputFiles> OutputFiles::make(int width, int height, bool hasAlpha,
                                      const OutputOptions& outputs,
                                      const std::optional<GeoReference>& georeference) {
    OutputFiles files;
    if (!outputs.path.empty()) {
        files.linear_ = isLinearFormat(outputs.path);
        files.onWhite_ = hasAlpha && isJpeg(outputs.path);
        files.channels_ = hasAlpha && !files.onWhite_ ? 4 : 3;
        ImageSpec spec = baseSpec(width, height, georeference);
        spec.channels = files.channels_;
        spec.type = files.linear_ ? PixelType::Float : PixelType::Byte;
        spec.halfFloat = true;
        spec.jpegQuality = outputs.jpegQuality;
        auto writer = makeImageWriter(outputs.path, spec);
        if (!writer) return writer.error();
        files.picture_ = std::move(*writer);
    }
    for (const AovOutput& aov : outputs.aovs) {
        ImageSpec spec = baseSpec(width, height, georeference);
        spec.channels = aovChannels(aov.aov);
        if (spec.channels == 3) spec.channelNames = {"X", "Y", "Z"};
        spec.type = PixelType::Float;
        auto writer = makeImageWriter(aov.path, spec);
        if (!writer) return writer.error();
        files.aovs_.push_back(aov);
        files.aovWriters_.push_back(std::move(*writer));
    }
    return files;
}

BandDemand OutputFiles::demand() const {
    BandDemand demand;
    demand.linear = picture_ && linear_;
    demand.display = picture_ && !linear_;
    for (const AovOutput& aov : aovs_) demand.aovs.push_back(aov.aov);
    return demand;
}

Result<void> OutputFiles::writePicture(const Band& band) {
    const auto channels = static_cast<size_t>(channels_);
    if (linear_) {
        floats_.resize(band.linear.size() * channels);
        for (size_t k = 0; k < band.linear.size(); ++k) {
            // The writer takes straight alpha; sums are premultiplied.
            const Colour& c = band.linear[k];
            const float scale = channels == 4 && c.a > 0 ? 1.0f / c.a : 1.0f;
            float* out = &floats_[k * channels];
            out[0] = c.r * scale;
            out[1] = c.g * scale;
            out[2] = c.b * scale;
            if (channels == 4) out[3] = c.a;
        }
        return picture_->writeRows(std::span<const float>(floats_));
    }
    if (channels == 4) return picture_->writeRows(std::span<const uint8_t>(band.display));
    const size_t pixels = band.display.size() / 4;
    bytes_.resize(pixels * 3);
    for (size_t k = 0; k < pixels; ++k) {
        const uint8_t* in = &band.display[k * 4];
        for (size_t c = 0; c < 3; ++c) {
            const int onWhite = 255 + (in[c] - 255) * in[3] / 255;
            bytes_[k * 3 + c] = onWhite_ ? static_cast<uint8_t>(onWhite) : in[c];
        }
    }
    return picture_->writeRows(std::span<const uint8_t>(bytes_));
}

Result<void> OutputFiles::writeBand(const Band& band) {
    const Stopwatch watch;
    if (picture_) TERRAY_TRY(writePicture(band));
    for (size_t k = 0; k < aovWriters_.size(); ++k)
        TERRAY_TRY(aovWriters_[k]->writeRows(std::span<const float>(band.aovs[k])));
    writeMs_ += watch.elapsedMs();
    return {};
}

Result<void> OutputFiles::finish() {
    const Stopwatch watch;
    if (picture_) TERRAY_TRY(picture_->finish());
    for (auto& writer : aovWriters_) TERRAY_TRY(writer->finish());
    writeMs_ += watch.elapsedMs();
    return {};
}

}  // namespace terray
