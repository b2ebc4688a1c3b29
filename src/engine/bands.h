// SPDX-License-Identifier: Apache-2.0
// A picture made band by band, on all cores: memory does not grow with the picture.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/frame.h"

namespace terray {

/// Rows [firstRow, firstRow + rows) of everything that was asked for.
struct Band {
    int firstRow = 0, rows = 0;
    std::vector<Colour> linear;            ///< one a pixel, if asked for
    std::vector<uint8_t> display;          ///< four a pixel, straight alpha, if asked for
    std::vector<std::vector<float>> aovs;  ///< aovChannels() a pixel, in the order asked for
};

struct BandDemand {
    bool linear = false, display = true;
    std::vector<Aov> aovs;
    bool picture() const { return linear || display; }
};

/// Work done by all threads, milliseconds of CPU time summed over threads.
struct BandFigures {
    TraceCounters trace;
    ShadeCounters shade;
    double traceMs = 0, shadeMs = 0;  ///< shadeMs with shadows and display
    double displayMs = 0;
    DeviceFigures device;     ///< castMs is wall-clock time, in addition to traceMs
    bool lostDevice = false;  ///< the CPU went on
    uint64_t lateHits = 0;    ///< that miss the tolerance for want of a finer tile
};

/// Makes the bands from the top and hands each to `sink`, which runs beside the next band's work.
/// Error: the sink's, the device's, or Interrupted.
Result<BandFigures> renderBands(const Frame& frame, const BandDemand& demand,
                                const std::function<Result<void>(const Band&)>& sink);

/// Rows of a band of such a picture: at most 256 rows and, where that leaves one, 32 MiB (two
/// bands are alive at a time).
int bandRows(int width, const BandDemand& demand);

}  // namespace terray
