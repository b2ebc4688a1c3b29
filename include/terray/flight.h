// SPDX-License-Identifier: Apache-2.0
// Flights: a camera that moves, as a film or as numbered pictures.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "terray/export.h"
#include "terray/options.h"
#include "terray/result.h"
#include "terray/stats.h"
#include "terray/terrain.h"
#include "terray/view.h"

namespace terray {

/// What a flight file does not say, or is told otherwise.
struct FlightOptions {
    bool lonLat = false;                      ///< X, Y of key frames are degrees
    double fovDeg = 45;                       ///< until the file says another
    std::optional<double> speed;              ///< metres a second, constant
    std::optional<double> heightAboveGround;  ///< tracks only; default 200 m
    std::optional<double> pitchDeg;           ///< tracks only; default -10
};

/// A flight as read; it meets a terrain in fly(). Cheap to copy. const-shared.
class TERRAY_API Flight {
public:
    /// A flight file (key frames), GPX or KML (one track). Errors: Input (named with file and
    /// line), Usage (options that this kind of flight has no use for).
    static Result<Flight> read(const std::string& path, const FlightOptions& options = {});

    struct State;
    const State& state() const { return *state_; }

private:
    explicit Flight(std::shared_ptr<const State> state) : state_(std::move(state)) {}
    std::shared_ptr<const State> state_;
};

struct FlyOptions {
    /// .mp4 or .webm, or a pattern for pictures like frames/%05d.png (.jpg, .exr, .tif).
    std::string output;
    int width = 1920, height = 1080;  ///< pixels; even for films
    double fps = 30;
    std::optional<std::array<int64_t, 2>> frames;  ///< first and last to make; the first is 0
    bool resume = false;                           ///< go on where an earlier run stopped
    bool realtime = false;  ///< drop frames that a viewer would not have in time
    int jpegQuality = 92;
};

/// Figures of one frame.
struct FrameFigures {
    int64_t frame = 0;
    double time = 0;                      ///< seconds, of the flight
    double eyeX = 0, eyeY = 0, eyeZ = 0;  ///< data's CRS, metres
    double frameMs = 0;                   ///< from its begin to its last pixel
    double writeMs = 0;                   ///< encoding and writing, beside the next frame
    RenderStats render;
};

struct FlyReport {
    std::vector<FrameFigures> frames;  ///< those made in this run
    int64_t flightFrames = 0;          ///< of the whole flight
    int64_t found = 0;                 ///< made by an earlier run
    int64_t dropped = 0;               ///< not in time
    double seconds = 0;                ///< this run took
};

/// Finds out early, before a terrain is opened, what fly() would refuse.
TERRAY_API Result<void> checkFly(const RenderOptions& options, const FlyOptions& fly);

/// Makes the film or the pictures. What a still derives from its view (sun, haze) is settled once
/// for the flight, and said in notes. Errors: Usage, Input, Failed, Resource, Interrupted; pieces
/// of a film and pictures that are whole stay for `resume`.
TERRAY_API Result<FlyReport> fly(const Terrain& terrain, const Flight& flight,
                                 const RenderOptions& options, const FlyOptions& fly);

/// The camera of a moment, for render().
TERRAY_API Result<View> viewAt(const Terrain& terrain, const Flight& flight,
                               const RenderOptions& options, double seconds);

/// A header line and a line a frame; an object with totals and an array of frames.
TERRAY_API std::string toCsv(const FlyReport& report);
TERRAY_API std::string toJson(const FlyReport& report);

}  // namespace terray
