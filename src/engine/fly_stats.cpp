// SPDX-License-Identifier: Apache-2.0
// Figures of a flight, frame by frame, as CSV and JSON.
#include <nlohmann/json.hpp>

#include "terray/flight.h"

namespace terray {
namespace {

using Json = nlohmann::ordered_json;

/// The row of a frame: new figures are added here, and appear in both formats. An array becomes as
/// many columns, numbered.
Json rowOf(const FrameFigures& f) {
    Json row = {
        {"frame", f.frame},
        {"time", f.time},
        {"eye_x", f.eyeX},
        {"eye_y", f.eyeY},
        {"eye_z", f.eyeZ},
        {"frame_ms", f.frameMs},
        {"setup_ms", f.render.setupMs},
        {"primary_ms", f.render.primaryMs},
        {"shade_ms", f.render.shadeMs},
        {"write_ms", f.writeMs},
        {"rays", f.render.rays},
        {"hits", f.render.hits},
        {"mrays_per_s", f.render.mraysPerS},
        {"steps_per_ray", f.render.stepsPerRay},
        {"peak_rss_bytes", f.render.peakRssBytes},
        {"tiles_mip", f.render.tilesPerMip},
    };
    if (f.render.onDemand) {
        row["tolerance_px"] = f.render.tolerancePx;
        row["tiles_wanted"] = f.render.tilesWanted;
        row["tiles_loaded"] = f.render.tilesLoaded;
        row["tiles_evicted"] = f.render.tilesEvicted;
        row["tiles_absent"] = f.render.tilesAbsent;
        row["tiles_late"] = f.render.tilesLate;
        row["missing_tile_pixels"] = f.render.missingTilePixels;
        row["tile_latency_ms"] = f.render.tileLatencyMs;
        row["tile_latency_p99_ms"] = f.render.tileLatencyP99Ms;
    }
    if (f.render.photoInBlocks) {
        row["photo_blocks_wanted"] = f.render.photoBlocksWanted;
        row["photo_blocks_loaded"] = f.render.photoBlocksLoaded;
        row["photo_blocks_evicted"] = f.render.photoBlocksEvicted;
        row["photo_blocks_absent"] = f.render.photoBlocksAbsent;
        row["photo_missing_pixels"] = f.render.photoMissingPixels;
    }
    if (f.render.onDemand || f.render.photoInBlocks) row["bytes_read"] = f.render.bytesRead;
    return row;
}

}  // namespace

std::string toCsv(const FlyReport& report) {
    std::string text;
    bool first = true;
    const Json header = rowOf(report.frames.empty() ? FrameFigures{} : report.frames.front());
    std::string names;
    for (const auto& [name, value] : header.items()) {
        if (!value.is_array()) names += (names.empty() ? "" : ",") + name;
        for (size_t k = 0; value.is_array() && k < value.size(); ++k)
            names += "," + name + std::to_string(k);
    }
    text = names + "\n";
    for (const FrameFigures& figures : report.frames) {
        first = true;
        for (const auto& value : rowOf(figures)) {
            const std::string one = value.dump();
            const std::string plain = value.is_array() ? one.substr(1, one.size() - 2) : one;
            if (value.is_array() && value.empty()) continue;
            text += (first ? "" : ",") + plain;
            first = false;
        }
        text += "\n";
    }
    return text;
}

std::string toJson(const FlyReport& report) {
    Json rows = Json::array();
    for (const FrameFigures& figures : report.frames) rows.push_back(rowOf(figures));
    Json json{
        {"flight_frames", report.flightFrames},
        {"made", report.frames.size()},
        {"found", report.found},
        {"dropped", report.dropped},
        {"seconds", report.seconds},
    };
    if (!report.frames.empty()) {
        const RenderStats& s = report.frames.front().render;
        json.update(Json{{"device", s.device},
                         {"technique", s.technique},
                         {"simd", s.simd},
                         {"width", s.width},
                         {"height", s.height},
                         {"samples", s.samples},
                         {"threads", s.threads},
                         {"load_ms", s.loadMs},
                         {"build_ms", s.buildMs},
                         {"resident_bytes", s.residentBytes},
                         {"tolerance_px", s.tolerancePx}});
    }
    json["frames"] = std::move(rows);
    return json.dump(1);
}

}  // namespace terray
