// SPDX-License-Identifier: Apache-2.0
// Copies packets from piece to film; their times become counts of frames on the way.
#include "film/film_join.h"

#include <algorithm>

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

/// Packets of one piece after the other, timed in frames of the film.
class Joint {
public:
    Joint(AVRational frame, bool onePiece) : frame_(frame), onePiece_(onePiece) {}

    void begin(const FilmPiece& piece) { first_ = decoded_ = piece.firstFrame; }

    /// A container may round times (WebM: to milliseconds); frames are whole.
    void time(AVPacket& packet, AVRational from) {
        const auto frames = [&](int64_t t) {
            return av_rescale_q_rnd(t, from, frame_, AV_ROUND_NEAR_INF);
        };
        packet.pts = first_ + frames(packet.pts);
        packet.dts = first_ + frames(packet.dts);
        packet.duration = frames(packet.duration);
        packet.pos = -1;
        if (delay_ < 0) delay_ = packet.pts - packet.dts;
        // Short pieces are decoded sooner before they are shown; the film keeps one distance.
        if (!onePiece_) packet.dts = std::min(packet.pts, decoded_++ - delay_);
    }

private:
    AVRational frame_;
    bool onePiece_;
    int64_t first_ = 0, decoded_ = 0, delay_ = -1;
};

}  // namespace

Result<void> joinFilm(const std::vector<FilmPiece>& pieces, const std::string& path,
                      const FilmSpec& spec) {
    const QuietAv quiet;
    auto output = FilmOutput::create(path, spec);
    if (!output) return output.error();
    const AvPacketHandle packet(av_packet_alloc());
    Joint joint(av_inv_q(frameRate(spec.fps)), pieces.size() == 1);
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
        joint.begin(piece);
        for (;;) {
            const int got = av_read_frame(input->get(), packet.get());
            if (got == AVERROR_EOF) break;
            if (got < 0) return damaged(piece.path, got);
            joint.time(*packet, from.time_base);
            TERRAY_TRY((*output)->write(*packet));
        }
    }
    return (*output)->finish();
}

}  // namespace terray
