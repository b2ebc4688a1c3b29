// SPDX-License-Identifier: Apache-2.0
// Output flags.
#include "names.h"
#include "options.h"
#include "output.h"
#include "parse.h"

namespace terray::cli {

void OutputFlags::addTo(CLI::App& command) {
    constexpr const char* kOutput = "Output";
    addText(command, kOutput, "-o,--output", "FILE",
            "the picture: .png, .jpg, .exr or .tif (default terray.png; with --aov only: none)",
            [this](const std::string& text) {
                outputs.path = text;
                pathGiven = true;
            });
    command
        .add_option_function<std::vector<std::string>>(
            "--aov",
            [this](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) {
                    const auto sign = text.find('=');
                    if (sign == std::string::npos || sign + 1 == text.size())
                        failUsage(fmt::format(
                            "--aov: '{}' has no file; give NAME=FILE, like distance=d.tif", text));
                    outputs.aovs.push_back(
                        {parseName("--aov", text.substr(0, sign), kAovs), text.substr(sign + 1)});
                }
            },
            "a buffer of floats, .tif or .exr, as distance=d.tif: distance, depth, position, "
            "normal, "
            "height, mip, steps, shadow, error (may be repeated)")
        ->type_name("NAME=FILE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->group(kOutput);
    addText(
        command, kOutput, "--jpeg-quality", "N", "1 to 100 (default 92)",
        [this](const std::string& text) {
            outputs.jpegQuality = parseInteger("--jpeg-quality", text);
            if (outputs.jpegQuality < 1 || outputs.jpegQuality > 100)
                failUsage(fmt::format("--jpeg-quality: {} is out of range; give 1 to 100", text));
        });
    addText(
        command, kOutput, "--stats", "FILE", "figures of the run, .json or .csv",
        [this](const std::string& text) {
            if (!text.ends_with(".json") && !text.ends_with(".csv") && !text.starts_with("/dev/"))
                failUsage(fmt::format("--stats: '{}' must end in .json or .csv", text));
            statsPath = text;
        });
}

}  // namespace terray::cli
