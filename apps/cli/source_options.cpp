// SPDX-License-Identifier: Apache-2.0
// SOURCE and everything about reading it.
#include <array>

#include "options.h"
#include "parse.h"

namespace terray::cli {
namespace {

constexpr std::array<std::pair<const char*, HeightUnit>, 3> kHeightUnits{
    {{"m", HeightUnit::Metre}, {"ft", HeightUnit::Foot}, {"us-ft", HeightUnit::UsSurveyFoot}}};
constexpr std::array<std::pair<const char*, HeightEncoding>, 2> kEncodings{
    {{"terrain-rgb", HeightEncoding::TerrainRgb}, {"terrarium", HeightEncoding::Terrarium}}};

constexpr const char* kData = "What the data do not say";
constexpr const char* kPhoto = "Photo";
constexpr const char* kMachine = "Machine";

}  // namespace

CLI::Option* addText(CLI::App& command, const std::string& group, const std::string& name,
                     const std::string& value, const std::string& help,
                     std::function<void(const std::string&)> take) {
    return command.add_option_function<std::string>(name, take, help)
        ->type_name(value)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
        ->group(group);
}

CLI::Option* addSwitch(CLI::App& command, const std::string& group, const std::string& name,
                       const std::string& help, bool& target) {
    return command.add_flag(name, target, help)->group(group);
}

void SourceOptions::addTo(CLI::App& command) {
    command
        .add_option("SOURCE", source,
                    "a DEM: any raster that GDAL reads, or a .terray store; a path or a URL")
        ->type_name("")
        ->required();
    addReadingTo(command, "the smaller of 2GiB and half of the RAM");
}

void SourceOptions::addReadingTo(CLI::App& command, const std::string& memory) {
    addText(command, kData, "--assign-crs", "EPSG:n", "the source's CRS",
            [this](const std::string& text) { open.assignCrs = text; });
    addText(command, kData, "--crs", "EPSG:n", "the CRS to work in (default: by rule, said)",
            [this](const std::string& text) { open.workingCrs = text; });
    addText(command, kData, "--height-unit", "m|ft|us-ft", "unit of the heights",
            [this](const std::string& text) {
                open.heightUnit = parseName("--height-unit", text, kHeightUnits);
            });
    addText(command, kData, "--nodata", "V", "the value that means no height",
            [this](const std::string& text) {
                open.nodata = text == "nan" ? std::numeric_limits<double>::quiet_NaN()
                                            : parseNumber("--nodata", text);
            });
    addText(command, kData, "--band", "N", "the band with the heights (default 1)",
            [this](const std::string& text) {
                open.band = parseInteger("--band", text);
                if (open.band < 1) failUsage("--band: bands are counted from 1");
            });
    addText(command, kData, "--encoding", "NAME", "heights in colours: terrain-rgb, terrarium",
            [this](const std::string& text) {
                open.encoding = parseName("--encoding", text, kEncodings);
            });
    addText(command, kMachine, "--threads", "N", "cores to use (default: all)",
            [this](const std::string& text) {
                open.threads = parseInteger("--threads", text);
                if (open.threads < 1 || open.threads > 4096)
                    failUsage(fmt::format("--threads: {} is out of range; give 1 to 4096", text));
            });
    addText(command, kMachine, "--memory", "SIZE", "memory budget (default: " + memory + ")",
            [this](const std::string& text) { open.memoryBytes = parseBytes("--memory", text); });
    addSwitch(command, kMachine, "-q,--quiet", "no notes and no progress bar", quiet);
}

void SourceOptions::addPhotoTo(CLI::App& command) {
    CLI::Option* photo = addText(command, kPhoto, "--photo", "RASTER",
                                 "an image to drape over the terrain, in any CRS",
                                 [this](const std::string& text) { open.photo = text; });
    addText(
        command, kPhoto, "--photo-bands", "R,G,B", "its bands to show, as 3,2,1 or one band",
        [this](const std::string& text) {
            const size_t count = split(text, ',').size() == 1 ? 1 : 3;
            for (const double band : parseNumbers("--photo-bands", text, count)) {
                if (band < 1 || band > 65535 || band != static_cast<int>(band))
                    failUsage(fmt::format(
                        "--photo-bands: '{}' is not one band or three; give whole numbers from 1",
                        text));
                open.photoBands.push_back(static_cast<int>(band));
            }
        })
        ->needs(photo);
    addText(
        command, kPhoto, "--photo-stretch", "LOW,HIGH",
        "percentiles shown as black and white (default for 16 bit: 2,98)",
        [this](const std::string& text) {
            const auto p = parseNumbers("--photo-stretch", text, 2);
            if (p[0] < 0 || p[1] > 100 || p[0] >= p[1])
                failUsage(fmt::format(
                    "--photo-stretch: '{}' is no pair of percentiles; give LOW,HIGH in 0 to 100",
                    text));
            open.photoStretch = {{p[0], p[1]}};
        })
        ->needs(photo);
}

}  // namespace terray::cli
