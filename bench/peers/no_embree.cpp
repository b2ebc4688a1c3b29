// SPDX-License-Identifier: Apache-2.0
// `terray-bench peers` in a build without Embree: says what is missing.
#include "commands.h"
#include "scene.h"

namespace terray::bench {

void addPeers(CLI::App& program, Job& job) {
    CLI::App* command = program.add_subcommand(
        "peers", "speed and memory beside Embree's (this build has no Embree)");
    command->allow_extras();
    command->callback([&job] {
        job = [] {
            return report(makeError(ErrorCode::Resource,
                                    "peers: this build has no Embree; install libembree-dev "
                                    "(scripts/install-deps --bench) and build again"));
        };
    });
}

}  // namespace terray::bench
