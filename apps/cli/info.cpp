// SPDX-License-Identifier: Apache-2.0
// `terray info`: what a source says, and what Terray makes of it.
#include <memory>

#include "commands.h"
#include "info_text.h"
#include "options.h"
#include "output.h"
#include "terray/process.h"
#include "terray/terrain.h"
#include "usage.h"

namespace terray::cli {

void addInfo(CLI::App& program) {
    struct Flags {
        SourceOptions source;
        bool json = false, noScan = false;
    };
    auto flags = std::make_shared<Flags>();
    CLI::App* command = program.add_subcommand(
        "info", "size, CRS, units, nodata, range, and what would be assumed");
    flags->source.addTo(*command);
    addSwitch(*command, "Output", "--json", "as JSON", flags->json);
    addSwitch(*command, "Output", "--no-scan", "read the header only: no height range",
              flags->noScan);
    command->footer(
        "Examples:\n"
        "  terray info dem.tif\n"
        "  terray info dem.asc --assign-crs EPSG:32613 --json\n"
        "  terray info tile.png --encoding terrain-rgb");
    command->callback([flags] {
        setQuiet(flags->source.quiet);
        const SourceInfo info =
            valueOf(inspect(flags->source.source, flags->source.open, !flags->noScan));
        printOut(flags->json ? infoJson(info) : infoText(info));
    });
}

}  // namespace terray::cli
