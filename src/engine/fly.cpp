// SPDX-License-Identifier: Apache-2.0
// The loop of a flight: one view a frame, written while the next one is rendered.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <new>
#include <thread>

#include "base/interrupt.h"
#include "base/log.h"
#include "base/progress.h"
#include "base/stopwatch.h"
#include "engine/check.h"
#include "engine/flight_state.h"
#include "engine/fly_output.h"
#include "engine/terrain_state.h"
#include "terray/flight.h"
#include "terray/renderer.h"
#include "terray/version.h"

namespace terray {
namespace {

constexpr int64_t kMostFrames = 10'000'000;

/// Frames at even steps; the end is one of them where the flight lasts a whole number of steps.
Result<int64_t> countFrames(const FlightPath& path, double fps) {
    constexpr double kRounding = 1e-6;
    const double frames = std::floor((path.end() - path.begin()) * fps + kRounding) + 1;
    if (frames <= kMostFrames) return static_cast<int64_t>(frames);
    return makeError(ErrorCode::Usage,
                     "the flight lasts {:.0f} s, {:.0f} frames at --fps {:g}; make it shorter, or "
                     "faster with --speed",
                     path.end() - path.begin(), frames, fps);
}

std::string stateOfFile(const std::string& path) {
    std::error_code ignored;
    std::filesystem::path file = path;
    if (std::filesystem::is_directory(file, ignored)) file /= "terrain.json";
    const auto size = std::filesystem::file_size(file, ignored);
    const auto time = std::filesystem::last_write_time(file, ignored).time_since_epoch().count();
    return fmt::format("{} {} {}", path, ignored ? 0 : size, ignored ? 0 : time);
}

template <class... Values>
std::string listed(const Values&... values) {
    return (fmt::format("{}\n", values) + ...);
}

/// Everything that a film's pixels depend on, as text.
std::string fingerprintOf(const Terrain& terrain, const Flight::State& flight,
                          const RenderOptions& o, const FlyOptions& fly, int64_t first,
                          int64_t last) {
    const SourceInfo& info = terrain.info();
    const auto or0 = [](const std::optional<double>& v) { return v.value_or(-1); };
    const std::array<double, 2> sun = o.sunAzElDeg.value_or(std::array{-1.0, -1.0});
    const auto code = [](const auto& v) { return v ? static_cast<int>(*v) : -1; };
    return listed(version(), stateOfFile(info.source), info.workingCrsName, info.workingColumns,
                  info.workingRows, info.workingCellX, info.minHeight, info.maxHeight, info.photo,
                  stateOfFile(o.ramp), flight.fingerprint, flight.options.lonLat,
                  flight.options.fovDeg, or0(flight.options.speed),
                  or0(flight.options.heightAboveGround), flight.options.pitchDeg.value_or(-1000),
                  o.technique, o.samples, static_cast<int>(o.surface), o.tolerancePx,
                  code(o.curvature), o.refraction, o.exaggeration, code(o.shading), sun[0], sun[1],
                  o.shadows, or0(o.hazeKm), o.background, o.contoursM, o.legend, o.scaleBar,
                  o.northArrow, o.base, o.reliefOnPhotoPercent, fly.width, fly.height, fly.fps,
                  first, last);
}

/// One run over one terrain.
class FlyRun {
public:
    FlyRun(const Terrain& terrain, const FlightOver& flight, RenderOptions look,
           const FlyOptions& fly, FlyOutput& output)
        : terrain_(terrain), flight_(flight), look_(std::move(look)), fly_(fly), output_(output) {}

    Result<void> all(int64_t first, int64_t last) {
        Progress progress("flying", static_cast<double>(last - first + 1));
        for (int64_t frame = first; frame <= last; ++frame, progress.advance()) {
            if (output_.hasFrame(frame))
                ++report_.found;
            else
                TERRAY_TRY(make(frame));
        }
        TERRAY_TRY(awaitWrite());
        return output_.finish();
    }

    /// The clock starts with the first picture; then what is due now is made, or waited for.
    Result<void> inRealTime(int64_t first, int64_t last) {
        Progress progress("flying", static_cast<double>(last - first + 1));
        TERRAY_TRY(make(first));
        const Stopwatch clock;
        int64_t made = first;
        for (;;) {
            const double due = std::floor(clock.elapsedMs() * 1e-3 * fly_.fps);
            const int64_t frame = std::max(made + 1, first + static_cast<int64_t>(due));
            progress.advance(static_cast<double>(std::min(frame, last) - made));
            if (frame > last) break;
            TERRAY_TRY(waitUntil(clock, static_cast<double>(frame - first) / fly_.fps));
            report_.dropped += frame - made - 1;
            TERRAY_TRY(make(frame));
            made = frame;
        }
        report_.dropped += last - made;
        TERRAY_TRY(awaitWrite());
        // The last picture stands until the flight is over.
        const bool film = filmFormatOf(fly_.output).has_value();
        if (made < last && film) TERRAY_TRY(output_.write(last, pair_[turn_ ^ 1]));
        return output_.finish();
    }

    FlyReport& report() { return report_; }
    int64_t framesWithoutGround() const { return emptyFrames_; }

private:
    /// Renders a frame and leaves it to be written.
    Result<void> make(int64_t frame) {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        const double time = std::min(flight_.path().begin() + static_cast<double>(frame) / fly_.fps,
                                     flight_.path().end());
        const Stopwatch watch;
        auto view = flight_.viewAt(time);
        if (!view) return view.error();
        view->width = fly_.width;
        view->height = fly_.height;
        Band& picture = pair_[turn_];
        const std::optional<std::string> direct = output_.directPath(frame);
        auto stats = direct ? renderTo(*direct, *view) : renderInto(picture, *view);
        if (!stats) return atTime(stats.error(), time);
        record(frame, time, *view, *stats, watch.elapsedMs());
        if (direct) return {};
        TERRAY_TRY(awaitWrite());
        writing_ = std::async(std::launch::async,
                              [this, frame, &picture] { return timedWrite(frame, picture); });
        turn_ ^= 1;
        return {};
    }

    Result<RenderStats> renderInto(Band& picture, const View& view) {
        picture.rows = view.height;
        picture.display.resize(static_cast<size_t>(view.width) * static_cast<size_t>(view.height) *
                               4);
        return render(terrain_, view, look_, picture.display);
    }

    Result<RenderStats> renderTo(const std::string& path, const View& view) {
        OutputOptions outputs;
        outputs.path = path;
        outputs.jpegQuality = fly_.jpegQuality;
        return renderToFiles(terrain_, view, look_, outputs);
    }

    static Error atTime(const Error& error, double time) {
        if (error.code != ErrorCode::Usage) return error;
        return makeError(ErrorCode::Input, "at {:.2f} s of the flight: {}", time, error.message);
    }

    /// The figures of a frame are filled in here, and nowhere else.
    void record(int64_t frame, double time, const View& view, const RenderStats& stats, double ms) {
        FrameFigures figures;
        figures.frame = frame;
        figures.time = time;
        figures.eyeX = view.eye->x;
        figures.eyeY = view.eye->y;
        figures.eyeZ = view.eye->z.value_or(0);
        figures.frameMs = ms;
        figures.writeMs = stats.writeMs;
        figures.render = stats;
        emptyFrames_ += stats.hits == 0 ? 1 : 0;
        report_.frames.push_back(std::move(figures));
    }

    Result<double> timedWrite(int64_t frame, const Band& picture) {
        try {
            const Stopwatch watch;
            TERRAY_TRY(output_.write(frame, picture));
            return watch.elapsedMs();
        } catch (const std::bad_alloc&) {
            return makeError(ErrorCode::Resource, "the machine ran out of memory while writing");
        }
    }

    Result<void> awaitWrite() {
        if (!writing_.valid()) return {};
        auto written = writing_.get();
        if (!written) return written.error();
        report_.frames[written_].writeMs = *written;
        ++written_;
        return {};
    }

    static Result<void> waitUntil(const Stopwatch& clock, double seconds) {
        constexpr double kLook = 0.05;
        for (;;) {
            const double left = seconds - clock.elapsedMs() * 1e-3;
            if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
            if (left <= 0) return {};
            std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, kLook)));
        }
    }

    const Terrain& terrain_;
    const FlightOver& flight_;
    RenderOptions look_;
    FlyOptions fly_;
    FlyOutput& output_;
    FlyReport report_;
    int64_t emptyFrames_ = 0;
    Band pair_[2];
    int turn_ = 0;
    size_t written_ = 0;                   ///< frames of the report that are
    std::future<Result<double>> writing_;  ///< last: it ends before what it uses goes
};

Result<FlyPlan> makePlan(const Terrain& terrain, const Flight::State& flight,
                         const FlightOver& over, const RenderOptions& look, const FlyOptions& fly,
                         int64_t frames) {
    FlyPlan plan;
    plan.fly = fly;
    plan.last = frames - 1;
    if (fly.frames) {
        plan.first = (*fly.frames)[0];
        plan.last = (*fly.frames)[1];
        if (plan.last >= frames)
            return makeError(
                ErrorCode::Usage, "--frames {}-{}: the flight of {:.2f} s has the frames 0 to {}",
                plan.first, plan.last, over.path().end() - over.path().begin(), frames - 1);
    }
    plan.hasAlpha = look.background == "transparent";
    plan.source = terrain.info().source;
    plan.fingerprint = fingerprintOf(terrain, flight, look, fly, plan.first, plan.last);
    return plan;
}

Result<FlyReport> flyOver(const Terrain& terrain, const Flight& flight,
                          const RenderOptions& options, const FlyOptions& fly) {
    const Stopwatch watch;
    const log::SayOnce once;
    auto over = FlightOver::make(terrain.state(), flight.state(), options);
    if (!over) return over.error();
    auto look = settledLook(terrain.state(), *over, options);
    if (!look) return look.error();
    auto frames = countFrames(over->path(), fly.fps);
    if (!frames) return frames.error();
    auto plan = makePlan(terrain, flight.state(), *over, *look, fly, *frames);
    if (!plan) return plan.error();
    auto output = FlyOutput::begin(*plan);
    if (!output) return output.error();
    look->waitForTiles = !fly.realtime;
    FlyRun run(terrain, *over, *look, fly, **output);
    const Result<void> done =
        fly.realtime ? run.inRealTime(plan->first, plan->last) : run.all(plan->first, plan->last);
    if (!done && done.error().code == ErrorCode::Interrupted && !fly.realtime)
        return makeError(ErrorCode::Interrupted,
                         "interrupted; the same command with --resume goes on");
    if (!done) return done.error();
    FlyReport report = std::move(run.report());
    report.flightFrames = *frames;
    report.seconds = watch.elapsedMs() * 1e-3;
    if (run.framesWithoutGround() > 0)
        log::warning("{} of {} frames do not show the terrain; check the flight",
                     run.framesWithoutGround(), report.frames.size());
    return report;
}

}  // namespace

Result<void> checkFly(const RenderOptions& options, const FlyOptions& fly) {
    TERRAY_TRY(checkFlyOutput(fly, options.background == "transparent"));
    View view;
    view.width = fly.width;
    view.height = fly.height;
    TERRAY_TRY(checkOptions(view, options));
    OutputOptions outputs;
    outputs.path = fly.output;
    return checkOutputNames(options, outputs);
}

Result<FlyReport> fly(const Terrain& terrain, const Flight& flight, const RenderOptions& options,
                      const FlyOptions& fly) {
    try {
        TERRAY_TRY(checkFly(options, fly));
        return flyOver(terrain, flight, options, fly);
    } catch (const std::bad_alloc&) {
        return makeError(ErrorCode::Resource, "the machine ran out of memory while flying");
    } catch (const std::filesystem::filesystem_error& why) {
        return makeError(ErrorCode::Failed, "'{}': {}", fly.output, why.code().message());
    }
}

}  // namespace terray
