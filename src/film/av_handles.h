// SPDX-License-Identifier: Apache-2.0
// Owning handles of FFmpeg's objects, and its errors as words.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

#include "film/film_spec.h"

namespace terray {

struct AvFree {
    void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
    void operator()(AVFrame* p) const { av_frame_free(&p); }
    void operator()(AVPacket* p) const { av_packet_free(&p); }
    void operator()(SwsContext* p) const { sws_freeContext(p); }
};
using AvCodecHandle = std::unique_ptr<AVCodecContext, AvFree>;
using AvFrameHandle = std::unique_ptr<AVFrame, AvFree>;
using AvPacketHandle = std::unique_ptr<AVPacket, AvFree>;
using SwsHandle = std::unique_ptr<SwsContext, AvFree>;

/// A file being written: closed and freed without its trailer if that was not asked for.
struct AvOutputClose {
    void operator()(AVFormatContext* p) const {
        if (p->pb) avio_closep(&p->pb);
        avformat_free_context(p);
    }
};
using AvOutputHandle = std::unique_ptr<AVFormatContext, AvOutputClose>;

struct AvInputClose {
    void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
};
using AvInputHandle = std::unique_ptr<AVFormatContext, AvInputClose>;

/// While one lives, FFmpeg itself says nothing on stderr: containers tell of their progress.
/// confined to one thread at a time; what the program had set comes back.
class QuietAv {
public:
    QuietAv() : level_(av_log_get_level()) {
        if (level_ > AV_LOG_FATAL) av_log_set_level(AV_LOG_FATAL);
    }
    ~QuietAv() { av_log_set_level(level_); }
    QuietAv(const QuietAv&) = delete;
    QuietAv& operator=(const QuietAv&) = delete;

private:
    int level_;
};

inline std::string avErrorText(int code) {
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return text;
}

const char* encoderName(FilmFormat format);
/// As a fraction: 29.97002997 is 30000/1001.
AVRational frameRate(double fps);

}  // namespace terray
