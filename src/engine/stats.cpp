// SPDX-License-Identifier: Apache-2.0
// Figures of a render as JSON.
#include "terray/stats.h"

#include <nlohmann/json.hpp>

namespace terray {

std::string toJson(const RenderStats& s) {
    nlohmann::ordered_json json{
        {"device", s.device},
        {"technique", s.technique},
        {"simd", s.simd},
        {"width", s.width},
        {"height", s.height},
        {"samples", s.samples},
        {"threads", s.threads},
        {"rays", s.rays},
        {"hits", s.hits},
        {"shadow_rays", s.shadowRays},
        {"redone", s.redone},
        {"column_rays", s.columnRays},
        {"beam_rays", s.beamRays},
        {"load_ms", s.loadMs},
        {"build_ms", s.buildMs},
        {"sky_ms", s.skyMs},
        {"setup_ms", s.setupMs},
        {"primary_ms", s.primaryMs},
        {"shade_ms", s.shadeMs},
        {"shadow_ms", s.shadowMs},
        {"display_ms", s.displayMs},
        {"write_ms", s.writeMs},
        {"total_ms", s.totalMs},
        {"mrays_per_s", s.mraysPerS},
        {"steps_per_ray", s.stepsPerRay},
        {"bytes_per_sample", s.bytesPerSample},
        {"resident_bytes", s.residentBytes},
        {"peak_rss_bytes", s.peakRssBytes},
        {"tolerance_px", s.tolerancePx},
        {"max_error_metres", s.maxErrorMetres},
        {"tiles_per_mip", s.tilesPerMip},
    };
    if (s.device.starts_with("vulkan")) {
        json["device_ms"] = s.deviceMs;
        json["device_upload_bytes"] = s.deviceUploadBytes;
    }
    if (s.onDemand) {
        json["tiles_wanted"] = s.tilesWanted;
        json["tiles_loaded"] = s.tilesLoaded;
        json["tiles_evicted"] = s.tilesEvicted;
        json["tiles_absent"] = s.tilesAbsent;
        json["tiles_late"] = s.tilesLate;
        json["missing_tile_pixels"] = s.missingTilePixels;
        json["tile_latency_ms"] = s.tileLatencyMs;
        json["tile_latency_p99_ms"] = s.tileLatencyP99Ms;
    }
    if (s.photoInBlocks) {
        json["photo_blocks_wanted"] = s.photoBlocksWanted;
        json["photo_blocks_loaded"] = s.photoBlocksLoaded;
        json["photo_blocks_evicted"] = s.photoBlocksEvicted;
        json["photo_blocks_absent"] = s.photoBlocksAbsent;
        json["photo_missing_pixels"] = s.photoMissingPixels;
    }
    if (s.onDemand || s.photoInBlocks) json["bytes_read"] = s.bytesRead;
    return json.dump(2);
}

}  // namespace terray
