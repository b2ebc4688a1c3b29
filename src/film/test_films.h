// SPDX-License-Identifier: Apache-2.0
// What tests of films share: moving pictures, and FFmpeg as the reader.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "film/av_handles.h"

namespace terray {

/// A film as a player sees it.
struct PlayedFilm {
    int width = 0, height = 0;
    std::string codec;
    AVPixelFormat format = AV_PIX_FMT_NONE;
    AVColorSpace space = AVCOL_SPC_UNSPECIFIED;
    double seconds = 0;                       ///< of the container
    std::vector<double> times;                ///< of each frame
    std::vector<std::array<int, 3>> middles;  ///< Y, U, V of each frame's middle
};

inline PlayedFilm playFilm(const std::string& path) {
    PlayedFilm film;
    const QuietAv quiet;
    AVFormatContext* opened = nullptr;
    EXPECT_GE(avformat_open_input(&opened, path.c_str(), nullptr, nullptr), 0) << path;
    if (!opened) return film;
    const AvInputHandle input(opened);
    EXPECT_GE(avformat_find_stream_info(opened, nullptr), 0);
    EXPECT_EQ(opened->nb_streams, 1u);
    const AVStream& stream = *opened->streams[0];
    const AVCodec* codec = avcodec_find_decoder(stream.codecpar->codec_id);
    const AvCodecHandle decoder(avcodec_alloc_context3(codec));
    avcodec_parameters_to_context(decoder.get(), stream.codecpar);
    EXPECT_GE(avcodec_open2(decoder.get(), codec, nullptr), 0);
    film.width = stream.codecpar->width;
    film.height = stream.codecpar->height;
    film.codec = avcodec_get_name(stream.codecpar->codec_id);
    film.seconds = static_cast<double>(opened->duration) / AV_TIME_BASE;
    const AvPacketHandle packet(av_packet_alloc());
    const AvFrameHandle frame(av_frame_alloc());
    for (bool more = true; more;) {
        more = av_read_frame(opened, packet.get()) >= 0;
        avcodec_send_packet(decoder.get(), more ? packet.get() : nullptr);
        av_packet_unref(packet.get());
        while (avcodec_receive_frame(decoder.get(), frame.get()) >= 0) {
            film.format = static_cast<AVPixelFormat>(frame->format);
            film.space = frame->colorspace;
            film.times.push_back(static_cast<double>(frame->pts) * av_q2d(stream.time_base));
            std::array<int, 3> middle{};
            for (size_t k = 0; k < 3; ++k) {
                const int shift = k == 0 ? 1 : 2;
                middle[k] = frame->data[k][(frame->height >> shift) * frame->linesize[k] +
                                           (frame->width >> shift)];
            }
            film.middles.push_back(middle);
        }
    }
    return film;
}

inline std::string bytesOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace terray
