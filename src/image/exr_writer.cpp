// SPDX-License-Identifier: Apache-2.0
// OpenEXR scan lines, ZIP: linear floats, or halves on request. Alpha is associated in OpenEXR, so
// straight colours are multiplied by it here.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <thread>
#include <vector>

#include "image/banded_writer.h"

namespace terray {
namespace {

constexpr int kBandRows = 64;  // converted at once; OpenEXR compresses blocks of 16

/// OpenEXR's view of a PartialFile.
class ExrStream final : public Imf::OStream {
public:
    explicit ExrStream(PartialFile& file)
        : Imf::OStream(file.temporaryPath().c_str()), file_(file) {}

    void write(const char bytes[], int size) override {
        if (file_.write(bytes, static_cast<size_t>(size))) return;
        failed_ = true;
        throw std::runtime_error("write error");
    }
    uint64_t tellp() override { return static_cast<uint64_t>(ftello(file_.stream())); }
    void seekp(uint64_t position) override {
        if (fseeko(file_.stream(), static_cast<off_t>(position), SEEK_SET) == 0) return;
        file_.keepErrno();
        failed_ = true;
        throw std::runtime_error("seek error");
    }
    bool failed() const { return failed_; }

private:
    PartialFile& file_;
    bool failed_ = false;
};

std::vector<std::string> channelNames(const ImageSpec& spec) {
    if (!spec.channelNames.empty()) return spec.channelNames;
    if (spec.channels == 1) return {"Y"};
    if (spec.channels == 3) return {"R", "G", "B"};
    return {"R", "G", "B", "A"};
}

class ExrWriter final : public BandedWriter {
public:
    ExrWriter(const ImageSpec& spec, std::unique_ptr<PartialFile> file)
        : BandedWriter(spec, std::move(file)),
          stream_(this->file()),
          names_(channelNames(spec)),
          type_(spec.halfFloat ? Imf::HALF : Imf::FLOAT) {}

    Result<void> open() {
        return guarded([this] {
            static const bool threaded = [] {
                Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency()));
                return true;
            }();
            static_cast<void>(threaded);
            output_ = std::make_unique<Imf::OutputFile>(stream_, header());
        });
    }

private:
    Imf::Header header() const {
        Imf::Header header(spec().width, spec().height);
        header.compression() = Imf::ZIP_COMPRESSION;
        header.zipCompressionLevel() = 2;
        for (const std::string& name : names_) header.channels().insert(name, Imf::Channel(type_));
        if (!spec().description.empty()) {
            header.insert("comments", Imf::StringAttribute(spec().description));
        }
        if (spec().georeference) {  // as GDAL's EXR driver reads it
            const GeoReference& geo = *spec().georeference;
            header.insert("gdal:crsWkt", Imf::StringAttribute(geo.crsWkt));
            header.insert("gdal:geoTransform",
                          Imf::M33dAttribute(Imath::M33d(geo.pixelX, 0, geo.originX, 0, geo.pixelY,
                                                         geo.originY, 0, 0, 1)));
        }
        return header;
    }

    Result<void> putRows(const std::byte* pixels, int firstRow, int rows) override {
        const auto* values = reinterpret_cast<const float*>(pixels);
        const size_t rowValues = rowBytes() / sizeof(float);
        return guarded([&] {
            for (int row = 0; row < rows; row += kBandRows) {
                const int count = std::min(kBandRows, rows - row);
                putBand(values + static_cast<size_t>(row) * rowValues, firstRow + row, count);
            }
        });
    }

    void putBand(const float* values, int firstRow, int rows) {
        const size_t channels = static_cast<size_t>(spec().channels);
        const size_t pixels = static_cast<size_t>(spec().width) * static_cast<size_t>(rows);
        if (channels == 4) {
            associated_.assign(values, values + pixels * channels);
            for (size_t k = 0; k < pixels; ++k) {
                float* pixel = &associated_[k * channels];
                for (int c = 0; c < 3; ++c) pixel[c] *= pixel[3];
            }
            values = associated_.data();
        }
        if (type_ == Imf::HALF) {
            halves_.assign(values, values + pixels * channels);
            writeBand(reinterpret_cast<const char*>(halves_.data()), sizeof(half), firstRow, rows);
        } else {
            writeBand(reinterpret_cast<const char*>(values), sizeof(float), firstRow, rows);
        }
    }

    void writeBand(const char* base, size_t sampleBytes, int firstRow, int rows) {
        const size_t pixelBytes = sampleBytes * names_.size();
        const size_t stride = pixelBytes * static_cast<size_t>(spec().width);
        Imf::FrameBuffer buffer;
        for (size_t c = 0; c < names_.size(); ++c) {
            // A slice is addressed from row 0 of the whole picture.
            const uintptr_t origin = reinterpret_cast<uintptr_t>(base + c * sampleBytes) -
                                     static_cast<uintptr_t>(firstRow) * stride;
            buffer.insert(names_[c],
                          Imf::Slice(type_, reinterpret_cast<char*>(origin), pixelBytes, stride));
        }
        output_->setFrameBuffer(buffer);
        output_->writePixels(rows);
    }

    /// Closing writes the table of lines; OpenEXR's destructor hides failures, the stream does not.
    Result<void> close() override {
        output_.reset();
        if (stream_.failed()) return file().writeError();
        return {};
    }

    template <class F>
    Result<void> guarded(F&& work) {
        try {
            work();
        } catch (const std::exception& problem) {
            return file().writeError(problem.what());
        }
        return {};
    }

    ExrStream stream_;
    std::vector<std::string> names_;
    Imf::PixelType type_;
    std::vector<float> associated_;
    std::vector<half> halves_;
    std::unique_ptr<Imf::OutputFile> output_;
};

}  // namespace

Result<std::unique_ptr<ImageWriter>> makeExrWriter(const ImageSpec& spec,
                                                   std::unique_ptr<PartialFile> file) {
    auto writer = std::make_unique<ExrWriter>(spec, std::move(file));
    TERRAY_TRY(writer->open());
    return std::unique_ptr<ImageWriter>(std::move(writer));
}

}  // namespace terray
