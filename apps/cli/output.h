// SPDX-License-Identifier: Apache-2.0
// Text out: standard output and files, every write checked.
#pragma once

#include <string>
#include <vector>

namespace terray::cli {

/// Writes to standard output and flushes; a closed pipe or full disk is a Failure (exit 1).
void printOut(const std::string& text);

/// Fails now (exit 1) if the file could not be written later. Creates nothing.
void checkWritable(const std::string& option, const std::string& path);

/// Refuses (exit 2) to write over one of the files that are read.
void checkNotInput(const std::string& option, const std::string& path,
                   const std::vector<std::string>& inputs);

/// Writes a file completely or not at all; devices and pipes directly.
void writeTextFile(const std::string& option, const std::string& path, const std::string& text);

}  // namespace terray::cli
