// SPDX-License-Identifier: Apache-2.0
// Parsing flights: directives and key frames, each error with its line.
#include "flight/flight_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace terray {
namespace {

constexpr std::uintmax_t kMostFlightBytes = 16u << 20;
constexpr size_t kMostKeys = 100'000, kMostLineBytes = 4096;
constexpr const char* kKeyForm =
    "a key frame is: SECONDS X,Y,Z HEADING,PITCH[,ROLL] or SECONDS X,Y,Z look-at X,Y[,Z]";

bool readNumber(std::string_view text, double& value) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    if (text.empty() || text.front() == '+') return false;
    const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    return problem == std::errc{} && stop == text.data() + text.size() && std::isfinite(value);
}

std::vector<std::string> split(std::string_view text, std::string_view separators, bool keepEmpty) {
    std::vector<std::string> parts;
    size_t from = 0;
    while (from <= text.size()) {
        const size_t to = std::min(text.find_first_of(separators, from), text.size());
        if (to > from || keepEmpty) parts.emplace_back(text.substr(from, to - from));
        from = to + 1;
    }
    return parts;
}

/// Words of a line without its comment; blanks around commas do not count.
std::vector<std::string> wordsOf(std::string_view line) {
    line = line.substr(0, line.find('#'));
    std::string joined;
    for (const char c : line) {
        const bool blank = c == ' ' || c == '\t' || c == '\r';
        if (c == ',')
            while (!joined.empty() && joined.back() == ' ') joined.pop_back();
        if (blank && !joined.empty() && joined.back() == ',') continue;
        joined += blank ? ' ' : c;
    }
    return split(joined, " ", false);
}

class FlightParser {
public:
    FlightParser(const std::string& path, bool speedGiven) : speedGiven_(speedGiven) {
        flight_.path = path;
    }

    Result<void> take(std::string_view line) {
        ++line_;
        if (line.size() > kMostLineBytes)
            return bad("the line is longer than {} bytes; this is no flight file", kMostLineBytes);
        const std::vector<std::string> words = wordsOf(line);
        if (words.empty()) return {};
        const char first = words[0][0];
        if ((first >= '0' && first <= '9') || first == '-' || first == '+' || first == '.')
            return takeKey(words);
        return takeDirective(words);
    }

    Result<FlightFile> finish() {
        if (flight_.keys.empty())
            return makeError(ErrorCode::Input, "{}:{}: there is no key frame; {}", flight_.path,
                             std::max(line_, 1), kKeyForm);
        if (flight_.keys.size() == 1)
            return makeError(ErrorCode::Input,
                             "{}:{}: one key frame is no flight; give two or more, or use 'terray "
                             "render' for a still",
                             flight_.path, flight_.keys[0].line);
        return std::move(flight_);
    }

private:
    template <class... Args>
    Error bad(fmt::format_string<Args...> format, Args&&... args) const {
        return makeError(ErrorCode::Input, "{}:{}: {}", flight_.path, line_,
                         fmt::format(format, std::forward<Args>(args)...));
    }

    Result<void> takeDirective(const std::vector<std::string>& words) {
        const std::string& name = words[0];
        const bool known = name == "crs" || name == "lonlat" || name == "speed" ||
                           name == "clearance" || name == "fov";
        if (!known)
            return bad(
                "'{}' is neither a key frame nor one of crs, lonlat, speed, clearance, fov; {}",
                name, kKeyForm);
        const size_t wanted = name == "lonlat" ? 1 : 2;
        if (words.size() != wanted)
            return bad("'{}' takes {}; give '{}'", name, wanted == 1 ? "no value" : "one value",
                       wanted == 1 ? name : name + (name == "crs" ? " EPSG:n" : " NUMBER"));
        if (name == "fov") return takeNumber(words, 0.01, 179, "degrees", fov_);
        if (!flight_.keys.empty()) return bad("'{}' must stand above the first key frame", name);
        if (std::find(seen_.begin(), seen_.end(), name) != seen_.end())
            return bad("'{}' is given twice; leave one", name);
        seen_.push_back(name);
        if (name == "speed") return takeNumber(words, 0.001, 1e6, "metres a second", flight_.speed);
        if (name == "clearance") {
            std::optional<double> metres;
            TERRAY_TRY(takeNumber(words, 0.1, 1e5, "metres", metres));
            flight_.clearance = *metres;
            return {};
        }
        if (name == "crs") flight_.crs = words[1];
        if (name == "lonlat") flight_.lonLat = true;
        if (flight_.lonLat && !flight_.crs.empty())
            return bad("'crs' and 'lonlat' both say what X,Y are; leave one");
        return {};
    }

    Result<void> takeNumber(const std::vector<std::string>& words, double low, double high,
                            const char* unit, std::optional<double>& out) const {
        double value = 0;
        if (!readNumber(words[1], value) || value < low || value > high)
            return bad("{}: '{}' is not possible; give {:g} to {:g} {}", words[0], words[1], low,
                       high, unit);
        out = value;
        return {};
    }

    Result<void> takeKey(const std::vector<std::string>& words) {
        if (flight_.keys.size() == kMostKeys)
            return bad("there are more than {} key frames; thin them out", kMostKeys);
        const bool looks = words.size() == 4 && words[2] == "look-at";
        if (words.size() != 3 && !looks)
            return bad("{} words are no key frame; {}", words.size(), kKeyForm);
        FlightKey key;
        key.line = line_;
        key.fovDeg = fov_;
        TERRAY_TRY(takeTime(words[0], key));
        TERRAY_TRY(takePlace(words[1], true, key.eye));
        if (looks) {
            key.target.emplace();
            TERRAY_TRY(takePlace(words[3], false, *key.target));
        } else {
            TERRAY_TRY(takeAngles(words[2], key));
        }
        flight_.keys.push_back(key);
        return {};
    }

    Result<void> takeTime(const std::string& word, FlightKey& key) const {
        constexpr double kMostSeconds = 1e6;
        if (word == "-") {
            if (flight_.speed || speedGiven_) return {};
            return bad("the time is missing; give seconds, or a 'speed' above the first key frame");
        }
        if (!readNumber(word, key.seconds) || std::abs(key.seconds) > kMostSeconds)
            return bad("'{}' is no time; give seconds, like 12.5", word);
        if (flight_.speed || speedGiven_ || flight_.keys.empty()) return {};
        const FlightKey& last = flight_.keys.back();
        if (key.seconds > last.seconds) return {};
        return bad("the time {} is not later than the {} of line {}; times must increase", word,
                   last.seconds, last.line);
    }

    Result<void> takePlace(const std::string& word, bool needsHeight, Place& place) const {
        const std::vector<std::string> parts = split(word, ",", true);
        const bool counts = parts.size() == 3 || (parts.size() == 2 && !needsHeight);
        if (!counts || !readNumber(parts[0], place.x) || !readNumber(parts[1], place.y))
            return bad(
                "'{}' is no place; give {}", word,
                needsHeight ? "X,Y,Z or X,Y,+H (H metres above the ground)" : "X,Y or X,Y,Z");
        if (parts.size() == 2) return {};
        double height = 0;
        if (!readNumber(parts[2], height) || std::abs(height) > 1e8)
            return bad("'{}' is no height; give metres, or +H for H metres above the ground",
                       parts[2]);
        place.z = height;
        place.aboveGround = parts[2][0] == '+';
        return {};
    }

    Result<void> takeAngles(const std::string& word, FlightKey& key) const {
        const std::vector<std::string> parts = split(word, ",", true);
        const bool counts = parts.size() == 2 || parts.size() == 3;
        if (!counts || !readNumber(parts[0], key.headingDeg) ||
            !readNumber(parts[1], key.pitchDeg) ||
            (parts.size() == 3 && !readNumber(parts[2], key.rollDeg)))
            return bad(
                "'{}' is no direction; give HEADING,PITCH[,ROLL] in degrees, or look-at "
                "X,Y[,Z]",
                word);
        if (key.headingDeg < -360 || key.headingDeg > 720)
            return bad("the heading {} is out of range; give -360 to 720", parts[0]);
        if (std::abs(key.pitchDeg) > 90)
            return bad("the pitch {} is out of range; give -90 (straight down) to 90", parts[1]);
        if (std::abs(key.rollDeg) > 360)
            return bad("the roll {} is out of range; give -360 to 360", parts[2]);
        return {};
    }

    FlightFile flight_;
    bool speedGiven_;
    int line_ = 0;
    std::optional<double> fov_;
    std::vector<std::string> seen_;
};

}  // namespace

Result<FlightFile> parseFlight(const std::string& text, const std::string& path, bool speedGiven) {
    FlightParser parser(path, speedGiven);
    std::string_view rest = text;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    while (!rest.empty()) {
        const size_t end = std::min(rest.find('\n'), rest.size());
        TERRAY_TRY(parser.take(rest.substr(0, end)));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return parser.finish();
}

Result<std::string> readFlightText(const std::string& path) {
    std::error_code problem;
    const std::filesystem::file_status status = std::filesystem::status(path, problem);
    if (!std::filesystem::exists(status))
        return makeError(ErrorCode::Input, "{}: there is no such flight file; check the path",
                         path);
    if (std::filesystem::is_directory(status))
        return makeError(ErrorCode::Input, "{}: a folder is no flight file; name a file", path);
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return makeError(ErrorCode::Input, "{}: cannot be read; check its permissions", path);
    std::string text(kMostFlightBytes + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (file.bad()) return makeError(ErrorCode::Input, "{}: reading it failed", path);
    text.resize(static_cast<size_t>(file.gcount()));
    if (text.size() > kMostFlightBytes)
        return makeError(ErrorCode::Input, "{}: {} MiB and more are no flight file", path,
                         kMostFlightBytes >> 20);
    if (text.find('\0') != std::string::npos)
        return makeError(ErrorCode::Input,
                         "{}: this is no text; give a flight file (docs/flights.md), GPX or KML",
                         path);
    return text;
}

}  // namespace terray
