// SPDX-License-Identifier: Apache-2.0
// Text to values; a wrong one ends the command with a sentence that names the option.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "terray/view.h"

namespace terray::cli {

/// A finite number.
double parseNumber(const std::string& option, const std::string& text);
int parseInteger(const std::string& option, const std::string& text);
/// Exactly `count` numbers with commas between.
std::vector<double> parseNumbers(const std::string& option, const std::string& text, size_t count);
/// X,Y or X,Y,Z or X,Y,+H.
Place parsePlace(const std::string& option, const std::string& text);
/// Z or +H into a place; empty text: the ground.
void parseHeight(const std::string& option, const std::string& text, Place& place);
/// WxH.
std::pair<int, int> parseSize(const std::string& option, const std::string& text);
/// 2GiB, 512MiB, 4G, 1000000.
uint64_t parseBytes(const std::string& option, const std::string& text);
bool parseOnOff(const std::string& option, const std::string& text);

/// Without spaces, tabs and carriage returns at its ends.
std::string trimmed(const std::string& text);
/// Parts between separators, blanks around them taken off.
std::vector<std::string> split(const std::string& text, char separator);

/// The value of a name in a table of (name, value).
template <class Table>
auto parseName(const std::string& option, const std::string& text, const Table& table);

}  // namespace terray::cli

#include "parse_name.h"
