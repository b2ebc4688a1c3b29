// SPDX-License-Identifier: Apache-2.0
// One piece of a film: frames in, a file that plays by itself out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "film/film_spec.h"

namespace terray {

/// The file has its name only after finish(). confined.
class FilmEncoder {
public:
    /// Errors: Failed (cannot be written there), Resource (the encoder does not start).
    static Result<std::unique_ptr<FilmEncoder>> create(const std::string& path,
                                                       const FilmSpec& spec);
    virtual ~FilmEncoder() = default;

    /// 8-bit sRGB, 4 bytes a pixel, opaque. `index` counts frames from the piece's begin and
    /// increases; a frame stands until the next one.
    virtual Result<void> add(std::span<const uint8_t> rgba, int64_t index) = 0;
    virtual Result<void> finish() = 0;
};

}  // namespace terray
