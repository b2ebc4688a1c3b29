// SPDX-License-Identifier: Apache-2.0
// What a film is: format, size, pace.
#pragma once

#include <optional>
#include <string>

#include "base/result.h"

namespace terray {

enum class FilmFormat { Mp4, WebM };  ///< H.264 by libx264; VP9 by libvpx

struct FilmSpec {
    FilmFormat format = FilmFormat::Mp4;
    int width = 0, height = 0;  ///< even
    double fps = 30;
    int pieceFrames = 60;  ///< frames of a piece
    bool gaps = false;     ///< frames may be left out; the one before stands for them
};

/// By extension: .mp4 or .webm; nothing for other names.
std::optional<FilmFormat> filmFormatOf(const std::string& path);

/// Errors: Usage (odd or too large sizes, fps out of range), Resource (FFmpeg lacks the encoder).
Result<void> checkFilm(const FilmSpec& spec);

}  // namespace terray
