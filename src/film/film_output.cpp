// SPDX-License-Identifier: Apache-2.0
// Container files over libavformat.
#include "film/film_output.h"

namespace terray {

Result<std::unique_ptr<FilmOutput>> FilmOutput::create(const std::string& path,
                                                       const FilmSpec& spec) {
    auto file = PartialFile::create(path);
    if (!file) return file.error();
    auto output = std::make_unique<FilmOutput>();
    output->file_ = std::move(*file);
    output->file_->closeStream();
    output->frame_ = av_inv_q(frameRate(spec.fps));
    const std::string& temporary = output->file_->temporaryPath();
    AVFormatContext* context = nullptr;
    avformat_alloc_output_context2(
        &context, nullptr, spec.format == FilmFormat::Mp4 ? "mp4" : "webm", temporary.c_str());
    output->context_.reset(context);
    AVStream* stream = context ? avformat_new_stream(context, nullptr) : nullptr;
    if (!stream)
        return makeError(ErrorCode::Resource, "this machine's FFmpeg cannot write '{}'", path);
    context->flags |= AVFMT_FLAG_BITEXACT;
    stream->time_base = output->frame_;
    stream->avg_frame_rate = av_inv_q(output->frame_);
    const int opened = avio_open(&context->pb, temporary.c_str(), AVIO_FLAG_WRITE);
    if (opened < 0) return output->writeError(opened);
    return output;
}

Result<void> FilmOutput::start(bool fastStart) {
    AVDictionary* settings = nullptr;
    if (fastStart) av_dict_set(&settings, "movflags", "+faststart", 0);
    const int done = avformat_write_header(context_.get(), &settings);
    av_dict_free(&settings);
    if (done < 0) return writeError(done);
    return {};
}

Result<void> FilmOutput::write(AVPacket& packet) {
    if (packet.duration == 0) packet.duration = 1;
    packet.stream_index = 0;
    av_packet_rescale_ts(&packet, frame_, stream().time_base);
    const int done = av_interleaved_write_frame(context_.get(), &packet);
    if (done < 0) return writeError(done);
    return {};
}

Result<void> FilmOutput::finish() {
    const QuietAv quiet;
    int done = av_write_trailer(context_.get());
    if (done >= 0 && context_->pb->error < 0) done = context_->pb->error;
    const int closed = avio_closep(&context_->pb);
    if (done < 0 || closed < 0) return writeError(done < 0 ? done : closed);
    return file_->publish();
}

}  // namespace terray
