// SPDX-License-Identifier: Apache-2.0
// Wording of `terray info`.
#include "info_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "terray/process.h"

namespace terray::cli {
namespace {

class Lines {
public:
    void add(const std::string& name, const std::string& value) {
        if (!value.empty()) text_ += fmt::format("{:<14}{}\n", name, value);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

double widthMetres(const SourceInfo& info) {
    return std::max(static_cast<double>(info.workingColumns - 1) * info.workingCellX,
                    static_cast<double>(info.workingRows - 1) * info.workingCellY);
}

std::string lengthText(double metres) {
    if (metres >= 1000) return fmt::format("{:.4g} km", metres / 1000);
    return fmt::format("{:.4g} m", metres);
}

std::string rangeText(const SourceInfo& info) {
    if (!info.hasRange) return "not scanned";
    if (info.minHeight > info.maxHeight) return "no sample has a height";
    return fmt::format("{:.2f} to {:.2f} m", info.minHeight, info.maxHeight);
}

std::string holesText(const SourceInfo& info) {
    if (!info.hasRange) return {};
    const double all = static_cast<double>(info.columns) * static_cast<double>(info.rows);
    return fmt::format("{} samples ({:.2f} %)", info.holes,
                       100 * static_cast<double>(info.holes) / all);
}

std::string heightsText(const SourceInfo& info) {
    std::string text = info.heightUnit;
    if (info.scale != 1 || info.offset != 0)
        text += fmt::format(", scale {:g}, offset {:g}", info.scale, info.offset);
    return text;
}

std::string pixelText(const SourceInfo& info) {
    return fmt::format("{:.10g} x {:.10g} {}, value at the {}", info.pixelWidth, info.pixelHeight,
                       info.horizontalUnit.empty() ? "units" : info.horizontalUnit,
                       info.pixelIsPoint ? "point (pixel-is-point)" : "pixel's centre");
}

std::string originText(const SourceInfo& info) {
    if (info.geoTransform.size() != 6) return "none";
    const auto& g = info.geoTransform;
    std::string text = fmt::format("{:.10g}, {:.10g}", g[0], g[3]);
    if (g[2] != 0 || g[4] != 0)
        text += " (rotated)";
    else if (g[5] > 0)
        text += " (south up)";
    return text;
}

}  // namespace

std::string bytesText(uint64_t bytes) {
    const double value = static_cast<double>(bytes);
    if (value >= 1073741824.0) return fmt::format("{:.1f} GiB", value / 1073741824.0);
    if (value >= 1048576.0) return fmt::format("{:.1f} MiB", value / 1048576.0);
    return fmt::format("{:.1f} KiB", value / 1024.0);
}

void sayAssumptions(const SourceInfo& info) {
    for (const Assumption& assumption : info.assumptions) {
        if (assumption.isWarning)
            writeWarning(assumption.text);
        else
            writeNote(assumption.text);
    }
    if (!info.photo.empty()) writeNote("photo " + info.photo);
}

double reliefPercent(const SourceInfo& info) {
    const double width = widthMetres(info);
    return width > 0 ? 100 * (info.maxHeight - info.minHeight) / width : 0;
}

std::optional<double> suggestedExaggeration(const SourceInfo& info) {
    const double percent = reliefPercent(info);
    if (!info.hasRange || !(percent > 0) || percent >= 2) return std::nullopt;
    constexpr double kWanted = 5;  // percent of the width
    for (const double factor : {2.0, 3.0, 5.0, 10.0, 20.0, 50.0})
        if (percent * factor >= kWanted || factor == 50.0) return factor;
    return std::nullopt;
}

std::string infoText(const SourceInfo& info) {
    Lines lines;
    lines.add("Source", info.source);
    lines.add("Format", fmt::format("{}, {} band{}, {}", info.driver, info.bands,
                                    info.bands == 1 ? "" : "s", info.sampleType));
    lines.add("Size", fmt::format("{} x {} samples", info.columns, info.rows));
    lines.add("CRS", info.crsName.empty() ? "none" : info.crsName);
    lines.add("Origin", originText(info));
    lines.add("Pixel", pixelText(info));
    lines.add("Heights in", heightsText(info));
    lines.add("Nodata", info.nodataRule);
    lines.add("Range", rangeText(info));
    lines.add("Holes", holesText(info));
    lines.add("Works in", (info.workingCrsName.empty() ? "metres, no CRS" : info.workingCrsName) +
                              (info.warped ? " (warped)" : ""));
    lines.add("Lattice", fmt::format("{} x {} posts, {:.6g} x {:.6g} m, {} mip{}",
                                     info.workingColumns, info.workingRows, info.workingCellX,
                                     info.workingCellY, info.mips, info.mips == 1 ? "" : "s"));
    lines.add(
        "Extent",
        fmt::format("{} x {}",
                    lengthText(static_cast<double>(info.workingColumns - 1) * info.workingCellX),
                    lengthText(static_cast<double>(info.workingRows - 1) * info.workingCellY)));
    lines.add("Memory", fmt::format("{} to render ({} posts)", bytesText(info.residentBytes),
                                    info.postFormat));
    lines.add("Photo", info.photo);
    for (const Assumption& assumption : info.assumptions) lines.add("Assumed", assumption.text);
    if (const auto factor = suggestedExaggeration(info))
        lines.add("Suggestion",
                  fmt::format("the relief is only {:.2f} % of the width: try --exaggeration {:g}",
                              reliefPercent(info), *factor));
    return lines.take();
}

std::string infoJson(const SourceInfo& info) {
    using nlohmann::ordered_json;
    ordered_json json{
        {"source", info.source},
        {"driver", info.driver},
        {"columns", info.columns},
        {"rows", info.rows},
        {"bands", info.bands},
        {"sample_type", info.sampleType},
        {"crs_name", info.crsName},
        {"crs_wkt", info.crsWkt},
        {"geo_transform", info.geoTransform},
        {"pixel_width", info.pixelWidth},
        {"pixel_height", info.pixelHeight},
        {"horizontal_unit", info.horizontalUnit},
        {"pixel_is_point", info.pixelIsPoint},
        {"nodata_rule", info.nodataRule},
        {"height_unit", info.heightUnit},
        {"scale", info.scale},
        {"offset", info.offset},
        {"warped", info.warped},
        {"working_crs_name", info.workingCrsName},
        {"working_columns", info.workingColumns},
        {"working_rows", info.workingRows},
        {"working_cell_x", info.workingCellX},
        {"working_cell_y", info.workingCellY},
        {"mips", info.mips},
        {"post_format", info.postFormat},
        {"resident_bytes", info.residentBytes},
        {"photo", info.photo},
        {"assumptions", ordered_json::array()},
    };
    for (const Assumption& assumption : info.assumptions)
        json["assumptions"].push_back(assumption.text);
    const bool range = info.hasRange && info.minHeight <= info.maxHeight;
    json["min_height"] = range ? ordered_json(info.minHeight) : ordered_json();
    json["max_height"] = range ? ordered_json(info.maxHeight) : ordered_json();
    json["holes"] = info.hasRange ? ordered_json(info.holes) : ordered_json();
    const auto factor = suggestedExaggeration(info);
    json["suggested_exaggeration"] = factor ? ordered_json(*factor) : ordered_json();
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace terray::cli
