// SPDX-License-Identifier: Apache-2.0
// PNG over libpng: 8 bit, sRGB, quick compression. libpng reports errors by longjmp, so every
// function that calls it keeps no objects with destructors alive.
#include <png.h>

#include <csetjmp>
#include <cstdio>

#include "image/banded_writer.h"

namespace terray {
namespace {

constexpr int kCompression = 2;  // of 9: 3 takes twice as long for files 5 % smaller
constexpr int kFilters = PNG_FILTER_SUB | PNG_FILTER_UP;

class PngWriter final : public BandedWriter {
public:
    PngWriter(const ImageSpec& spec, std::unique_ptr<PartialFile> file)
        : BandedWriter(spec, std::move(file)) {}
    ~PngWriter() override { png_destroy_write_struct(&png_, &info_); }

    Result<void> open() {
        png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, onError, onWarning);
        if (png_) info_ = png_create_info_struct(png_);
        if (!info_ || !writeHeader()) return file().writeError(message_);
        return {};
    }

private:
    Result<void> putRows(const std::byte* pixels, int, int rows) override {
        if (!writeScanlines(reinterpret_cast<const png_byte*>(pixels), rows)) {
            return file().writeError(message_);
        }
        return {};
    }

    Result<void> close() override {
        if (!writeEnd()) return file().writeError(message_);
        return {};
    }

    bool writeHeader() {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
        png_set_write_fn(png_, this, onWrite, onFlush);
        png_set_compression_level(png_, kCompression);
        png_set_compression_buffer_size(png_, 1 << 16);
        png_set_filter(png_, PNG_FILTER_TYPE_BASE, kFilters);
        png_set_IHDR(png_, info_, static_cast<png_uint_32>(spec().width),
                     static_cast<png_uint_32>(spec().height), 8, colourType(), PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
        if (!spec().description.empty()) writeDescription();
        png_write_info(png_, info_);
        return true;
    }

    int colourType() const {
        if (spec().channels == 1) return PNG_COLOR_TYPE_GRAY;
        return spec().channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;
    }

    void writeDescription() {
        char key[] = "Description";
        png_text text{};
        text.compression = PNG_ITXT_COMPRESSION_NONE;
        text.key = key;
        text.text = const_cast<char*>(spec().description.c_str());  // libpng copies it
        png_set_text(png_, info_, &text, 1);
    }

    bool writeScanlines(const png_byte* pixels, int rows) {
        if (setjmp(png_jmpbuf(png_))) return false;
        const size_t stride = rowBytes();
        for (int row = 0; row < rows; ++row) {
            png_write_row(png_, pixels + static_cast<size_t>(row) * stride);
        }
        return true;
    }

    bool writeEnd() {
        if (setjmp(png_jmpbuf(png_))) return false;
        png_write_end(png_, nullptr);
        return true;
    }

    static void onError(png_structp png, png_const_charp message) {
        auto* self = static_cast<PngWriter*>(png_get_error_ptr(png));
        std::snprintf(self->message_, sizeof self->message_, "%s", message);
        png_longjmp(png, 1);
    }
    static void onWarning(png_structp, png_const_charp) {}
    static void onWrite(png_structp png, png_bytep bytes, size_t size) {
        auto* self = static_cast<PngWriter*>(png_get_io_ptr(png));
        if (!self->file().write(bytes, size)) png_error(png, "write error");
    }
    static void onFlush(png_structp) {}

    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
    char message_[128] = "out of memory";
};

}  // namespace

Result<std::unique_ptr<ImageWriter>> makePngWriter(const ImageSpec& spec,
                                                   std::unique_ptr<PartialFile> file) {
    auto writer = std::make_unique<PngWriter>(spec, std::move(file));
    TERRAY_TRY(writer->open());
    return std::unique_ptr<ImageWriter>(std::move(writer));
}

}  // namespace terray
