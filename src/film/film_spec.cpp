// SPDX-License-Identifier: Apache-2.0
// Checks of a film's format before any frame is made.
#include "film/film_spec.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "film/av_handles.h"

namespace terray {

std::optional<FilmFormat> filmFormatOf(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".mp4") return FilmFormat::Mp4;
    if (extension == ".webm") return FilmFormat::WebM;
    return std::nullopt;
}

const char* encoderName(FilmFormat format) {
    return format == FilmFormat::Mp4 ? "libx264" : "libvpx-vp9";
}

AVRational frameRate(double fps) {
    constexpr int kFinest = 1'001'000;
    return av_d2q(fps, kFinest);
}

Result<void> checkFilm(const FilmSpec& spec) {
    constexpr int kMost = 16384;
    if (spec.width > kMost || spec.height > kMost || spec.width < 16 || spec.height < 16)
        return makeError(ErrorCode::Usage,
                         "--size {}x{}: a film has 16 to {} pixels a side; give another size, or "
                         "frames/%05d.png",
                         spec.width, spec.height, kMost);
    if (spec.width % 2 != 0 || spec.height % 2 != 0)
        return makeError(ErrorCode::Usage, "--size {}x{}: a film has even sides; give {}x{}",
                         spec.width, spec.height, (spec.width + 1) / 2 * 2,
                         (spec.height + 1) / 2 * 2);
    if (!(spec.fps >= 0.1 && spec.fps <= 480))
        return makeError(ErrorCode::Usage, "--fps: {} is out of range; give 0.1 to 480", spec.fps);
    if (!avcodec_find_encoder_by_name(encoderName(spec.format)))
        return makeError(ErrorCode::Resource,
                         "this machine's FFmpeg has no encoder {}; write {}, or frames/%05d.png",
                         encoderName(spec.format),
                         spec.format == FilmFormat::Mp4 ? "a .webm" : "an .mp4");
    return {};
}

}  // namespace terray
