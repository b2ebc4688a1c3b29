// SPDX-License-Identifier: Apache-2.0
// A terrain whose tiles come and go, as the measurements draw it: cameras above its ground, frames
// that wait for their tiles.
#pragma once

#include <memory>

#include "measure.h"
#include "terabyte_source.h"

namespace terray::bench {

struct StreamedScene {
    std::unique_ptr<ResidentTerrain> terrain;
    const TerabyteSource* source = nullptr;  ///< the terrain's own
    double startMs = 0;                      ///< until the first frame can be asked for
    double bend = 0;
};
/// Ground of width x height metres with posts 2^finestMip metres apart, in at most that much
/// memory.
Result<StreamedScene> openStreamed(int64_t width, int64_t height, int finestMip, bool isBare,
                                   uint64_t memoryBytes);

/// World metres; what stands on the ground counts.
double groundHeight(const TerabyteSource& source, double x, double y);

/// Looks along a heading from `above` metres over the ground; the horizontal field is 60 degrees.
struct Standpoint {
    double x = 0, y = 0, above = 0, headingDeg = 0, pitchDeg = 0;
};
Camera cameraAt(const TerabyteSource& source, const Standpoint& from, int width, int height);

struct StreamedFrame {
    FrameCut cut;
    double tolerancePx = 0;  ///< the one that fits into memory
    size_t wanted = 0;
    double bringMs = 0;
};
/// The frame with all its tiles, those that shading reads included if it is asked for. Error Input
/// where they do not fit even at 16 times the tolerance.
Result<StreamedFrame> bringFrame(const StreamedScene& scene, const Camera& camera,
                                 double tolerancePx, bool isShaded);

}  // namespace terray::bench
