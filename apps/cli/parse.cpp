// SPDX-License-Identifier: Apache-2.0
// Parsing of option values.
#include "parse.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace terray::cli {
namespace {

[[noreturn]] void failValue(const std::string& option, const std::string& text,
                            const std::string& wanted) {
    failUsage(fmt::format("{}: '{}' is not {}", option, unmarked(text), wanted));
}

/// True if all of the text is one number.
bool readNumber(std::string text, double& value) {
    text = unmarked(std::move(text));
    const char* begin = text.data();
    const char* end = begin + text.size();
    if (begin != end && *begin == '+') ++begin;
    const auto [stop, problem] = std::from_chars(begin, end, value);
    return problem == std::errc{} && stop == end && std::isfinite(value);
}

}  // namespace

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(" \t\r");
    const auto last = text.find_last_not_of(" \t\r");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == separator)
            parts.emplace_back();
        else
            parts.back() += c;
    }
    for (std::string& part : parts) part = trimmed(part);
    return parts;
}

double parseNumber(const std::string& option, const std::string& text) {
    double value = 0;
    if (!readNumber(text, value)) failValue(option, text, "a finite number; give one like 12.5");
    return value;
}

int parseInteger(const std::string& option, const std::string& text) {
    const double value = parseNumber(option, text);
    if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max())
        failValue(option, text, "a whole number; give one like 4");
    return static_cast<int>(value);
}

std::vector<double> parseNumbers(const std::string& option, const std::string& text, size_t count) {
    std::vector<double> values;
    for (const std::string& part : split(text, ',')) {
        double value = 0;
        if (!readNumber(part, value))
            failValue(option, text, fmt::format("{} numbers with commas between", count));
        values.push_back(value);
    }
    if (values.size() != count)
        failValue(option, text, fmt::format("{} numbers with commas between", count));
    return values;
}

void parseHeight(const std::string& option, const std::string& text, Place& place) {
    if (text.empty()) return;
    double value = 0;
    if (!readNumber(text, value))
        failValue(option, text, "a height; give metres, or +H for H metres above the ground");
    place.z = value;
    place.aboveGround = text[0] == '+';
}

Place parsePlace(const std::string& option, const std::string& text) {
    const std::vector<std::string> parts = split(text, ',');
    Place place;
    if (parts.size() < 2 || parts.size() > 3 || !readNumber(parts[0], place.x) ||
        !readNumber(parts[1], place.y))
        failValue(option, text, "a place; give X,Y,Z or X,Y,+H (H metres above the ground)");
    if (parts.size() == 3) parseHeight(option, parts[2], place);
    return place;
}

std::pair<int, int> parseSize(const std::string& option, const std::string& text) {
    const std::vector<std::string> parts = split(text, 'x');
    double width = 0, height = 0;
    const bool good = parts.size() == 2 && readNumber(parts[0], width) &&
                      readNumber(parts[1], height) && width == std::floor(width) &&
                      height == std::floor(height) && std::abs(width) < 1e9 &&
                      std::abs(height) < 1e9;
    if (!good) failValue(option, text, "a size; give WxH in pixels, like 1920x1080");
    return {static_cast<int>(width), static_cast<int>(height)};
}

uint64_t parseBytes(const std::string& option, const std::string& text) {
    const std::string wanted = "an amount of memory; give one like 512MiB or 2GiB";
    const auto unitAt = std::min(text.find_first_not_of("0123456789.,"), text.size());
    std::string unit = text.substr(unitAt);
    std::transform(unit.begin(), unit.end(), unit.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    double value = 0;
    if (!readNumber(text.substr(0, unitAt), value)) failValue(option, text, wanted);
    constexpr std::pair<const char*, double> kUnits[] = {{"", 1},
                                                         {"b", 1},
                                                         {"k", 1024.0},
                                                         {"kib", 1024.0},
                                                         {"kb", 1e3},
                                                         {"m", 1048576.0},
                                                         {"mib", 1048576.0},
                                                         {"mb", 1e6},
                                                         {"g", 1073741824},
                                                         {"gib", 1073741824},
                                                         {"gb", 1e9},
                                                         {"t", 1099511627776.0},
                                                         {"tib", 1099511627776.0},
                                                         {"tb", 1e12}};
    for (const auto& [name, factor] : kUnits) {
        if (unit != name) continue;
        const double bytes = value * factor;
        if (bytes < 16.0 * 1048576.0 || bytes > 1e18)
            failUsage(fmt::format("{}: '{}' is out of range; give 16MiB or more", option, text));
        return static_cast<uint64_t>(bytes);
    }
    failValue(option, text, wanted);
}

bool parseOnOff(const std::string& option, const std::string& text) {
    if (text == "on") return true;
    if (text == "off") return false;
    failValue(option, text, "on or off");
}

}  // namespace terray::cli
