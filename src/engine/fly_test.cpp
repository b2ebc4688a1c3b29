// SPDX-License-Identifier: Apache-2.0
// Flights over a synthetic terrain: frames are the stills of their moments, the same each time and
// with any number of threads; stopped runs go on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/interrupt.h"
#include "engine/fly_output.h"
#include "film/test_films.h"
#include "image/test_pictures.h"
#include "terray/flight.h"
#include "terray/process.h"
#include "terray/renderer.h"

namespace terray {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kFlownTerrain = "synthetic:fractal?size=300&cell=10&seed=3";
constexpr const char* kKeys =
    "0    300,300,+300   45,-15\n"
    "0.5  900,700,+250   look-at 1800,1600\n"
    "1    1400,1500,+300 look-at 2200,2000\n";

class FlyTest : public testing::Test {
protected:
    FlyTest()
        : folder_(fs::path(testing::TempDir()) /
                  (std::string("terray_fly_") +
                   testing::UnitTest::GetInstance()->current_test_info()->name())) {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
        std::ofstream(at("f.txt")) << kKeys;
        setQuiet(true);
        look_.samples = 2;
    }
    ~FlyTest() override {
        setInterrupted(false);
        fs::remove_all(folder_);
    }

    std::string at(const std::string& name) const { return (folder_ / name).string(); }
    FlyOptions small(const std::string& output) const {
        FlyOptions options;
        options.output = at(output);
        options.width = 96;
        options.height = 64;
        options.fps = 10;
        return options;
    }
    Result<FlyReport> flyOver(const FlyOptions& options, int threads = 0) const {
        OpenOptions open;
        open.threads = threads;
        const auto terrain = Terrain::open(kFlownTerrain, open);
        if (!terrain) return terrain.error();
        const auto flight = Flight::read(at("f.txt"));
        if (!flight) return flight.error();
        return fly(*terrain, *flight, look_, options);
    }

    fs::path folder_;
    RenderOptions look_;
};

TEST_F(FlyTest, FramesAreTheStillsOfTheirMoments) {
    FlyOptions options = small("%03d.png");
    const auto report = flyOver(options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->flightFrames, 11);
    ASSERT_EQ(report->frames.size(), 11u);
    EXPECT_DOUBLE_EQ(report->frames[10].time, 1);
    EXPECT_NEAR(report->frames[5].eyeX, 900, 1e-9);

    const auto terrain = Terrain::open(kFlownTerrain);
    const auto flight = Flight::read(at("f.txt"));
    RenderOptions look;
    look.samples = 2;
    auto view = viewAt(*terrain, *flight, look, 0.7);
    ASSERT_TRUE(view) << view.error().message;
    view->width = 96;
    view->height = 64;
    // What the flight settles is what its notes say; any other light would differ.
    look.sunAzElDeg = {{315, 40}};
    for (const double haze : {0.0, 1.0}) {
        FlyOptions again = small("again%03d.png");
        again.frames = {{7, 7}};
        look.hazeKm = 50 + haze;
        ASSERT_TRUE(fly(*terrain, *flight, look, again));
        ASSERT_TRUE(renderToFiles(*terrain, *view, look, {at("still.png"), {}, 92}));
        EXPECT_EQ(bytesOf(at("again007.png")), bytesOf(at("still.png")));
    }
}

TEST_F(FlyTest, HasTheSameBytesEachTimeAndWithAnyThreads) {
    ASSERT_TRUE(flyOver(small("a.mp4"), 1));
    ASSERT_TRUE(flyOver(small("b.mp4"), 2));
    EXPECT_EQ(bytesOf(at("a.mp4")), bytesOf(at("b.mp4")));
    ASSERT_TRUE(flyOver(small("a%d.png"), 2));
    ASSERT_TRUE(flyOver(small("b%d.png"), 1));
    for (int k = 0; k <= 10; ++k) {
        const std::string name = std::to_string(k) + ".png";
        EXPECT_EQ(bytesOf(at("a" + name)), bytesOf(at("b" + name)));
        EXPECT_FALSE(bytesOf(at("a" + name)).empty());
    }
    const PlayedFilm film = playFilm(at("a.mp4"));
    EXPECT_EQ(film.width, 96);
    EXPECT_EQ(film.times.size(), 11u);
    EXPECT_NEAR(film.seconds, 1.1, 0.01);
}

TEST_F(FlyTest, LightStaysWhileTheViewTurns) {
    // Half a turn above one place: the same ground, upside down. A still from the north would have
    // its sun in the north-east.
    std::ofstream(at("f.txt")) << "0 1500,1500,+900 0,-90\n1 1500,1500,+900 180,-90\n";
    FlyOptions options = small("%d.png");
    options.fps = 1;
    ASSERT_TRUE(flyOver(options));
    const auto north = readPixels<uint8_t>(at("0.png"));
    auto south = readPixels<uint8_t>(at("1.png"));
    ASSERT_EQ(north.size(), 96u * 64 * 3);
    std::reverse(south.begin(), south.end());  // channels too
    double off = 0;
    for (size_t k = 0; k < north.size(); k += 3) off += std::abs(north[k + 1] - south[k + 1]);
    EXPECT_LT(off / (96 * 64), 3);
}

TEST_F(FlyTest, InterruptedFilmsGoOnAndEndTheSame) {
    FlyOptions options = small("film.mp4");
    options.fps = 30;  // 31 frames: pieces of 60 would be one
    std::ofstream(at("f.txt")) << "0 300,300,+300 45,-15\n5 1400,1500,+300 50,-20\n";
    options.width = 64;
    options.height = 32;
    look_.samples = 1;
    look_.shadows = false;
    FlyOptions whole = options;
    whole.output = at("whole.mp4");
    ASSERT_TRUE(flyOver(whole));
    const std::string piece = Film::partsFolder(options.output) + "/000000.mp4";
    Result<FlyReport> result = FlyReport{};
    for (int attempt = 0; attempt < 10 && result; ++attempt) {  // it may be done before we look
        auto stopped = std::async(std::launch::async, [&] { return flyOver(options); });
        while (!fs::exists(piece) &&
               stopped.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready) {
        }
        setInterrupted(true);
        result = stopped.get();
        setInterrupted(false);
        if (result) fs::remove(options.output);
    }
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Interrupted);
    EXPECT_THAT(result.error().message, HasSubstr("--resume"));
    EXPECT_FALSE(fs::exists(options.output));
    options.resume = true;
    const auto resumed = flyOver(options);
    ASSERT_TRUE(resumed) << resumed.error().message;
    EXPECT_GE(resumed->found, 60);
    EXPECT_EQ(resumed->found + static_cast<int64_t>(resumed->frames.size()), 151);
    EXPECT_EQ(bytesOf(options.output), bytesOf(whole.output));
    EXPECT_FALSE(fs::exists(Film::partsFolder(options.output)));
}

TEST_F(FlyTest, ResumedPicturesAreSkippedWhereWhole) {
    FlyOptions options = small("frames/%02d.png");
    ASSERT_TRUE(flyOver(options));
    const std::string third = bytesOf(at("frames/03.png"));
    fs::remove(at("frames/07.png"));
    fs::resize_file(at("frames/03.png"), third.size() / 2);
    options.resume = true;
    const auto report = flyOver(options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->found, 9);
    ASSERT_EQ(report->frames.size(), 2u);
    EXPECT_EQ(report->frames[0].frame, 3);
    EXPECT_EQ(report->frames[1].frame, 7);
    EXPECT_EQ(bytesOf(at("frames/03.png")), third);
}

TEST_F(FlyTest, WritesLinearPictures) {
    FlyOptions options = small("%d.exr");
    options.frames = {{2, 3}};
    const auto report = flyOver(options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(fs::exists(at("2.exr")));
    EXPECT_TRUE(fs::exists(at("3.exr")));
    EXPECT_FALSE(fs::exists(at("4.exr")));
}

TEST_F(FlyTest, RealTimeKeepsThePace) {
    FlyOptions options = small("film.mp4");
    options.realtime = true;
    options.fps = 400;  // more than any machine renders
    const auto report = flyOver(options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->flightFrames, 401);
    EXPECT_EQ(report->dropped + static_cast<int64_t>(report->frames.size()), 401);
    const PlayedFilm film = playFilm(options.output);
    EXPECT_NEAR(film.seconds, 401 / 400.0, 0.003);
    EXPECT_LE(film.times.size(), 401u);
    EXPECT_NEAR(film.times.back(), 1, 0.01);
    for (size_t k = 1; k < report->frames.size(); ++k)
        EXPECT_GT(report->frames[k].frame, report->frames[k - 1].frame);
}

TEST_F(FlyTest, StatsHaveARowForEachFrame) {
    const auto report = flyOver(small("%d.png"));
    ASSERT_TRUE(report);
    const auto json = nlohmann::json::parse(toJson(*report));
    ASSERT_EQ(json["frames"].size(), 11u);
    EXPECT_EQ(json["frames"][4]["frame"], 4);
    EXPECT_EQ(json["flight_frames"], 11);
    EXPECT_EQ(json["frames"][4]["rays"], 96 * 64 * 2);
    EXPECT_GT(json["frames"][4]["hits"], 0);
    const std::string csv = toCsv(*report);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 12);
    const auto lineOf = [&](size_t from) { return csv.substr(from, csv.find('\n', from) - from); };
    const std::string header = lineOf(0), row = lineOf(csv.find('\n') + 1);
    EXPECT_EQ(std::count(header.begin(), header.end(), ','),
              std::count(row.begin(), row.end(), ','));
    EXPECT_THAT(header, HasSubstr("frame,time,eye_x,eye_y,eye_z,frame_ms,setup_ms"));
    EXPECT_THAT(header, HasSubstr("tiles_mip0"));
}

TEST_F(FlyTest, RefusesBadOptionsEarly) {
    const auto refuses = [&](auto change, const std::string& words) {
        FlyOptions options = small("film.mp4");
        RenderOptions look;
        change(options, look);
        const auto checked = checkFly(look, options);
        ASSERT_FALSE(checked) << words;
        EXPECT_THAT(checked.error().message, HasSubstr(words));
    };
    refuses([](auto& o, auto&) { o.width = 95; }, "96x64");
    refuses([](auto& o, auto&) { o.output = ""; }, "-o");
    refuses([](auto& o, auto&) { o.output = "film.avi"; }, "neither a film");
    refuses([](auto& o, auto&) { o.output = "film.png"; }, "neither a film");
    refuses([&](auto& o, auto&) { o.output = at("%d%d.png"); }, "more than one");
    refuses([&](auto& o, auto&) { o.output = at("%s.png"); }, "no number");
    refuses([&](auto& o, auto&) { o.output = at("%5d.png"); }, "no number");
    refuses([&](auto& o, auto&) { o.output = at("a%d/b.png"); }, "folder's name");
    refuses([&](auto& o, auto&) { o.output = at("%d.gif"); }, "extension");
    refuses([&](auto& o, auto&) { o.output = at("no/such/%d.png"); }, "create the folder");
    refuses([&](auto& o, auto&) { o.output = at("no/film.mp4"); }, "create the folder");
    refuses([](auto& o, auto&) { o.fps = 0; }, "--fps");
    refuses([](auto& o, auto&) { o.fps = NAN; }, "--fps");
    refuses([](auto& o, auto&) { o.frames = {{5, 4}}; }, "--frames");
    refuses([](auto& o, auto&) { o.realtime = o.resume = true; }, "--realtime");
    refuses([](auto&, auto& look) { look.background = "transparent"; }, "transparent");
    refuses([](auto&, auto& look) { look.samples = 3; }, "--samples");
    EXPECT_EQ(fs::exists(at("film.mp4")), false);
    FlyOptions late = small("film.mp4");
    late.frames = {{5, 11}};
    EXPECT_THAT(flyOver(late).error().message, HasSubstr("0 to 10"));
}

TEST_F(FlyTest, BadFlightsNameTheirLine) {
    const auto refused = [&](const std::string& text) {
        std::ofstream(at("f.txt")) << text;
        const auto report = flyOver(small("film.mp4"));
        EXPECT_FALSE(report) << text;
        if (report) return std::string();
        EXPECT_EQ(report.error().code, ErrorCode::Input) << report.error().message;
        return report.error().message;
    };
    EXPECT_THAT(refused("0 1,2,+3 0,0\n1 900,900,-5000x 0,0\n"), HasSubstr("f.txt:2"));
    EXPECT_THAT(refused("0 900,900,+3 0,0\n1 99999,2,+3 0,0\n"), HasSubstr("f.txt:2"));
    EXPECT_THAT(refused("0 900,900,300 look-at 900,900,300\n1 9,9,300 0,0\n"),
                HasSubstr("f.txt:1"));
    EXPECT_FALSE(fs::exists(at("film.mp4.parts")));
}

}  // namespace
}  // namespace terray
