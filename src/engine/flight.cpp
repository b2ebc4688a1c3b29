// SPDX-License-Identifier: Apache-2.0
// Reading flights, and placing them in a terrain's world.
#include "terray/flight.h"

#include <algorithm>
#include <cmath>

#include "base/interrupt.h"
#include "base/log.h"
#include "engine/flight_state.h"
#include "engine/frame.h"
#include "flight/follow.h"
#include "flight/key_path.h"
#include "flight/track_path.h"

namespace terray {
namespace {

constexpr double kDefaultHeight = 200, kDefaultPitchDeg = -10;

Result<void> checkOptions(const FlightOptions& o) {
    const auto within = [](const char* option, std::optional<double> value, double low,
                           double high) -> Result<void> {
        if (!value || (std::isfinite(*value) && *value >= low && *value <= high)) return {};
        return makeError(ErrorCode::Usage, "{}: {} is out of range; give {:g} to {:g}", option,
                         *value, low, high);
    };
    TERRAY_TRY(within("--fov", o.fovDeg, 0.01, 179));
    TERRAY_TRY(within("--speed", o.speed, 0.001, 1e6));
    TERRAY_TRY(within("--height-above-ground", o.heightAboveGround, 0.1, 1e6));
    return within("--pitch", o.pitchDeg, -90, 90);
}

/// FNV-1a: names a content, guards nothing.
std::string fingerprintOf(const std::string& text) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    return fmt::format("{:016x}", hash);
}

Result<void> readTrackInto(Flight::State& state) {
    if (state.options.lonLat)
        return makeError(ErrorCode::Usage,
                         "--lonlat is for key frames; '{}' is a track, whose places are degrees "
                         "anyway: leave it out",
                         state.path);
    auto track = readTrack(state.path);
    if (!track) return track.error();
    if (track->seconds.empty() && !state.options.speed)
        return makeError(ErrorCode::Usage, "'{}' has no times; give --speed in metres a second",
                         state.path);
    state.fingerprint = fingerprintOf(fmt::format("{} {}", track->lonLats.size(), state.path));
    for (const Vec2& p : track->lonLats)
        state.fingerprint = fingerprintOf(fmt::format("{} {} {}", state.fingerprint, p.x, p.y));
    state.content = std::move(*track);
    return {};
}

Result<void> readKeysInto(Flight::State& state) {
    if (state.options.heightAboveGround || state.options.pitchDeg)
        return makeError(
            ErrorCode::Usage,
            "--height-above-ground and --pitch are for tracks (GPX, KML); in '{}' each "
            "key frame has its own: leave them out",
            state.path);
    auto text = readFlightText(state.path);
    if (!text) return text.error();
    auto file = parseFlight(*text, state.path, state.options.speed.has_value());
    if (!file) return file.error();
    state.fingerprint = fingerprintOf(*text);
    state.content = std::move(*file);
    return {};
}

double cellMetres(const Terrain::State& state) {
    const Affine2& map = state.resident->info().worldFromLattice;
    return std::min(map.columnLength(), map.rowLength());
}

Error asInput(const Error& error) {
    return Error{error.code == ErrorCode::Usage ? ErrorCode::Input : error.code, error.message};
}

/// Key frames to world places and directions.
class KeyPlacer {
public:
    KeyPlacer(const Terrain::State& state, const FlightFile& file, const PlaceResolver& places,
              const RenderOptions& options, bool lonLat)
        : state_(state), file_(file), places_(places), options_(options), lonLat_(lonLat) {}

    Result<void> openCrs() {
        if (file_.crs.empty()) return {};
        if (!places_.frame().hasCrs())
            return makeError(ErrorCode::Usage,
                             "{}: 'crs' needs a terrain whose CRS is known; name it with "
                             "--assign-crs EPSG:n",
                             file_.path);
        auto own = GeoFrame::make(file_.crs, state_.resident->info().crsWkt);
        if (!own)
            return makeError(ErrorCode::Input, "{}: crs: {}", file_.path, own.error().message);
        own_ = std::move(*own);
        return {};
    }

    Result<PathKey> place(const FlightKey& key, double fovDeg) const {
        PathKey placed;
        placed.name = fmt::format("{}:{}", file_.path, key.line);
        placed.seconds = key.seconds;
        placed.fovDeg = key.fovDeg.value_or(fovDeg);
        auto eye = worldPoint(key.eye, placed.name);
        if (!eye) return eye.error();
        placed.eye = *eye;
        placed.headingDeg = key.headingDeg;
        placed.pitchDeg = key.pitchDeg;
        placed.rollDeg = key.rollDeg;
        if (!key.target) return placed;
        auto target = worldPoint(*key.target, placed.name);
        if (!target) return target.error();
        placed.target = *target;
        TERRAY_TRY(aim(placed));
        return placed;
    }

private:
    Result<WorldPoint> worldPoint(const Place& place, const std::string& name) const {
        if (!own_) {
            auto point = places_.resolve(place, name);
            if (!point) return asInput(point.error());
            return point;
        }
        auto world = own_->worldFromData({place.x, place.y});
        if (!world) return makeError(ErrorCode::Input, "{}: {}", name, world.error().message);
        if (place.z && !place.aboveGround) return WorldPoint{world->x, world->y, *place.z};
        const std::optional<double> ground = places_.groundHeight(*world);
        if (ground) return WorldPoint{world->x, world->y, *ground + place.z.value_or(0)};
        return makeError(ErrorCode::Input,
                         "{}: there is no ground at {}, {} to count the height from (outside, or a "
                         "hole); give an absolute Z in metres",
                         name, place.x, place.y);
    }

    /// The direction to the target, as a still would have it.
    Result<void> aim(PathKey& key) const {
        const auto data = [&](const WorldPoint& p) -> Result<Place> {
            auto xy = places_.dataFromWorld({p.x, p.y});
            if (!xy) return asInput(xy.error());
            return Place{xy->x, xy->y, p.z, false};
        };
        auto eye = data(key.eye);
        if (!eye) return eye.error();
        auto target = data(*key.target);
        if (!target) return target.error();
        View view;
        view.lonLat = lonLat_;
        view.eye = *eye;
        view.lookAt = *target;
        auto placed = placeView(state_, view, options_);
        if (!placed) return makeError(ErrorCode::Input, "{}: {}", key.name, placed.error().message);
        const Vec3& forward = placed->camera.forward;
        key.headingDeg = normalHeadingDeg(degFromRad(placed->camera.heading));
        key.pitchDeg = degFromRad(std::asin(std::clamp(forward.z, -1.0, 1.0)));
        return {};
    }

    const Terrain::State& state_;
    const FlightFile& file_;
    const PlaceResolver& places_;
    const RenderOptions& options_;
    bool lonLat_;  ///< what places_ takes
    std::optional<GeoFrame> own_;
};

Result<std::unique_ptr<FlightPath>> placeKeys(const Terrain::State& state, const FlightFile& file,
                                              const FlightOptions& flight,
                                              const PlaceResolver& places,
                                              const RenderOptions& options, bool lonLat) {
    KeyPlacer placer(state, file, places, options, lonLat);
    TERRAY_TRY(placer.openCrs());
    std::vector<PathKey> keys;
    for (const FlightKey& key : file.keys) {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        auto placed = placer.place(key, flight.fovDeg);
        if (!placed) return placed.error();
        keys.push_back(std::move(*placed));
    }
    KeyPathOptions path;
    path.speed = flight.speed ? flight.speed : file.speed;
    path.clearance = file.clearance;
    path.ground = [&places](Vec2 p) { return places.groundHeight(p); };
    path.spacing = cellMetres(state);
    return makeKeyPath(std::move(keys), path);
}

Result<std::unique_ptr<FlightPath>> placeTrack(const Terrain::State& state, const Track& track,
                                               const Flight::State& flight,
                                               const PlaceResolver& places) {
    if (!places.frame().hasCrs())
        return makeError(ErrorCode::Usage,
                         "'{}': a track is in degrees, and the terrain has no CRS; name it with "
                         "--assign-crs EPSG:n",
                         flight.path);
    auto degrees = GeoFrame::make("EPSG:4326", state.resident->info().crsWkt);
    if (!degrees) return degrees.error();
    std::vector<Vec2> world;
    int64_t outside = 0;
    for (const Vec2& lonLat : track.lonLats) {
        auto place = degrees->worldFromData(lonLat);
        if (!place)
            return makeError(ErrorCode::Input, "'{}': {}", flight.path, place.error().message);
        outside += places.groundHeight(*place) ? 0 : 1;
        world.push_back(*place);
    }
    if (outside > 0 && outside < static_cast<int64_t>(world.size()))
        log::warning(
            "{} of the track's {} points lie outside the terrain or over holes; the height "
            "of the nearest ground on the way counts there",
            outside, world.size());
    TrackPathOptions path;
    path.speed = flight.options.speed;
    path.heightAboveGround = flight.options.heightAboveGround.value_or(kDefaultHeight);
    path.pitchDeg = flight.options.pitchDeg.value_or(kDefaultPitchDeg);
    path.fovDeg = flight.options.fovDeg;
    path.spacing = cellMetres(state);
    if (!flight.options.heightAboveGround)
        log::note("flying {:g} m above the ground (--height-above-ground)", path.heightAboveGround);
    return makeTrackPath(
        world, track.seconds, [&places](Vec2 p) { return places.groundHeight(p); }, path,
        flight.path);
}

/// Nobody wants to fly through rock; a few looks a second find it.
void warnUnderground(const FlightPath& path, const PlaceResolver& places) {
    const Moments moments = momentsOf(path.begin(), path.end());
    double deepest = 0, when = 0;
    for (size_t k = 0; k < moments.count; ++k) {
        const Pose pose = path.at(moments.at(k));
        const auto ground = places.groundHeight({pose.eye.x, pose.eye.y});
        if (!ground || *ground - pose.eye.z <= deepest) continue;
        deepest = *ground - pose.eye.z;
        when = moments.at(k);
    }
    if (deepest > 0)
        log::warning(
            "the flight is underground, deepest by {:.0f} m at {:.1f} s; add a key frame "
            "there, or 'clearance' to the flight file",
            std::ceil(deepest), when);
}

}  // namespace

Result<Flight> Flight::read(const std::string& path, const FlightOptions& options) {
    TERRAY_TRY(checkOptions(options));
    auto state = std::make_shared<State>();
    state->path = path;
    state->options = options;
    TERRAY_TRY(looksLikeTrack(path) ? readTrackInto(*state) : readKeysInto(*state));
    return Flight(std::move(state));
}

Result<FlightOver> FlightOver::make(const Terrain::State& state, const Flight::State& flight,
                                    const RenderOptions& options) {
    const auto* file = std::get_if<FlightFile>(&flight.content);
    const bool lonLat = file && (file->lonLat || (flight.options.lonLat && file->crs.empty()));
    auto places = PlaceResolver::make(state, lonLat, options.surface);
    if (!places) return places.error();
    auto path = file ? placeKeys(state, *file, flight.options, *places, options, lonLat)
                     : placeTrack(state, std::get<Track>(flight.content), flight, *places);
    if (!path) return path.error();
    warnUnderground(**path, *places);
    auto dataPlaces = PlaceResolver::make(state, false, options.surface);
    if (!dataPlaces) return dataPlaces.error();
    return FlightOver(std::move(*dataPlaces), std::move(*path));
}

Result<View> FlightOver::viewAt(double seconds) const {
    const Pose pose = path_->at(seconds);
    const auto place = [&](const WorldPoint& p) -> Result<Place> {
        auto xy = places_.dataFromWorld({p.x, p.y});
        if (!xy) return asInput(xy.error());
        return Place{xy->x, xy->y, p.z, false};
    };
    View view;
    auto eye = place(pose.eye);
    if (!eye) return eye.error();
    view.eye = *eye;
    view.rollDeg = pose.rollDeg;
    view.fovDeg = pose.fovDeg;
    if (!pose.target) {
        view.headingDeg = pose.headingDeg;
        view.pitchDeg = pose.pitchDeg;
        return view;
    }
    auto target = place(*pose.target);
    if (!target) return target.error();
    view.lookAt = *target;
    return view;
}

Result<View> viewAt(const Terrain& terrain, const Flight& flight, const RenderOptions& options,
                    double seconds) {
    auto over = FlightOver::make(terrain.state(), flight.state(), options);
    if (!over) return over.error();
    return over->viewAt(seconds);
}

}  // namespace terray
