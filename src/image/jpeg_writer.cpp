// SPDX-License-Identifier: Apache-2.0
// JPEG over libjpeg-turbo: 8 bit RGB. libjpeg reports errors by longjmp, so every function that
// calls it keeps no objects with destructors alive.
#include <csetjmp>
#include <cstdio>
// jpeglib.h needs size_t and FILE from above
#include <jpeglib.h>

#include <algorithm>
#include <cerrno>

#include "image/banded_writer.h"

namespace terray {
namespace {

constexpr int kFullColourQuality = 90;  // from here on, colour is not subsampled

class JpegWriter final : public BandedWriter {
public:
    JpegWriter(const ImageSpec& spec, std::unique_ptr<PartialFile> file)
        : BandedWriter(spec, std::move(file)) {
        jpeg_.err = jpeg_std_error(&errors_);
        errors_.error_exit = onError;
        errors_.output_message = onMessage;
        jpeg_.client_data = this;
    }
    ~JpegWriter() override {
        if (created_) jpeg_destroy_compress(&jpeg_);
    }

    Result<void> open() {
        if (!start()) return file().writeError(message_);
        return {};
    }

private:
    Result<void> putRows(const std::byte* pixels, int, int rows) override {
        if (!writeScanlines(reinterpret_cast<const JSAMPLE*>(pixels), rows)) {
            return file().writeError(message_);
        }
        return {};
    }

    Result<void> close() override {
        if (!writeEnd()) return file().writeError(message_);
        return {};
    }

    bool start() {
        if (setjmp(jump_)) return false;
        jpeg_create_compress(&jpeg_);
        created_ = true;
        jpeg_stdio_dest(&jpeg_, file().stream());
        jpeg_.image_width = static_cast<JDIMENSION>(spec().width);
        jpeg_.image_height = static_cast<JDIMENSION>(spec().height);
        jpeg_.input_components = 3;
        jpeg_.in_color_space = JCS_RGB;
        jpeg_set_defaults(&jpeg_);
        const int quality = std::clamp(spec().jpegQuality, 1, 100);
        jpeg_set_quality(&jpeg_, quality, TRUE);
        if (quality >= kFullColourQuality) {
            jpeg_.comp_info[0].h_samp_factor = 1;
            jpeg_.comp_info[0].v_samp_factor = 1;
        }
        jpeg_start_compress(&jpeg_, TRUE);
        if (!spec().description.empty()) {
            constexpr size_t kMarkerMax = 65533;
            const size_t size = std::min(spec().description.size(), kMarkerMax);
            jpeg_write_marker(&jpeg_, JPEG_COM,
                              reinterpret_cast<const JOCTET*>(spec().description.data()),
                              static_cast<unsigned>(size));
        }
        return true;
    }

    bool writeScanlines(const JSAMPLE* pixels, int rows) {
        if (setjmp(jump_)) return false;
        const size_t stride = rowBytes();
        for (int row = 0; row < rows; ++row) {
            JSAMPROW line = const_cast<JSAMPROW>(pixels + static_cast<size_t>(row) * stride);
            jpeg_write_scanlines(&jpeg_, &line, 1);
        }
        return true;
    }

    bool writeEnd() {
        if (setjmp(jump_)) return false;
        jpeg_finish_compress(&jpeg_);
        return true;
    }

    static void onError(j_common_ptr common) {
        auto* self = static_cast<JpegWriter*>(common->client_data);
        if (std::ferror(self->file().stream())) self->file().keepErrno();
        common->err->format_message(common, self->message_);
        std::longjmp(self->jump_, 1);
    }
    static void onMessage(j_common_ptr) {}

    jpeg_compress_struct jpeg_{};
    jpeg_error_mgr errors_{};
    std::jmp_buf jump_{};
    bool created_ = false;
    char message_[JMSG_LENGTH_MAX] = "out of memory";
};

}  // namespace

Result<std::unique_ptr<ImageWriter>> makeJpegWriter(const ImageSpec& spec,
                                                    std::unique_ptr<PartialFile> file) {
    auto writer = std::make_unique<JpegWriter>(spec, std::move(file));
    TERRAY_TRY(writer->open());
    return std::unique_ptr<ImageWriter>(std::move(writer));
}

}  // namespace terray
