// SPDX-License-Identifier: Apache-2.0
// `terray techniques`, `terray shadings`, `terray devices`: names with one line each.
#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "terray/renderer.h"

namespace terray::cli {
namespace {

std::string listText(const std::vector<NamedLine>& lines) {
    size_t width = 0;
    for (const NamedLine& l : lines) width = std::max(width, l.name.size());
    std::string text;
    for (const NamedLine& l : lines) text += fmt::format("{:<{}}  {}\n", l.name, width, l.line);
    return text;
}

}  // namespace

void addLists(CLI::App& program) {
    CLI::App* listTechniques = program.add_subcommand("techniques", "list the ways to find hits");
    listTechniques->footer("Example:\n  terray render dem.tif --technique ray_cast");
    listTechniques->callback([] { printOut(listText(techniques())); });
    CLI::App* listDevices = program.add_subcommand("devices", "list what can trace rays");
    listDevices->footer("Example:\n  terray render dem.tif --device vulkan:0");
    listDevices->callback([] { printOut(listText(devices())); });
    CLI::App* listShadings =
        program.add_subcommand("shadings", "list the ways to colour the ground, and the ramps");
    listShadings->footer("Example:\n  terray render dem.tif --shading slope");
    listShadings->callback([] {
        printOut("Shadings (--shading):\n" + listText(shadings()) + "\nRamps (--ramp):\n" +
                 listText(ramps()));
    });
}

}  // namespace terray::cli
