// SPDX-License-Identifier: Apache-2.0
// A film in the making: pieces in a folder beside it, joined at the end; stopped runs go on.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "film/film_encoder.h"
#include "film/film_join.h"

namespace terray {

struct FilmPlan {
    std::string path;
    FilmSpec spec;
    int64_t frames = 0;       ///< of the film
    std::string fingerprint;  ///< of everything that the frames depend on
    bool resume = false;      ///< keep the pieces of an earlier run
};

/// confined, but for hasFrame().
class Film {
public:
    /// Makes or takes over the folder of pieces. Errors: Failed (cannot be written there, another
    /// process is at it), Usage (the pieces there are of another film).
    static Result<std::unique_ptr<Film>> begin(const FilmPlan& plan);
    /// Leaves the folder where a piece is whole, for a later run.
    ~Film();
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;

    /// An earlier run has made it.
    bool hasFrame(int64_t index) const { return found_[pieceOf(index)]; }
    /// Frames in order; those that are there may be left out.
    Result<void> add(std::span<const uint8_t> rgba, int64_t index);
    /// Joins the pieces, names the film, removes the folder.
    Result<void> finish();

    /// NAME.parts
    static std::string partsFolder(const std::string& path);

private:
    explicit Film(const FilmPlan& plan);
    size_t pieceOf(int64_t index) const {
        return static_cast<size_t>(index / plan_.spec.pieceFrames);
    }
    std::string piecePath(size_t piece) const;
    Result<void> takeFolder();
    Result<void> checkFingerprint();
    Result<void> closePiece();
    void removeFolder();

    FilmPlan plan_;
    std::string folder_;
    int lock_ = -1;
    bool mine_ = false;  ///< the folder holds pieces of this film only
    std::vector<bool> found_, made_;
    std::unique_ptr<FilmEncoder> encoder_;
    size_t piece_ = 0;  ///< that encoder_ makes
};

}  // namespace terray
