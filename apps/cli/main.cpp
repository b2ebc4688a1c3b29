// SPDX-License-Identifier: Apache-2.0
// `terray`: finds the command, runs it, turns every failure into one line and an exit code.
#include <fmt/format.h>
#include <malloc.h>

#include <csignal>
#include <cstdio>

#include "commands.h"
#include "output.h"
#include "terray/process.h"
#include "terray/version.h"
#include "usage.h"

namespace {

using namespace terray;
using namespace terray::cli;

constexpr const char* kMainFooter =
    "Examples:\n"
    "  terray info dem.tif\n"
    "  terray render dem.tif -o picture.png\n"
    "  terray render dem.tif --photo air.tif --time 2024-06-21T08:30:00+02:00 -o morning.jpg\n"
    "  terray fly dem.tif --flight over.txt -o film.mp4\n"
    "  terray query dem.tif height 500100,4200300\n"
    "\n"
    "Exit codes: 0 done, 1 the work failed (also: standard output closed), 2 wrong usage, 3 input\n"
    "unreadable or refused, 4 device or resource missing, 130 interrupted.";

int report(const Error& error) {
    std::fputs(fmt::format("terray: {}\n", oneLine(unmarked(error.message))).c_str(), stderr);
    return static_cast<int>(error.code);
}

/// "terray render", for "see 'terray render --help'".
std::string commandName(const CLI::App& program) {
    std::string name = program.get_name();
    const CLI::App* app = &program;
    while (!app->get_subcommands().empty()) {
        app = app->get_subcommands().front();
        name += " " + app->get_name();
    }
    return name;
}

void refuseUnknownCommand(const CLI::App& program, const std::vector<std::string>& arguments) {
    if (arguments.empty())
        failUsage("give a command: info, render, fly, query, ...; see 'terray --help'");
    const std::string& first = arguments.front();
    if (first.starts_with("-")) return;
    for (const CLI::App* command : program.get_subcommands({}))
        if (command->get_name() == first) return;
    failUsage(fmt::format("'{}' is no command; see 'terray --help'", first));
}

int parse(CLI::App& program, const std::vector<std::string>& arguments) {
    refuseUnknownCommand(program, arguments);
    if (arguments.front() == "bench") return runBench({arguments.begin() + 1, arguments.end()});
    std::vector<std::string> reversed = markNegativeNumbers(arguments);
    std::reverse(reversed.begin(), reversed.end());
    try {
        program.parse(reversed);
    } catch (const CLI::CallForHelp&) {
        printOut(program.help());
    } catch (const CLI::CallForVersion&) {
        printOut(fmt::format("terray {}\n", version()));
    } catch (const CLI::ExtrasError&) {
        failUsage(fmt::format("'{}' is not expected here; see '{} --help'",
                              unmarked(program.remaining(true).front()), commandName(program)));
    } catch (const CLI::ParseError& error) {
        failUsage(usageMessage(error, commandName(program)));
    }
    return 0;
}

int run(const std::vector<std::string>& arguments) {
    CLI::App program("Terray: see a terrain, exactly and at once.", "terray");
    program.set_version_flag("--version", version(), "print the version");
    program.footer(kMainFooter);
    program.require_subcommand(1);
    program.get_formatter()->column_width(34);
    addInfo(program);
    addBake(program);
    addVerify(program);
    addRender(program);
    addFly(program);
    addQuery(program);
    addLists(program);
    addBench(program);
    return parse(program, arguments);
}

/// Large buffers go back to the system as soon as they are freed, whatever was freed before; else
/// the heap keeps what an earlier stage needed, and --memory would have to count it.
void returnFreedMemory() {
    constexpr int kLarge = 1 << 20;
    mallopt(M_MMAP_THRESHOLD, kLarge);
    mallopt(M_TRIM_THRESHOLD, kLarge);
}

}  // namespace

int main(int argc, char** argv) {
    returnFreedMemory();
    // A closed pipe and a file-size limit are failed writes, checked where they happen.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    terray::handleInterrupts();
    try {
        return run({argv + 1, argv + argc});
    } catch (const terray::cli::Failure& failure) {
        return report(failure.error);
    } catch (const std::exception& problem) {
        return report({terray::ErrorCode::Failed, problem.what()});
    }
}
