// SPDX-License-Identifier: Apache-2.0
// The subcommands of terray-bench, one file each. To add one: a file with an add...() and a line in
// main.cpp.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace terray::bench {

/// What a subcommand leaves behind when it was chosen: its work, which returns the exit code.
using Job = std::function<int()>;

void addKernel(CLI::App& program, Job& job);
void addFrame(CLI::App& program, Job& job);
void addDevice(CLI::App& program, Job& job);
void addShadows(CLI::App& program, Job& job);
void addExactness(CLI::App& program, Job& job);
void addLatency(CLI::App& program, Job& job);
void addTerabyte(CLI::App& program, Job& job);
void addGrowth(CLI::App& program, Job& job);
void addPeers(CLI::App& program, Job& job);

}  // namespace terray::bench
