// SPDX-License-Identifier: Apache-2.0
// Films and numbered pictures.
#include "engine/fly_output.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "engine/outputs.h"
#include "image/partial_file.h"

namespace terray {
namespace {

namespace fs = std::filesystem;

constexpr double kPieceSeconds = 2;
constexpr int64_t kMostPixels = int64_t{8192} * 8192;

FilmSpec filmSpec(const FlyOptions& fly, FilmFormat format) {
    FilmSpec spec;
    spec.format = format;
    spec.width = fly.width;
    spec.height = fly.height;
    spec.fps = fly.fps;
    spec.pieceFrames = std::max(1, static_cast<int>(std::lround(kPieceSeconds * fly.fps)));
    return spec;
}

class FilmOutputOfFlight final : public FlyOutput {
public:
    FilmOutputOfFlight(std::unique_ptr<Film> film, int64_t first)
        : film_(std::move(film)), first_(first) {}
    bool hasFrame(int64_t frame) const override { return film_->hasFrame(frame - first_); }
    Result<void> write(int64_t frame, const Band& picture) override {
        return film_->add(picture.display, frame - first_);
    }
    Result<void> finish() override { return film_->finish(); }

private:
    std::unique_ptr<Film> film_;
    int64_t first_;
};

/// The file ends as its format says. Pictures get their names when they are whole; this finds those
/// that were cut afterwards.
bool isWholePicture(const std::string& path) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored) || fs::file_size(path, ignored) < 16) return false;
    std::ifstream file(path, std::ios::binary);
    char head[8] = {}, tail[8] = {};
    file.read(head, sizeof head);
    file.seekg(-static_cast<std::streamoff>(sizeof tail), std::ios::end);
    file.read(tail, sizeof tail);
    if (!file) return false;
    const std::string start(head, sizeof head), end(tail, sizeof tail);
    if (start.starts_with("\x89PNG")) return end.starts_with("IEND");
    if (start.starts_with("\xFF\xD8")) return end.ends_with("\xFF\xD9");
    return true;
}

class PictureOutput final : public FlyOutput {
public:
    PictureOutput(const FlyPlan& plan, FramePattern pattern)
        : plan_(plan), pattern_(std::move(pattern)), linear_(isLinearFormat(pattern_.pathOf(0))) {}

    bool hasFrame(int64_t frame) const override {
        return plan_.fly.resume && isWholePicture(pattern_.pathOf(frame));
    }
    std::optional<std::string> directPath(int64_t frame) const override {
        if (!linear_) return std::nullopt;
        return pattern_.pathOf(frame);
    }
    Result<void> write(int64_t frame, const Band& picture) override {
        OutputOptions outputs;
        outputs.path = pattern_.pathOf(frame);
        outputs.jpegQuality = plan_.fly.jpegQuality;
        std::error_code ignored;
        if (fs::equivalent(outputs.path, plan_.source, ignored))
            return makeError(ErrorCode::Usage,
                             "'{}' is the source; write the frames somewhere else", outputs.path);
        auto files = OutputFiles::make(plan_.fly.width, plan_.fly.height, plan_.hasAlpha, outputs,
                                       std::nullopt);
        if (!files) return files.error();
        TERRAY_TRY(files->writeBand(picture));
        return files->finish();
    }
    Result<void> finish() override { return {}; }

private:
    FlyPlan plan_;
    FramePattern pattern_;
    bool linear_;
};

Result<void> checkFilmOutput(const FlyOptions& fly, FilmFormat format, bool hasAlpha) {
    if (hasAlpha)
        return makeError(ErrorCode::Usage,
                         "--background transparent: a film has none; give a colour, or write "
                         "frames/%05d.png");
    TERRAY_TRY(checkFilm(filmSpec(fly, format)));
    auto file = PartialFile::create(fly.output);
    if (!file) return file.error();
    return {};
}

/// The folder of numbered pictures is made if only itself is missing.
Result<void> checkPictureOutput(const FlyOptions& fly, bool hasAlpha) {
    auto pattern = FramePattern::parse(fly.output);
    if (!pattern) return pattern.error();
    OutputOptions outputs;
    outputs.path = pattern->pathOf(0);
    outputs.jpegQuality = fly.jpegQuality;
    const fs::path folder = fs::path(outputs.path).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !fs::exists(folder, ignored)) {
        const fs::path above = folder.parent_path();
        if (above.empty() || fs::is_directory(above, ignored))
            outputs.path = (above / fs::path(outputs.path).filename()).string();
    }
    auto files = OutputFiles::make(fly.width, fly.height, hasAlpha, outputs, std::nullopt);
    if (!files) return files.error();
    return {};
}

}  // namespace

Result<FramePattern> FramePattern::parse(const std::string& text) {
    const auto bad = [&](const char* why) {
        return makeError(ErrorCode::Usage,
                         "-o: '{}' {}; give film.mp4, film.webm or a pattern like frames/%05d.png",
                         text, why);
    };
    const size_t sign = text.find('%');
    if (sign == std::string::npos) return bad("is neither a film nor a pattern for pictures");
    if (text.find('%', sign + 1) != std::string::npos) return bad("has more than one %");
    FramePattern pattern;
    const char* at = text.data() + sign + 1;
    const char* end = text.data() + text.size();
    if (at != end && *at != 'd') {
        const auto [stop, problem] = std::from_chars(at, end, pattern.digits);
        if (problem != std::errc{} || *at != '0' || pattern.digits > 18)
            return bad("has no number like %05d");
        at = stop;
    }
    if (at == end || *at != 'd') return bad("has no number like %05d");
    pattern.before = text.substr(0, sign);
    pattern.after = std::string(at + 1, end);
    if (pattern.before.find('/') == std::string::npos &&
        pattern.after.find('/') != std::string::npos)
        return bad("has its number in a folder's name");
    if (pattern.after.find('/') != std::string::npos)
        return bad("has its number in a folder's name");
    return pattern;
}

std::string FramePattern::pathOf(int64_t frame) const {
    return fmt::format("{}{:0{}}{}", before, frame, digits, after);
}

Result<void> checkFlyOutput(const FlyOptions& fly, bool hasAlpha) {
    if (fly.output.empty())
        return makeError(ErrorCode::Usage,
                         "-o: name what to make: film.mp4, film.webm or frames/%05d.png");
    if (!(fly.fps >= 0.1 && fly.fps <= 480))
        return makeError(ErrorCode::Usage, "--fps: {} is out of range; give 0.1 to 480", fly.fps);
    if (fly.width < 1 || fly.height < 1 || int64_t{fly.width} * fly.height > kMostPixels)
        return makeError(ErrorCode::Usage,
                         "--size {}x{} is out of range; give 1x1 to 8192x8192 pixels in all",
                         fly.width, fly.height);
    if (fly.frames && ((*fly.frames)[0] < 0 || (*fly.frames)[1] < (*fly.frames)[0]))
        return makeError(ErrorCode::Usage,
                         "--frames {}-{}: give the first and the last frame, counted from 0",
                         (*fly.frames)[0], (*fly.frames)[1]);
    if (fly.realtime && fly.resume)
        return makeError(ErrorCode::Usage,
                         "--resume does not go with --realtime, where each run drops other frames; "
                         "leave one out");
    if (const auto format = filmFormatOf(fly.output))
        return checkFilmOutput(fly, *format, hasAlpha);
    return checkPictureOutput(fly, hasAlpha);
}

Result<std::unique_ptr<FlyOutput>> FlyOutput::begin(const FlyPlan& plan) {
    if (const auto format = filmFormatOf(plan.fly.output)) {
        FilmPlan film{plan.fly.output, filmSpec(plan.fly, *format), plan.last - plan.first + 1,
                      plan.fingerprint, plan.fly.resume};
        // Frames that stand for long leave gaps, which only one encoder can bridge.
        film.spec.gaps = plan.fly.realtime;
        if (plan.fly.realtime) film.spec.pieceFrames = static_cast<int>(film.frames);
        auto begun = Film::begin(film);
        if (!begun) return begun.error();
        return std::unique_ptr<FlyOutput>(
            std::make_unique<FilmOutputOfFlight>(std::move(*begun), plan.first));
    }
    auto pattern = FramePattern::parse(plan.fly.output);
    if (!pattern) return pattern.error();
    const fs::path folder = fs::path(pattern->pathOf(0)).parent_path();
    std::error_code problem;
    if (!folder.empty() && !fs::exists(folder, problem)) fs::create_directory(folder, problem);
    if (problem)
        return makeError(ErrorCode::Failed, "'{}' cannot be made: {}; choose another place",
                         folder.string(), problem.message());
    return std::unique_ptr<FlyOutput>(std::make_unique<PictureOutput>(plan, std::move(*pattern)));
}

}  // namespace terray
