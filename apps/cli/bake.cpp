// SPDX-License-Identifier: Apache-2.0
// `terray bake` and `terray verify`: stores made and checked.
#include "terray/bake.h"

#include <fmt/format.h>

#include "commands.h"
#include "info_text.h"
#include "options.h"
#include "output.h"
#include "parse.h"
#include "terray/process.h"

namespace terray::cli {
namespace {

constexpr const char* kBakeFooter =
    "A run that was stopped goes on when the same command is given again; with --resume a "
    "finished\n"
    "store is checked, and what is damaged in it is made again. The result is the same, to the "
    "byte,\n"
    "however often a run was stopped and on any number of cores.\n\n"
    "Examples:\n"
    "  terray bake dem.tif -o alps.terray\n"
    "  terray bake dem.tif -o exact.terray --max-error 0\n"
    "  terray bake N37W112.hgt N37W111.hgt -o utah.terray\n"
    "  terray bake dem.tif -o alps.terray --export-cog alps.tif\n"
    "  terray bake dem.tif --photo air.tif -o alps.terray\n"
    "  terray render alps.terray -o picture.png";
constexpr const char* kVerifyFooter =
    "Exit code 1 if anything is damaged.\n\n"
    "Example:\n"
    "  terray verify alps.terray || terray bake dem.tif -o alps.terray --resume";

struct BakeFlags {
    std::vector<std::string> sources;
    std::string out;
    SourceOptions source;
    BakeOptions bake;
};

std::string errorText(double maxError) {
    return maxError > 0 ? fmt::format("within {:g} m", maxError) : "without loss";
}

void runBake(BakeFlags& flags) {
    setQuiet(flags.source.quiet);
    std::vector<std::string> inputs = flags.sources;
    if (!flags.source.open.photo.empty()) inputs.push_back(flags.source.open.photo);
    checkNotInput("--output", flags.out, inputs);
    if (!flags.bake.exportCog.empty()) {
        checkNotInput("--export-cog", flags.bake.exportCog, inputs);
        checkWritable("--export-cog", flags.bake.exportCog);
    }
    flags.bake.open = flags.source.open;
    const BakeReport report = valueOf(bake(flags.sources, flags.out, flags.bake));
    for (const std::string& note : report.notes) writeNote(note);
    if (!report.photo.empty()) writeNote("photo " + report.photo);
    if (report.wasDone) {
        writeNote(flags.bake.resume
                      ? fmt::format("'{}' is whole: nothing to do", flags.out)
                      : fmt::format("'{}' holds this bake already: nothing to do (--resume checks "
                                    "it)",
                                    flags.out));
    } else if (report.foundFiles > 0) {
        writeNote(fmt::format("{} files were there already", report.foundFiles));
    }
    if (!flags.source.quiet) {
        printOut(fmt::format("{}  {} x {} posts, {} mip{}, {}  {}  {:.2f} s\n", flags.out,
                             report.columns, report.rows, report.mips, report.mips == 1 ? "" : "s",
                             errorText(report.maxError), bytesText(report.bytes), report.seconds));
    }
}

void runVerify(const std::string& store, bool quiet) {
    setQuiet(quiet);
    const VerifyReport report = valueOf(verifyStore(store));
    std::string text;
    for (const std::string& line : report.damage) text += oneLine(line) + "\n";
    if (!report.damage.empty()) {
        printOut(text);
        fail(ErrorCode::Failed,
             fmt::format(
                 "'{}' is damaged in {} place{}; `terray bake ... -o {} --resume` makes only "
                 "these again",
                 store, report.damage.size(), report.damage.size() == 1 ? "" : "s", store));
    }
    if (!quiet) {
        printOut(fmt::format("{}: {} files, {} tiles, {}: whole\n", store, report.files,
                             report.tiles, bytesText(report.bytes)));
    }
}

}  // namespace

void addBake(CLI::App& program) {
    auto flags = std::make_shared<BakeFlags>();
    CLI::App* command = program.add_subcommand("bake", "DEMs of any size into a .terray store");
    command
        ->add_option("DEM", flags->sources,
                     "DEMs that GDAL reads; several are joined, the last named one that has a "
                     "height on top")
        ->type_name("")
        ->required();
    command->add_option("-o,--output", flags->out, "the store to make, NAME.terray")
        ->type_name("STORE")
        ->required();
    flags->source.addPhotoTo(*command);
    addText(
        *command, "Store", "--max-error", "M",
        "metres that a stored height may be off; 0: none (default: a quarter of a step of whole "
        "numbers, else 0.01)",
        [flags](const std::string& text) {
            flags->bake.maxError = parseNumber("--max-error", text);
        });
    addText(*command, "Photo", "--photo-quality", "Q",
            "of its JPEG, 1 to 100 (default 90), or lossless",
            [flags](const std::string& text) {
                flags->bake.photoQuality =
                    text == "lossless" ? 0 : parseInteger("--photo-quality", text);
            })
        ->needs(command->get_option("--photo"));
    addText(*command, "Store", "--export-cog", "FILE.tif",
            "write the heights as one Cloud Optimized GeoTIFF, too",
            [flags](const std::string& text) { flags->bake.exportCog = text; });
    addSwitch(*command, "Store", "--in-place",
              "a GeoTIFF in blocks of 512 x 512 stays where it is, as mip 0 of the store",
              flags->bake.inPlace);
    addSwitch(*command, "Store", "--resume", "check a finished store, make again what is damaged",
              flags->bake.resume);
    flags->source.addReadingTo(*command, "1GiB");
    command->footer(kBakeFooter);
    command->callback([flags] { runBake(*flags); });
}

void addVerify(CLI::App& program) {
    struct Flags {
        std::string store;
        bool quiet = false;
    };
    auto flags = std::make_shared<Flags>();
    CLI::App* command =
        program.add_subcommand("verify", "every byte of a store against its hashes");
    command->add_option("STORE", flags->store, "a .terray store")->type_name("")->required();
    addSwitch(*command, "Machine", "-q,--quiet", "no progress bar, only what is damaged",
              flags->quiet);
    command->footer(kVerifyFooter);
    command->callback([flags] { runVerify(flags->store, flags->quiet); });
}

}  // namespace terray::cli
