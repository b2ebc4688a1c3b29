// SPDX-License-Identifier: Apache-2.0
// Joins the pieces of a film without encoding them again.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "film/film_spec.h"

namespace terray {

struct FilmPiece {
    std::string path;
    int64_t firstFrame = 0;  ///< of the film
};

/// Pieces in order, all made with the same FilmSpec. Errors: Failed.
Result<void> joinFilm(const std::vector<FilmPiece>& pieces, const std::string& path,
                      const FilmSpec& spec);

}  // namespace terray
