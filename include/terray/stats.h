// SPDX-License-Identifier: Apache-2.0
// Figures of a finished render, as written by --stats.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "terray/export.h"

namespace terray {

struct RenderStats {
    std::string device, technique, simd;
    int width = 0, height = 0, samples = 0, threads = 0;
    uint64_t rays = 0, hits = 0;          ///< primary rays
    uint64_t shadowRays = 0, redone = 0;  ///< redone: traced again in double precision
    uint64_t columnRays = 0;              ///< of rays: began where the row below had hit
    uint64_t beamRays = 0;                ///< of rays: began where a bundle of rays ended
    double loadMs = 0;                    ///< reading the source (warp included)
    double buildMs = 0;                   ///< coarser mips, bounds, errors
    double skyMs = 0;                     ///< sky-light sweeps
    double setupMs = 0;  ///< before the first ray: camera, cut, shader (skyMs is in it)
    double primaryMs = 0, shadeMs = 0, writeMs = 0, totalMs = 0;
    double deviceMs = 0;             ///< of primaryMs: by the device's own clock; 0 on the CPU
    uint64_t deviceUploadBytes = 0;  ///< tiles and tables that this picture brought to the device
    double shadowMs = 0, displayMs = 0;  ///< parts of shadeMs: shadow rays; sums to 8 bits
    double mraysPerS = 0;                ///< primary rays over primary time
    double stepsPerRay = 0;
    double bytesPerSample = 0;  ///< resident terrain over samples of mip 0
    uint64_t residentBytes = 0, peakRssBytes = 0;
    double tolerancePx = 0;  ///< as drawn: memory may not allow what was asked for
    double maxErrorMetres = 0;
    std::vector<uint64_t> tilesPerMip;  ///< drawn tiles
    bool onDemand = false;              ///< not all tiles are resident; else the next are 0
    uint64_t tilesWanted = 0, tilesLoaded = 0, tilesEvicted = 0;
    uint64_t tilesAbsent = 0;        ///< wanted, but on their way or unreadable
    uint64_t tilesLate = 0;          ///< drawn in place of finer ones that were not there
    uint64_t missingTilePixels = 0;  ///< hits that miss the tolerance for want of a finer tile
    double tileLatencyMs = 0, tileLatencyP99Ms = 0;  ///< request to resident, since the opening
    bool photoInBlocks = false;                      ///< of a store; else the next are 0
    uint64_t photoBlocksWanted = 0, photoBlocksLoaded = 0, photoBlocksEvicted = 0;
    uint64_t photoBlocksAbsent = 0;   ///< wanted, but on their way or unreadable
    uint64_t photoMissingPixels = 0;  ///< hits that show a coarser block for want of a finer one
    uint64_t bytesRead = 0;           ///< of a store's files: tiles and blocks
};

/// One JSON object with snake_case keys (device, technique, primary_ms, ...).
TERRAY_API std::string toJson(const RenderStats& stats);

}  // namespace terray
