// SPDX-License-Identifier: Apache-2.0
// TIFF through GDAL: bytes or floats, deflated strips, georeferenced when asked. Strips are handed
// over whole and flushed at once, so that GDAL's block cache stays small.
#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <vector>

#include "image/banded_writer.h"

namespace terray {
namespace {

constexpr size_t kStripBytes = 1 << 18;

/// While alive, this thread's GDAL errors are kept instead of printed, and no .aux.xml is written.
class GdalScope {
public:
    GdalScope() {
        CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", "NO");
        CPLPushErrorHandlerEx(onError, this);
        CPLErrorReset();
    }
    ~GdalScope() {
        CPLPopErrorHandler();
        CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", nullptr);
    }
    GdalScope(const GdalScope&) = delete;
    GdalScope& operator=(const GdalScope&) = delete;
    bool failed() const { return !message_.empty(); }
    const std::string& message() const { return message_; }

private:
    static void CPL_STDCALL onError(CPLErr severity, CPLErrorNum, const char* message) {
        auto* self = static_cast<GdalScope*>(CPLGetErrorHandlerUserData());
        if (severity >= CE_Failure && self->message_.empty()) self->message_ = message;
    }
    std::string message_;
};

GDALDriver* gtiffDriver() {
    static std::once_flag once;
    std::call_once(once, GDALAllRegister);
    return GetGDALDriverManager()->GetDriverByName("GTiff");
}

class TiffWriter final : public BandedWriter {
public:
    TiffWriter(const ImageSpec& spec, std::unique_ptr<PartialFile> file)
        : BandedWriter(spec, std::move(file)),
          stripRows_(static_cast<int>(
              std::clamp<size_t>(kStripBytes / rowBytes(), 1, static_cast<size_t>(spec.height)))) {}

    ~TiffWriter() override {
        const GdalScope gdal;
        dataset_.reset();
    }

    Result<void> open() {
        file().closeStream();  // GDAL makes the file again
        const GdalScope gdal;
        GDALDriver* driver = gtiffDriver();
        if (!driver) return file().writeError("this GDAL has no GTiff driver");
        dataset_.reset(driver->Create(file().temporaryPath().c_str(), spec().width, spec().height,
                                      spec().channels, gdalType(), creationOptions().List()));
        if (!dataset_) return file().writeError(gdal.message());
        return describe(gdal);
    }

private:
    GDALDataType gdalType() const {
        return spec().type == PixelType::Byte ? GDT_Byte : GDT_Float32;
    }
    int sampleBytes() const { return spec().type == PixelType::Byte ? 1 : 4; }

    CPLStringList creationOptions() const {
        const bool bytes = spec().type == PixelType::Byte;
        CPLStringList options;
        options.SetNameValue("COMPRESS", "DEFLATE");
        options.SetNameValue("PREDICTOR", bytes ? "2" : "3");
        options.SetNameValue("ZLEVEL", "3");
        options.SetNameValue("NUM_THREADS", "ALL_CPUS");
        options.SetNameValue("BIGTIFF", "IF_SAFER");
        options.SetNameValue("INTERLEAVE", "PIXEL");
        options.SetNameValue("BLOCKYSIZE", std::to_string(stripRows_).c_str());
        if (spec().channels >= 3 && bytes) options.SetNameValue("PHOTOMETRIC", "RGB");
        if (spec().channels == 4) options.SetNameValue("ALPHA", "NON-PREMULTIPLIED");
        return options;
    }

    Result<void> describe(const GdalScope& gdal) {
        dataset_->SetMetadataItem("TIFFTAG_SOFTWARE", "terray");
        if (!spec().description.empty()) {
            dataset_->SetMetadataItem("TIFFTAG_IMAGEDESCRIPTION", spec().description.c_str());
        }
        if (spec().type == PixelType::Float && spec().channels != 4) {
            for (int band = 1; band <= spec().channels; ++band) {
                dataset_->GetRasterBand(band)->SetNoDataValue(
                    std::numeric_limits<double>::quiet_NaN());
            }
        }
        if (spec().georeference) georeference(*spec().georeference);
        if (gdal.failed()) return file().writeError(gdal.message());
        return {};
    }

    void georeference(const GeoReference& geo) {
        double transform[6] = {geo.originX, geo.pixelX, 0, geo.originY, 0, geo.pixelY};
        dataset_->SetGeoTransform(transform);
        if (geo.crsWkt.empty()) return;
        OGRSpatialReference crs;
        if (crs.importFromWkt(geo.crsWkt.c_str()) == OGRERR_NONE) dataset_->SetSpatialRef(&crs);
    }

    Result<void> putRows(const std::byte* pixels, int firstRow, int rows) override {
        const GdalScope gdal;
        for (int row = 0; row < rows;) {
            const int inStrip = (firstRow + row) % stripRows_;
            const int count = std::min(stripRows_ - inStrip, rows - row);
            const std::byte* source = pixels + static_cast<size_t>(row) * rowBytes();
            if (count == stripRows_) {
                writeStrip(source, firstRow + row, count);
            } else {
                strip_.resize(static_cast<size_t>(stripRows_) * rowBytes());
                std::memcpy(strip_.data() + static_cast<size_t>(inStrip) * rowBytes(), source,
                            static_cast<size_t>(count) * rowBytes());
                const int end = firstRow + row + count;
                if (inStrip + count == stripRows_ || end == spec().height) {
                    writeStrip(strip_.data(), end - inStrip - count, inStrip + count);
                }
            }
            row += count;
            if (gdal.failed()) return file().writeError(gdal.message());
        }
        return {};
    }

    void writeStrip(const std::byte* pixels, int firstRow, int rows) {
        const GSpacing sample = sampleBytes();
        const GSpacing pixel = sample * spec().channels;
        const CPLErr done = dataset_->RasterIO(GF_Write, 0, firstRow, spec().width, rows,
                                               const_cast<std::byte*>(pixels), spec().width, rows,
                                               gdalType(), spec().channels, nullptr, pixel,
                                               pixel * spec().width, sample, nullptr);
        if (done != CE_None) return;  // GdalScope has kept the reason
        for (int band = 1; band <= spec().channels; ++band) {
            if (dataset_->GetRasterBand(band)->FlushCache(false) != CE_None) return;
        }
    }

    Result<void> close() override {
        const GdalScope gdal;
        dataset_->FlushCache(true);
        dataset_.reset();
        if (gdal.failed()) return file().writeError(gdal.message());
        return {};
    }

    int stripRows_;
    std::vector<std::byte> strip_;
    GDALDatasetUniquePtr dataset_;
};

}  // namespace

Result<std::unique_ptr<ImageWriter>> makeTiffWriter(const ImageSpec& spec,
                                                    std::unique_ptr<PartialFile> file) {
    auto writer = std::make_unique<TiffWriter>(spec, std::move(file));
    TERRAY_TRY(writer->open());
    return std::unique_ptr<ImageWriter>(std::move(writer));
}

}  // namespace terray
