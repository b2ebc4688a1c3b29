// SPDX-License-Identifier: Apache-2.0
// Pieces and their folder.
#include "film/film.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "image/partial_file.h"

namespace terray {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFingerprint = "film.txt";

/// What a film's run puts into its folder; anything else there is someone else's.
bool isOwn(const std::string& name) {
    const bool piece = name.size() > 6 && name.find_first_not_of("0123456789") == 6 &&
                       (name.ends_with(".mp4") || name.ends_with(".webm"));
    return piece || name == kFingerprint || name.find(".partial-") != std::string::npos;
}

/// Removes own files, or only those that a killed run left unfinished.
void sweep(const std::string& folder, bool unfinishedOnly) {
    std::error_code ignored;
    std::vector<fs::path> own;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const std::string name = entry.path().filename().string();
        if (!isOwn(name) || !entry.is_regular_file(ignored)) continue;
        if (!unfinishedOnly || name.find(".partial-") != std::string::npos)
            own.push_back(entry.path());
    }
    for (const fs::path& path : own) fs::remove(path, ignored);
}

Error cannotWrite(const std::string& path, const std::string& why) {
    return makeError(ErrorCode::Failed, "'{}' cannot be written: {}; choose another place", path,
                     why);
}

}  // namespace

std::string Film::partsFolder(const std::string& path) { return path + ".parts"; }

Film::Film(const FilmPlan& plan) : plan_(plan), folder_(partsFolder(plan.path)) {
    const size_t pieces = pieceOf(std::max<int64_t>(plan.frames, 1) - 1) + 1;
    found_.assign(pieces, false);
    made_.assign(pieces, false);
}

Film::~Film() {
    encoder_.reset();  // a piece that is not whole goes
    const bool nothing = std::find(made_.begin(), made_.end(), true) == made_.end();
    if (mine_ && nothing) removeFolder();
    if (lock_ >= 0) close(lock_);
}

std::string Film::piecePath(size_t piece) const {
    return fmt::format("{}/{:06}{}", folder_, piece,
                       plan_.spec.format == FilmFormat::Mp4 ? ".mp4" : ".webm");
}

Result<std::unique_ptr<Film>> Film::begin(const FilmPlan& plan) {
    TERRAY_TRY(checkFilm(plan.spec));
    std::error_code ignored;
    if (fs::is_directory(plan.path, ignored)) return cannotWrite(plan.path, "it is a folder");
    std::unique_ptr<Film> film(new Film(plan));
    TERRAY_TRY(film->takeFolder());
    TERRAY_TRY(film->checkFingerprint());
    for (size_t piece = 0; piece < film->found_.size(); ++piece)
        film->found_[piece] = fs::is_regular_file(film->piecePath(piece), ignored);
    film->made_ = film->found_;
    film->mine_ = true;
    return film;
}

Result<void> Film::takeFolder() {
    std::error_code problem;
    fs::create_directory(folder_, problem);
    if (problem) return cannotWrite(folder_, problem.message());
    lock_ = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0) return cannotWrite(folder_, std::strerror(errno));
    if (flock(lock_, LOCK_EX | LOCK_NB) == 0) return {};
    return makeError(ErrorCode::Failed,
                     "'{}' is being made by another process; wait for it or choose another name",
                     plan_.path);
}

Result<void> Film::checkFingerprint() {
    const std::string path = folder_ + "/" + kFingerprint;
    std::ifstream file(path, std::ios::binary);
    const std::string found{std::istreambuf_iterator<char>(file), {}};
    if (file.is_open() && plan_.resume && found == plan_.fingerprint) {
        sweep(folder_, true);
        return {};
    }
    if (file.is_open() && plan_.resume)
        return makeError(
            ErrorCode::Usage,
            "--resume: the pieces in '{}' are of another film (other source, flight or "
            "options); leave --resume out to begin anew",
            folder_);
    file.close();
    sweep(folder_, false);
    auto out = PartialFile::create(path);
    if (!out) return out.error();
    if (!(*out)->write(plan_.fingerprint.data(), plan_.fingerprint.size()))
        return (*out)->writeError();
    return (*out)->publish();
}

Result<void> Film::closePiece() {
    if (!encoder_) return {};
    const std::unique_ptr<FilmEncoder> done = std::move(encoder_);
    TERRAY_TRY(done->finish());
    made_[piece_] = true;
    return {};
}

Result<void> Film::add(std::span<const uint8_t> rgba, int64_t index) {
    const size_t piece = pieceOf(index);
    if (encoder_ && piece != piece_) TERRAY_TRY(closePiece());
    if (!encoder_) {
        auto encoder = FilmEncoder::create(piecePath(piece), plan_.spec);
        if (!encoder) return encoder.error();
        encoder_ = std::move(*encoder);
        piece_ = piece;
    }
    return encoder_->add(rgba, index - static_cast<int64_t>(piece) * plan_.spec.pieceFrames);
}

Result<void> Film::finish() {
    TERRAY_TRY(closePiece());
    std::vector<FilmPiece> pieces;
    for (size_t piece = 0; piece < made_.size(); ++piece) {
        if (!made_[piece]) continue;
        pieces.push_back({piecePath(piece), static_cast<int64_t>(piece) * plan_.spec.pieceFrames});
    }
    TERRAY_TRY(joinFilm(pieces, plan_.path, plan_.spec));
    removeFolder();
    return {};
}

void Film::removeFolder() {
    sweep(folder_, false);
    std::error_code ignored;
    fs::remove(folder_, ignored);  // stays if it holds anything else
    mine_ = false;
}

}  // namespace terray
