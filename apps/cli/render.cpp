// SPDX-License-Identifier: Apache-2.0
// `terray render`: a still picture and buffers.
#include "terray/renderer.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "info_text.h"
#include "options.h"
#include "output.h"
#include "terray/process.h"
#include "usage.h"

namespace terray::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct RenderFlags {
    SourceOptions source;
    ViewOptions view;
    LookOptions look;
    OutputFlags output;
};

constexpr const char* kRenderFooter =
    "Examples:\n"
    "  terray render dem.tif\n"
    "  terray render dem.tif -o picture.jpg --size 3840x2160 --samples 8\n"
    "  terray render dem.tif --eye 500100,4200300,+200 --look-at 503000,4207000\n"
    "  terray render dem.tif --lonlat --eye -105.2,37.1,4000 --heading 270 --pitch -10\n"
    "  terray render dem.tif --photo air.tif --time 2024-06-21T08:30:00+02:00\n"
    "  terray render dem.tif --projection ortho --legend --contours 50 -o map.tif\n"
    "  terray render dem.tif --aov distance=distance.tif --aov normal=normal.exr\n"
    "  terray render dem.asc --assign-crs EPSG:4326 --height-unit ft";

/// One header line and one line of values.
std::string statsCsv(const std::string& json) {
    std::string names, values;
    const auto object = nlohmann::ordered_json::parse(json);
    for (const auto& [name, value] : object.items()) {
        std::string text = value.is_string() ? value.get<std::string>() : value.dump();
        if (value.is_array()) std::replace(text.begin(), text.end(), ',', ' ');
        names += (names.empty() ? "" : ",") + name;
        values += (names == name ? "" : ",") + text;
    }
    return names + "\n" + values + "\n";
}

void sayFacts(const SourceInfo& info, const RenderOptions& render) {
    sayAssumptions(info);
    const auto factor = suggestedExaggeration(info);
    if (factor && render.exaggeration == 1)
        writeNote(fmt::format("the relief is only {:.2f} % of the width: try --exaggeration {:g}",
                              reliefPercent(info), *factor));
}

void reportFiles(const OutputOptions& outputs, const RenderStats& stats, double seconds) {
    std::vector<std::string> paths;
    if (!outputs.path.empty()) paths.push_back(outputs.path);
    for (const AovOutput& aov : outputs.aovs) paths.push_back(aov.path);
    std::string text;
    for (const std::string& path : paths) {
        std::error_code ignored;
        text += fmt::format("{}  {}x{}  {}  {:.2f} s\n", path, stats.width, stats.height,
                            bytesText(std::filesystem::file_size(path, ignored)), seconds);
    }
    printOut(text);
}

void checkInputsAreKept(const RenderFlags& flags) {
    const std::vector<std::string> inputs{flags.source.source, flags.source.open.photo,
                                          flags.view.file, flags.look.render.ramp};
    checkNotInput("--output", flags.output.outputs.path, inputs);
    checkNotInput("--stats", flags.output.statsPath, inputs);
    for (const AovOutput& aov : flags.output.outputs.aovs) checkNotInput("--aov", aov.path, inputs);
}

void runRender(RenderFlags& flags) {
    const auto start = Clock::now();
    setQuiet(flags.source.quiet);
    OutputOptions& outputs = flags.output.outputs;
    if (!flags.output.pathGiven && !outputs.aovs.empty()) outputs.path.clear();
    const View view = flags.view.resolve();
    checkInputsAreKept(flags);
    check(checkRender(view, flags.look.render, outputs));
    const std::string& statsPath = flags.output.statsPath;
    if (!statsPath.empty()) checkWritable("--stats", statsPath);

    const Terrain terrain = valueOf(Terrain::open(flags.source.source, flags.source.open));
    flags.look.checkPhoto(terrain.info());
    sayFacts(terrain.info(), flags.look.render);
    const RenderStats stats = valueOf(renderToFiles(terrain, view, flags.look.render, outputs));
    if (!statsPath.empty()) {
        const std::string json = toJson(stats);
        writeTextFile("--stats", statsPath,
                      statsPath.ends_with(".csv") ? statsCsv(json) : json + "\n");
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (!flags.source.quiet) reportFiles(outputs, stats, seconds);
}

}  // namespace

void addRender(CLI::App& program) {
    auto flags = std::make_shared<RenderFlags>();
    CLI::App* command = program.add_subcommand("render", "a still picture: PNG, JPEG, EXR, TIFF");
    flags->source.addTo(*command);
    flags->source.addPhotoTo(*command);
    flags->view.addTo(*command);
    flags->look.addTo(*command);
    flags->output.addTo(*command);
    command->footer(kRenderFooter);
    command->callback([flags] { runRender(*flags); });
}

}  // namespace terray::cli
