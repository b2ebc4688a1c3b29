// SPDX-License-Identifier: Apache-2.0
// Films: they play, with the right frames at the right times; the same bytes each time, stopped and
// resumed or not; whole or not there.
#include "film/film.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "film/test_films.h"

namespace terray {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// The format's extension.
class FilmTest : public testing::TestWithParam<const char*> {
protected:
    FilmTest() {
        std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
        for (char& c : name) c = c == '/' ? '_' : c;
        folder_ = fs::path(testing::TempDir()) / ("terray_film_" + name);
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    ~FilmTest() override { fs::remove_all(folder_); }

    FilmPlan plan(const std::string& name, int frames) const {
        FilmPlan p;
        p.path = (folder_ / (name + GetParam())).string();
        p.spec = {*filmFormatOf(p.path), 96, 64, 12.5, 10};
        p.frames = frames;
        p.fingerprint = "a film";
        return p;
    }

    /// A grey that changes from frame to frame under a moving bar.
    static std::vector<uint8_t> picture(const FilmSpec& spec, int64_t index) {
        std::vector<uint8_t> rgba;
        for (int y = 0; y < spec.height; ++y)
            for (int x = 0; x < spec.width; ++x) {
                const bool bar = x / 8 == index % 4;
                const auto grey = static_cast<uint8_t>(60 + 5 * (index % 25));
                const uint8_t pixel[] = {bar ? uint8_t{220} : grey, grey, grey, 255};
                rgba.insert(rgba.end(), pixel, pixel + 4);
            }
        return rgba;
    }

    /// Makes frames [from, to) as far as they are missing.
    static Result<void> add(Film& film, const FilmPlan& p, int64_t from, int64_t to) {
        for (int64_t k = from; k < to; ++k) {
            if (film.hasFrame(k)) continue;
            TERRAY_TRY(film.add(picture(p.spec, k), k));
        }
        return {};
    }

    void make(const FilmPlan& p) const {
        auto film = Film::begin(p);
        ASSERT_TRUE(film) << film.error().message;
        ASSERT_TRUE(add(**film, p, 0, p.frames));
        const auto done = (*film)->finish();
        ASSERT_TRUE(done) << done.error().message;
    }

    std::vector<std::string> left() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_))
            names.push_back(entry.path().filename().string());
        return names;
    }

    fs::path folder_;
};

TEST_P(FilmTest, PlaysWithAllItsFramesInTime) {
    const FilmPlan p = plan("film", 27);
    make(p);
    const PlayedFilm film = playFilm(p.path);
    EXPECT_EQ(film.width, 96);
    EXPECT_EQ(film.height, 64);
    EXPECT_EQ(film.codec, p.spec.format == FilmFormat::Mp4 ? "h264" : "vp9");
    EXPECT_EQ(film.format, AV_PIX_FMT_YUV420P);
    EXPECT_EQ(film.space, AVCOL_SPC_BT709);
    EXPECT_NEAR(film.seconds, 27 / 12.5, 0.002);
    ASSERT_EQ(film.times.size(), 27u);
    for (int k = 0; k < 27; ++k) {
        const auto at = static_cast<size_t>(k);
        EXPECT_NEAR(film.times[at], k / 12.5, 0.001);
        // Grey in limited range; the encoder may be a little off.
        EXPECT_NEAR(film.middles[at][0], 16 + (60 + 5 * (k % 25)) * 219 / 255.0, 4) << k;
        EXPECT_NEAR(film.middles[at][1], 128, 4) << k;
    }
    EXPECT_EQ(left().size(), 1u);
}

TEST_P(FilmTest, LastsAsLongAsItsFrames) {
    for (const int frames : {1, 2, 10, 11, 12, 21, 33}) {
        const FilmPlan p = plan("film" + std::to_string(frames), frames);
        make(p);
        const PlayedFilm film = playFilm(p.path);
        EXPECT_EQ(film.times.size(), static_cast<size_t>(frames));
        EXPECT_NEAR(film.seconds, frames / 12.5, 0.002) << frames;
        for (size_t k = 0; k < film.times.size(); ++k)
            EXPECT_NEAR(film.times[k], static_cast<double>(k) / 12.5, 0.001) << frames;
    }
}

TEST_P(FilmTest, HasTheSameBytesStoppedAndResumedOrNot) {
    FilmPlan whole = plan("whole", 34), stopped = plan("stopped", 34);
    make(whole);
    make(plan("again", 34));
    EXPECT_EQ(bytesOf(whole.path), bytesOf(plan("again", 34).path));
    {
        auto film = Film::begin(stopped);
        ASSERT_TRUE(film);
        ASSERT_TRUE(add(**film, stopped, 0, 25));
    }
    EXPECT_FALSE(fs::exists(stopped.path));
    stopped.resume = true;
    auto film = Film::begin(stopped);
    ASSERT_TRUE(film) << film.error().message;
    EXPECT_TRUE((*film)->hasFrame(19));
    EXPECT_FALSE((*film)->hasFrame(20));  // its piece was not whole
    ASSERT_TRUE(add(**film, stopped, 0, 34));
    ASSERT_TRUE((*film)->finish());
    EXPECT_EQ(bytesOf(whole.path), bytesOf(stopped.path));
    EXPECT_EQ(left().size(), 3u);
}

TEST_P(FilmTest, DoesNotResumeAnotherFilm) {
    FilmPlan p = plan("film", 25);
    {
        auto film = Film::begin(p);
        ASSERT_TRUE(film);
        ASSERT_TRUE(add(**film, p, 0, 15));
        EXPECT_THAT(Film::begin(p).error().message, HasSubstr("another process"));
    }
    p.resume = true;
    p.fingerprint = "another film";
    const auto other = Film::begin(p);
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().code, ErrorCode::Usage);
    EXPECT_THAT(other.error().message, HasSubstr("--resume"));
    p.resume = false;
    const auto anew = Film::begin(p);
    ASSERT_TRUE(anew);
    EXPECT_FALSE((*anew)->hasFrame(0));
}

TEST_P(FilmTest, LeavesNothingBeforeAPieceIsWhole) {
    const FilmPlan p = plan("film", 25);
    {
        auto film = Film::begin(p);
        ASSERT_TRUE(film);
        ASSERT_TRUE(add(**film, p, 0, 9));
    }
    EXPECT_TRUE(left().empty());
}

TEST_P(FilmTest, LeavesForeignFilesInItsFolderAlone) {
    const FilmPlan p = plan("film", 3);
    fs::create_directory(Film::partsFolder(p.path));
    const fs::path foreign = fs::path(Film::partsFolder(p.path)) / "notes.mp4";
    std::ofstream(foreign) << "mine";
    make(p);
    EXPECT_EQ(bytesOf(foreign.string()), "mine");
    EXPECT_EQ(playFilm(p.path).times.size(), 3u);
}

TEST_P(FilmTest, FramesMayStandForLong) {
    FilmPlan p = plan("film", 40);
    p.spec.pieceFrames = 40;
    p.spec.gaps = true;
    auto film = Film::begin(p);
    ASSERT_TRUE(film);
    for (const int64_t k : {0, 1, 7, 8, 20, 39}) ASSERT_TRUE((*film)->add(picture(p.spec, k), k));
    ASSERT_TRUE((*film)->finish());
    const PlayedFilm played = playFilm(p.path);
    ASSERT_EQ(played.times.size(), 6u);
    EXPECT_NEAR(played.times[2], 7 / 12.5, 0.001);
    EXPECT_NEAR(played.times[5], 39 / 12.5, 0.001);
    EXPECT_NEAR(played.seconds, 40 / 12.5, 0.002);
}

TEST_P(FilmTest, AFullDiskIsASentence) {
    const FilmPlan p = plan("film", 20);
    auto film = Film::begin(p);
    ASSERT_TRUE(film);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit tiny{512, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tiny);
    Result<void> done = add(**film, p, 0, p.frames);
    if (done) done = (*film)->finish();
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::Failed);
    EXPECT_THAT(done.error().message, HasSubstr("writing"));
    EXPECT_FALSE(fs::exists(p.path));
}

TEST_P(FilmTest, RefusesWhatCannotBeAFilm) {
    FilmPlan p = plan("film", 3);
    p.spec.width = 97;
    EXPECT_THAT(Film::begin(p).error().message, HasSubstr("98x64"));
    p = plan("film", 3);
    p.spec.fps = 0;
    EXPECT_THAT(Film::begin(p).error().message, HasSubstr("--fps"));
    p = plan("missing/film", 3);
    EXPECT_EQ(Film::begin(p).error().code, ErrorCode::Failed);
    EXPECT_FALSE(filmFormatOf("a.avi"));
    EXPECT_TRUE(left().empty());
}

INSTANTIATE_TEST_SUITE_P(All, FilmTest, testing::Values(".mp4", ".webm"),
                         [](const auto& film) { return std::string(film.param + 1); });

}  // namespace
}  // namespace terray
