// SPDX-License-Identifier: Apache-2.0
// terray-bench: speed and exactness of Terray, one subcommand a file.
#include "commands.h"

int main(int argc, char** argv) {
    CLI::App program{"Measures Terray: speed and exactness of its parts", "terray-bench"};
    program.require_subcommand(1);
    program.footer(
        "Examples:\n  terray-bench kernel\n  terray-bench frame --threads 2\n  terray-bench "
        "exactness dem.tif");
    terray::bench::Job job;
    terray::bench::addKernel(program, job);
    terray::bench::addFrame(program, job);
    terray::bench::addDevice(program, job);
    terray::bench::addShadows(program, job);
    terray::bench::addExactness(program, job);
    terray::bench::addLatency(program, job);
    terray::bench::addTerabyte(program, job);
    terray::bench::addGrowth(program, job);
    terray::bench::addPeers(program, job);
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return program.exit(error) == 0 ? 0 : 2;
    }
    return job();
}
