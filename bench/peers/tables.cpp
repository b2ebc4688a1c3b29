// SPDX-License-Identifier: Apache-2.0
// Markdown from JSON lines: a row a camera, a column a contender, ratios and geometric means.
#include "peers/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace terray::bench {
namespace {

using Lines = std::vector<nlohmann::json>;

std::string textOf(const nlohmann::json& line, const char* key) {
    return line.at(key).get<std::string>();
}

/// Values of a text field in the order of their first appearance.
std::vector<std::string> distinct(const Lines& lines, const char* key) {
    std::vector<std::string> values;
    for (const nlohmann::json& line : lines)
        if (std::find(values.begin(), values.end(), textOf(line, key)) == values.end())
            values.push_back(textOf(line, key));
    return values;
}

Lines select(const Lines& lines, const std::string& kind, std::optional<int> threads) {
    Lines chosen;
    for (const nlohmann::json& line : lines)
        if (textOf(line, "kind") == kind && (!threads || line.at("threads") == *threads))
            chosen.push_back(line);
    return chosen;
}

/// The cell of a table: one field of one contender at one camera.
std::optional<double> valueOf(const Lines& lines, const std::string& camera, const std::string& who,
                              const char* key) {
    for (const nlohmann::json& line : lines)
        if (textOf(line, "camera") == camera && textOf(line, "who") == who && line.contains(key))
            return line.at(key).get<double>();
    return std::nullopt;
}

/// Means over the six cameras of all figures; side cameras are told beside them.
bool countsInMeans(const std::string& camera) { return camera != "rolled" && camera != "outside"; }

struct Column {
    std::string title, who, against;  ///< against: a ratio of two contenders' speeds
    const char* key;
    int digits;
    double scale = 1;
    bool mean = true;
};

std::optional<double> cellOf(const Lines& lines, const std::string& camera, const Column& column) {
    const auto value = valueOf(lines, camera, column.who, column.key);
    if (!value) return std::nullopt;
    if (column.against.empty()) return *value * column.scale;
    const auto other = valueOf(lines, camera, column.against, column.key);
    return other && *other > 0 ? std::optional(*value / *other) : std::nullopt;
}

std::string tableOf(const Lines& lines, const std::vector<Column>& columns) {
    std::string text = "| camera |";
    for (const Column& column : columns) text += fmt::format(" {} |", column.title);
    text += "\n|---|";
    for (size_t k = 0; k < columns.size(); ++k) text += "---|";
    text += "\n";
    std::vector<double> logs(columns.size());
    std::vector<int> counts(columns.size());
    for (const std::string& camera : distinct(lines, "camera")) {
        text += fmt::format("| {} |", camera);
        for (size_t k = 0; k < columns.size(); ++k) {
            const auto cell = cellOf(lines, camera, columns[k]);
            text += cell ? fmt::format(" {:.{}f} |", *cell, columns[k].digits) : " |";
            if (!cell || *cell <= 0 || !countsInMeans(camera)) continue;
            logs[k] += std::log(*cell);
            ++counts[k];
        }
        text += "\n";
    }
    text += "| geometric mean of the six |";
    for (size_t k = 0; k < columns.size(); ++k)
        text += columns[k].mean && counts[k] > 0
                    ? fmt::format(" {:.{}f} |", std::exp(logs[k] / counts[k]), columns[k].digits)
                    : " |";
    return text + "\n";
}

std::string speedTable(const Lines& lines, bool primary) {
    std::vector<Column> columns;
    for (const std::string& who : distinct(lines, "who"))
        columns.push_back({who, who, "", "mrays_per_s", who == "oracle" ? 3 : 1});
    const std::string ours = columns.front().who;
    for (const std::string& who : distinct(lines, "who"))
        if (who.find("i16") != std::string::npos || who.find("o16") != std::string::npos)
            columns.push_back({fmt::format("{} / {}", ours, who), ours, who, "mrays_per_cpu_s", 2});
    if (primary) {
        columns.push_back({"steps a ray", ours, "", "steps_per_ray", 2});
        columns.push_back({"redone %", ours, "", "redone_share", 3, 100, false});
        columns.push_back({"> 0.1 m %", ours, "", "far_share", 4, 100, false});
        columns.push_back({"hit or miss %", ours, "", "flip_share", 4, 100, false});
    } else {
        columns.push_back({"different %", ours, "", "different_share", 3, 100, false});
    }
    return tableOf(lines, columns);
}

std::string buildTable(const Lines& lines) {
    std::string text =
        "| structure | threads | build, ms | MiB | peak MiB | bytes a post |\n"
        "|---|---|---|---|---|---|\n";
    for (const nlohmann::json& line : lines) {
        const auto mib = [&](const char* key) {
            return line.contains(key) ? fmt::format("{:.1f}", line.at(key).get<double>() / 1048576)
                                      : std::string();
        };
        text += fmt::format("| {} | {} | {:.1f} | {} | {} | {} |\n", textOf(line, "who"),
                            line.at("threads").get<int>(), line.at("ms").get<double>(),
                            mib("bytes"), mib("peak_bytes"),
                            line.contains("bytes_per_post")
                                ? fmt::format("{:.2f}", line.at("bytes_per_post").get<double>())
                                : std::string());
    }
    return text;
}

}  // namespace

std::string markdownTables(const Lines& lines) {
    if (lines.empty()) return "";
    std::string text = fmt::format("{}, {} surface\n\n", textOf(lines.front(), "terrain"),
                                   textOf(lines.front(), "surface"));
    text += buildTable(select(lines, "build", std::nullopt));
    std::vector<int> threadCounts;
    for (const nlohmann::json& line : select(lines, "primary", std::nullopt))
        if (const int n = line.at("threads");
            std::find(threadCounts.begin(), threadCounts.end(), n) == threadCounts.end())
            threadCounts.push_back(n);
    for (const int threads : threadCounts) {
        const std::string of = fmt::format("{} thread{}", threads, threads == 1 ? "" : "s");
        text += fmt::format("\nPrimary rays, {}: M rays/s; ratios of processor time\n\n{}", of,
                            speedTable(select(lines, "primary", threads), true));
        text += fmt::format("\nShadow rays, {}: M rays/s; ratios of processor time\n\n{}", of,
                            speedTable(select(lines, "shadow", threads), false));
    }
    return text;
}

}  // namespace terray::bench
