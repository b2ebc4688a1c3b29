// SPDX-License-Identifier: Apache-2.0
// The subcommands. Each adds itself to the program and does its work in its callback.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace terray::cli {

void addInfo(CLI::App& program);
void addBake(CLI::App& program);
void addVerify(CLI::App& program);
void addRender(CLI::App& program);
void addFly(CLI::App& program);
void addQuery(CLI::App& program);
void addLists(CLI::App& program);  ///< techniques, shadings
/// For the list of commands only: runBench() gets all arguments untouched.
void addBench(CLI::App& program);
/// Becomes terray-bench; returns (by a Failure) only if it is not installed.
int runBench(const std::vector<std::string>& arguments);

}  // namespace terray::cli
