// SPDX-License-Identifier: Apache-2.0
// Copies packets from piece to film; their times become counts of frames on the way.
#include "film/film_join.h"

#include "film/av_handles.h"
#include "film/film_output.h"

namespace terray {
namespace {

Error damaged(const std::string& path, int code) {
    return makeError(ErrorCode::Failed,
                     "'{}', a piece of the film, cannot be read ({}); remove it and go on with "
                     "--resume",
                     path, avErrorText(code));
}

Result<AvInputHandle> openPiece(const std::string& path) {
    AVFormatContext* context = nullptr;
    int done = avformat_open_input(&context, path.c_str(), nullptr, nullptr);
    if (done < 0) return damaged(path, done);
    AvInputHandle input(context);
    done = avformat_find_stream_info(context, nullptr);
    if (done >= 0 && context->nb_streams != 1) done = AVERROR_INVALIDDATA;
    if (done < 0) return damaged(path, done);
    return input;
}

/// A container may round times (WebM: to milliseconds); frames are whole.
void countFrames(AVPacket& packet, AVRational from, AVRational frame, int64_t first) {
    packet.pts = first + av_rescale_q_rnd(packet.pts, from, frame, AV_ROUND_NEAR_INF);
    packet.dts = first + av_rescale_q_rnd(packet.dts, from, frame, AV_ROUND_NEAR_INF);
    packet.duration = av_rescale_q_rnd(packet.duration, from, frame, AV_ROUND_NEAR_INF);
    packet.pos = -1;
}

}  // namespace

Result<void> joinFilm(const std::vector<FilmPiece>& pieces, const std::string& path,
                      const FilmSpec& spec) {
    const QuietAv quiet;
    auto output = FilmOutput::create(path, spec);
    if (!output) return output.error();
    const AvPacketHandle packet(av_packet_alloc());
    const AVRational frame = av_inv_q(frameRate(spec.fps));
    bool started = false;
    for (const FilmPiece& piece : pieces) {
        auto input = openPiece(piece.path);
        if (!input) return input.error();
        const AVStream& from = *(*input)->streams[0];
        if (!started) {
            avcodec_parameters_copy((*output)->stream().codecpar, from.codecpar);
            (*output)->stream().codecpar->codec_tag = 0;
            TERRAY_TRY((*output)->start(spec.format == FilmFormat::Mp4));
            started = true;
        }
        for (;;) {
            const int got = av_read_frame(input->get(), packet.get());
            if (got == AVERROR_EOF) break;
            if (got < 0) return damaged(piece.path, got);
            countFrames(*packet, from.time_base, frame, piece.firstFrame);
            TERRAY_TRY((*output)->write(*packet));
        }
    }
    return (*output)->finish();
}

}  // namespace terray
