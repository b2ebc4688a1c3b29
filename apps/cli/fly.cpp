// SPDX-License-Identifier: Apache-2.0
// `terray fly`: a film, or numbered pictures, of a flight.
#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <memory>

#include "commands.h"
#include "info_text.h"
#include "options.h"
#include "output.h"
#include "parse.h"
#include "terray/flight.h"
#include "terray/process.h"
#include "usage.h"

namespace terray::cli {
namespace {

struct FlyFlags {
    SourceOptions source;
    LookOptions look;
    std::string flightPath;
    FlightOptions flight;
    FlyOptions fly;
    std::string statsPath;
};

constexpr const char* kFlyFooter =
    "Examples:\n"
    "  terray fly dem.tif --flight over.txt -o film.mp4\n"
    "  terray fly dem.terray --flight over.txt -o film.webm --size 1280x720 --samples 2\n"
    "  terray fly dem.tif --flight over.txt --frames 0-49 -o 'frames/%05d.png'\n"
    "  terray fly dem.tif --flight hike.gpx --speed 60 --height-above-ground 150 -o hike.mp4\n"
    "  terray fly dem.tif --flight over.txt -o film.mp4 --resume\n"
    "A flight file has a key frame a line (docs/flights.md):\n"
    "  # seconds  eye X,Y,Z (+H: above the ground)  where to\n"
    "  0   500100,4200300,+400   90,-15\n"
    "  8   503000,4201000,+300   look-at 506000,4204000";

/// A-B, or one number.
std::array<int64_t, 2> parseFrames(const std::string& text) {
    std::array<int64_t, 2> range{};
    const auto parts = split(text, '-');
    bool good = parts.size() == 1 || parts.size() == 2;
    for (size_t k = 0; good && k < parts.size(); ++k) {
        const std::string& part = parts[k];
        const auto [stop, problem] =
            std::from_chars(part.data(), part.data() + part.size(), range[k]);
        good = problem == std::errc{} && stop == part.data() + part.size();
    }
    if (parts.size() == 1) range[1] = range[0];
    if (!good || range[0] > range[1])
        failUsage(fmt::format("--frames: '{}' is no range; give FIRST-LAST, like 0-99", text));
    return range;
}

/// 30, 29.97 or 30000/1001.
double parseFps(const std::string& text) {
    const auto parts = split(text, '/');
    if (parts.size() != 2) return parseNumber("--fps", text);
    return parseNumber("--fps", parts[0]) / parseNumber("--fps", parts[1]);
}

void addFlight(CLI::App& command, FlyFlags& flags) {
    constexpr const char* kFlight = "Flight";
    FlightOptions& flight = flags.flight;
    addText(command, kFlight, "--flight", "FILE",
            "key frames (docs/flights.md), or a track: GPX or KML",
            [&flags](const std::string& text) { flags.flightPath = text; })
        ->required();
    addSwitch(command, kFlight, "--lonlat", "X,Y of key frames are degrees", flight.lonLat);
    addText(command, kFlight, "--speed", "M/S",
            "fly at this constant speed (default: the times in the file)",
            [&flight](const std::string& text) { flight.speed = parseNumber("--speed", text); });
    addText(command, kFlight, "--height-above-ground", "H", "of a track, metres (default 200)",
            [&flight](const std::string& text) {
                flight.heightAboveGround = parseNumber("--height-above-ground", text);
            });
    addText(command, kFlight, "--pitch", "DEG", "of a track: down is negative (default -10)",
            [&flight](const std::string& text) { flight.pitchDeg = parseNumber("--pitch", text); });
    addText(command, kFlight, "--fov", "DEG",
            "vertical field of view, 0.01 to 179 (default 45, or as the file says)",
            [&flight](const std::string& text) { flight.fovDeg = parseNumber("--fov", text); });
}

void addFilm(CLI::App& command, FlyFlags& flags) {
    constexpr const char* kFilm = "Film";
    FlyOptions& fly = flags.fly;
    addText(command, kFilm, "-o,--output", "FILE",
            "film.mp4 (H.264), film.webm (VP9), or a pattern for pictures: frames/%05d.png (.jpg, "
            ".exr, .tif)",
            [&fly](const std::string& text) { fly.output = text; })
        ->required();
    addText(command, kFilm, "--size", "WxH", "pixels (default 1920x1080)",
            [&fly](const std::string& text) {
                std::tie(fly.width, fly.height) = parseSize("--size", text);
            });
    addText(command, kFilm, "--fps", "N", "frames a second (default 30), or a fraction: 30000/1001",
            [&fly](const std::string& text) { fly.fps = parseFps(text); });
    addText(command, kFilm, "--frames", "A-B", "only these frames, counted from 0",
            [&fly](const std::string& text) { fly.frames = parseFrames(text); });
    addSwitch(command, kFilm, "--resume", "go on where an earlier run of this command stopped",
              fly.resume);
    addSwitch(command, kFilm, "--realtime",
              "drop the frames that a viewer on this machine would not have in time", fly.realtime);
    addText(
        command, kFilm, "--jpeg-quality", "N", "1 to 100 (default 92)",
        [&fly](const std::string& text) {
            fly.jpegQuality = parseInteger("--jpeg-quality", text);
            if (fly.jpegQuality < 1 || fly.jpegQuality > 100)
                failUsage(fmt::format("--jpeg-quality: {} is out of range; give 1 to 100", text));
        });
    addText(command, kFilm, "--stats", "FILE", "figures of each frame, .csv or .json",
            [&flags](const std::string& text) {
                if (!text.ends_with(".json") && !text.ends_with(".csv"))
                    failUsage(fmt::format("--stats: '{}' must end in .json or .csv", text));
                flags.statsPath = text;
            });
}

void reportFilm(const FlyFlags& flags, const FlyReport& report) {
    const FlyOptions& fly = flags.fly;
    std::error_code ignored;
    const bool film = std::filesystem::is_regular_file(fly.output, ignored);
    std::string text = fmt::format("{}  {}x{}  ", fly.output, fly.width, fly.height);
    if (film) text += bytesText(std::filesystem::file_size(fly.output, ignored)) + "  ";
    text += fmt::format("{} frames", report.frames.size());
    if (report.found > 0) text += fmt::format(" and {} found", report.found);
    if (report.dropped > 0) text += fmt::format(", {} dropped", report.dropped);
    printOut(text + fmt::format("  {:.2f} s\n", report.seconds));
}

void runFly(FlyFlags& flags) {
    setQuiet(flags.source.quiet);
    const std::vector<std::string> inputs{flags.source.source, flags.source.open.photo,
                                          flags.flightPath, flags.look.render.ramp};
    checkNotInput("--output", flags.fly.output, inputs);
    checkNotInput("--stats", flags.statsPath, inputs);
    check(checkFly(flags.look.render, flags.fly));
    if (!flags.statsPath.empty()) checkWritable("--stats", flags.statsPath);
    const Flight flight = valueOf(Flight::read(flags.flightPath, flags.flight));

    const Terrain terrain = valueOf(Terrain::open(flags.source.source, flags.source.open));
    sayAssumptions(terrain.info());
    const FlyReport report = valueOf(fly(terrain, flight, flags.look.render, flags.fly));
    if (!flags.statsPath.empty())
        writeTextFile("--stats", flags.statsPath,
                      flags.statsPath.ends_with(".csv") ? toCsv(report) : toJson(report) + "\n");
    if (!flags.source.quiet) reportFilm(flags, report);
}

}  // namespace

void addFly(CLI::App& program) {
    auto flags = std::make_shared<FlyFlags>();
    CLI::App* command =
        program.add_subcommand("fly", "a film of a flight: MP4, WebM, or a picture a frame");
    flags->source.addTo(*command);
    flags->source.addPhotoTo(*command);
    addFlight(*command, *flags);
    addFilm(*command, *flags);
    flags->look.addTo(*command);
    command->footer(kFlyFooter);
    command->callback([flags] { runFly(*flags); });
}

}  // namespace terray::cli
