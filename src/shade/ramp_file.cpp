// SPDX-License-Identifier: Apache-2.0
// Parser of GDAL color-relief text: values, percentages, nv, default; RGB, RGBA or colour names.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "shade/ramp.h"

namespace terray {
namespace {

struct NamedColour {
    std::string_view name;
    float r, g, b;
};
/// The names that GDAL knows.
constexpr std::array<NamedColour, 17> kNames{{{"white", 255, 255, 255},
                                              {"black", 0, 0, 0},
                                              {"red", 255, 0, 0},
                                              {"green", 0, 255, 0},
                                              {"blue", 0, 0, 255},
                                              {"yellow", 255, 255, 0},
                                              {"magenta", 255, 0, 255},
                                              {"cyan", 0, 255, 255},
                                              {"aqua", 0, 191, 191},
                                              {"grey", 127, 127, 127},
                                              {"gray", 127, 127, 127},
                                              {"orange", 255, 127, 0},
                                              {"brown", 127, 63, 0},
                                              {"purple", 127, 0, 255},
                                              {"violet", 127, 0, 255},
                                              {"indigo", 0, 0, 127},
                                              {"transparent", 0, 0, 0}}};

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return out;
}

std::vector<std::string> wordsOf(std::string_view line) {
    std::vector<std::string> words;
    std::string word;
    for (char c : line) {
        if (c == ' ' || c == ',' || c == '\t' || c == ':' || c == ';' || c == '\r') {
            if (!word.empty()) words.push_back(std::exchange(word, {}));
        } else {
            word += c;
        }
    }
    if (!word.empty()) words.push_back(word);
    return words;
}

bool parseNumber(std::string_view word, double& value) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
}

bool parseColour(const std::vector<std::string>& words, ColourStop& stop) {
    if (words.size() == 2) {
        const std::string name = lower(words[1]);
        for (const NamedColour& known : kNames) {
            if (known.name != name) continue;
            stop.r = known.r, stop.g = known.g, stop.b = known.b;
            stop.a = name == "transparent" ? 0.0f : 255.0f;
            return true;
        }
        return false;
    }
    if (words.size() != 4 && words.size() != 5) return false;
    float* const channels[] = {&stop.r, &stop.g, &stop.b, &stop.a};
    for (size_t k = 1; k < words.size(); ++k) {
        double value = 0;
        if (!parseNumber(words[k], value) || value < 0 || value > 255) return false;
        *channels[k - 1] = static_cast<float>(value);
    }
    return true;
}

}  // namespace

Result<std::vector<ColourStop>> parseColourText(const std::string& text, const std::string& path,
                                                double minZ, double maxZ) {
    std::vector<ColourStop> stops;
    int number = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        std::string_view line(text.data() + at, end - at);
        at = end + 1;
        ++number;
        const auto words = wordsOf(line.substr(0, line.find('#')));
        if (words.empty()) continue;
        const std::string key = lower(words[0]);
        ColourStop stop;
        const bool percent = key.ends_with('%');
        const bool special = key == "nv" || key == "default";  // holes are not drawn anyway
        if ((!special &&
             !parseNumber(percent ? key.substr(0, key.size() - 1) : key, stop.height)) ||
            !parseColour(words, stop)) {
            return makeError(ErrorCode::Input,
                             "'{}' line {}: '{}' is not a colour stop; write `height red green "
                             "blue [alpha]` with 0..255, a percentage, or a colour name",
                             path, number, line.substr(0, 60));
        }
        if (special) continue;
        if (percent) stop.height = minZ + stop.height / 100.0 * (maxZ - minZ);
        stops.push_back(stop);
    }
    if (stops.empty())
        return makeError(ErrorCode::Input,
                         "'{}' holds no colour stop; each line is `height red green blue`", path);
    std::stable_sort(stops.begin(), stops.end(),
                     [](const ColourStop& a, const ColourStop& b) { return a.height < b.height; });
    return stops;
}

}  // namespace terray
