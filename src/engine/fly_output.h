// SPDX-License-Identifier: Apache-2.0
// Where the frames of a flight go: a film, or a picture each.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/bands.h"
#include "film/film.h"
#include "terray/flight.h"

namespace terray {

/// frames/%05d.png: one number among other words.
struct FramePattern {
    std::string before, after;
    int digits = 0;  ///< at least so many, zeros in front

    /// Error Usage: a sentence for -o.
    static Result<FramePattern> parse(const std::string& text);
    std::string pathOf(int64_t frame) const;
};

/// What the frames are and where they go, settled before the first one. `first` is written as
/// number 0 of a film, and under its own number as a picture.
struct FlyPlan {
    FlyOptions fly;
    int64_t first = 0, last = 0;
    bool hasAlpha = false;
    std::string source;       ///< never written over
    std::string fingerprint;  ///< of all that frames depend on
};

/// hasFrame() may be called while write() runs; else confined.
class FlyOutput {
public:
    virtual ~FlyOutput() = default;
    static Result<std::unique_ptr<FlyOutput>> begin(const FlyPlan& plan);

    /// An earlier run has made it, and it is whole.
    virtual bool hasFrame(int64_t frame) const = 0;
    /// The picture is rendered straight to this file; nothing if write() takes pixels.
    virtual std::optional<std::string> directPath(int64_t) const { return std::nullopt; }
    /// A picture of one band. Frames in order.
    virtual Result<void> write(int64_t frame, const Band& picture) = 0;
    virtual Result<void> finish() = 0;
};

/// Usage and Failed errors that can be known without a terrain.
Result<void> checkFlyOutput(const FlyOptions& fly, bool hasAlpha);

}  // namespace terray
