// SPDX-License-Identifier: Apache-2.0
// Colours to YUV, frames to packets, packets to a file.
#include "film/film_encoder.h"

#include <cmath>

#include "film/av_handles.h"
#include "film/film_output.h"

namespace terray {
namespace {

/// Whatever the machine has, so that films do not depend on it.
constexpr int kEncoderThreads = 4;

struct Setting {
    const char *name, *value;
};
/// Macroblock trees are off: x264 computes them with approximate reciprocals, which differ between
/// processors, and in version 164 its AVX-512 code gives other values from run to run.
constexpr Setting kX264[] = {
    {"preset", "medium"}, {"profile", "high"}, {"crf", "18"}, {"mbtree", "0"}};
constexpr Setting kVp9[] = {
    {"deadline", "good"}, {"cpu-used", "3"}, {"crf", "24"}, {"row-mt", "0"}, {"tile-columns", "2"}};

class Encoder final : public FilmEncoder {
public:
    Encoder(const FilmSpec& spec, std::unique_ptr<FilmOutput> output)
        : spec_(spec), output_(std::move(output)) {}

    Result<void> open() {
        const AVCodec* codec = avcodec_find_encoder_by_name(encoderName(spec_.format));
        codec_.reset(codec ? avcodec_alloc_context3(codec) : nullptr);
        frame_.reset(av_frame_alloc());
        packet_.reset(av_packet_alloc());
        if (!codec_ || !frame_ || !packet_) return cannotStart("it is not there");
        describe();
        const int started = startCodec();
        if (started < 0) return cannotStart(avErrorText(started));
        TERRAY_TRY(openColours());
        AVStream& stream = output_->stream();
        avcodec_parameters_from_context(stream.codecpar, codec_.get());
        return output_->start(false);
    }

    Result<void> add(std::span<const uint8_t> rgba, int64_t index) override {
        int done = av_frame_make_writable(frame_.get());
        if (done < 0) return output_->writeError(done);
        const uint8_t* const from[] = {rgba.data()};
        const int strides[] = {4 * spec_.width};
        sws_scale(colours_.get(), from, strides, 0, spec_.height, frame_->data, frame_->linesize);
        frame_->pts = index;
        done = avcodec_send_frame(codec_.get(), frame_.get());
        return done < 0 ? output_->writeError(done) : takePackets();
    }

    Result<void> finish() override {
        avcodec_send_frame(codec_.get(), nullptr);
        TERRAY_TRY(takePackets());
        return output_->finish();
    }

private:
    Error cannotStart(const std::string& why) const {
        return makeError(ErrorCode::Resource,
                         "FFmpeg's encoder {} does not start ({}); write frames/%05d.png instead",
                         encoderName(spec_.format), why);
    }

    void describe() {
        AVCodecContext& c = *codec_;
        c.log_level_offset = AV_LOG_TRACE;  // says nothing on stderr
        c.width = spec_.width;
        c.height = spec_.height;
        c.framerate = frameRate(spec_.fps);
        c.time_base = av_inv_q(c.framerate);
        c.pix_fmt = AV_PIX_FMT_YUV420P;
        c.color_range = AVCOL_RANGE_MPEG;
        c.color_primaries = AVCOL_PRI_BT709;
        c.color_trc = AVCOL_TRC_BT709;
        c.colorspace = AVCOL_SPC_BT709;
        c.chroma_sample_location = AVCHROMA_LOC_LEFT;
        c.gop_size = spec_.pieceFrames;
        if (spec_.gaps) c.max_b_frames = 0;  // with them containers would count the time wrongly
        c.thread_count = kEncoderThreads;
        c.flags |= AV_CODEC_FLAG_BITEXACT;
        if (output_->wantsGlobalHeader()) c.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }

    int startCodec() {
        AVDictionary* settings = nullptr;
        const auto set = [&](const auto& table) {
            for (const Setting& setting : table)
                av_dict_set(&settings, setting.name, setting.value, 0);
        };
        if (spec_.format == FilmFormat::Mp4)
            set(kX264);
        else
            set(kVp9);
        const int done = avcodec_open2(codec_.get(), nullptr, &settings);
        const int unknown = av_dict_count(settings);
        av_dict_free(&settings);
        return done >= 0 && unknown > 0 ? AVERROR_OPTION_NOT_FOUND : done;
    }

    Result<void> openColours() {
        colours_.reset(sws_getContext(
            spec_.width, spec_.height, AV_PIX_FMT_RGB0, spec_.width, spec_.height,
            AV_PIX_FMT_YUV420P, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT,
            nullptr, nullptr, nullptr));
        if (!colours_) return cannotStart("no way from RGB to YUV");
        const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
        constexpr int kOne = 1 << 16;
        sws_setColorspaceDetails(colours_.get(), bt709, 1, bt709, 0, 0, kOne, kOne);
        frame_->format = AV_PIX_FMT_YUV420P;
        frame_->width = spec_.width;
        frame_->height = spec_.height;
        const int done = av_frame_get_buffer(frame_.get(), 0);
        if (done < 0) return cannotStart(avErrorText(done));
        return {};
    }

    Result<void> takePackets() {
        for (;;) {
            const int got = avcodec_receive_packet(codec_.get(), packet_.get());
            if (got == AVERROR(EAGAIN) || got == AVERROR_EOF) return {};
            if (got < 0) return output_->writeError(got);
            TERRAY_TRY(output_->write(*packet_));
        }
    }

    FilmSpec spec_;
    std::unique_ptr<FilmOutput> output_;
    AvCodecHandle codec_;
    AvFrameHandle frame_;
    AvPacketHandle packet_;
    SwsHandle colours_;
};

}  // namespace

Result<std::unique_ptr<FilmEncoder>> FilmEncoder::create(const std::string& path,
                                                         const FilmSpec& spec) {
    TERRAY_TRY(checkFilm(spec));
    auto output = FilmOutput::create(path, spec);
    if (!output) return output.error();
    auto encoder = std::make_unique<Encoder>(spec, std::move(*output));
    TERRAY_TRY(encoder->open());
    return std::unique_ptr<FilmEncoder>(std::move(encoder));
}

}  // namespace terray
