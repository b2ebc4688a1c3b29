// SPDX-License-Identifier: Apache-2.0
// Smoothing a track into a flight.
#include "flight/track_path.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"
#include "flight/follow.h"
#include "flight/smooth.h"
#include "flight/spline.h"

namespace terray {
namespace {

/// Seconds to either side over which things are smoothed.
constexpr double kWaySeconds = 2, kHeadingSeconds = 3, kHeightSeconds = 4;
constexpr double kAheadSeconds = 2;  ///< the camera looks at where it will be then

/// Metres from the first place along straight pieces.
std::vector<double> metresAlong(const std::vector<Vec2>& places) {
    std::vector<double> metres{0};
    for (size_t k = 1; k < places.size(); ++k)
        metres.push_back(metres.back() + glm::length(places[k] - places[k - 1]));
    return metres;
}

/// Places at evenly spaced marks, linear between those at `at`, which never decrease.
std::vector<Vec2> resampled(const std::vector<double>& at, const std::vector<Vec2>& places,
                            const Moments& marks) {
    std::vector<Vec2> result(marks.count);
    size_t piece = 0;
    for (size_t k = 0; k < marks.count; ++k) {
        const double mark = marks.at(k);
        while (piece + 2 < at.size() && at[piece + 1] <= mark) ++piece;
        const double length = at[piece + 1] - at[piece];
        const double share = length > 0 ? std::clamp((mark - at[piece]) / length, 0.0, 1.0) : 1;
        result[k] = glm::mix(places[piece], places[piece + 1], share);
    }
    return result;
}

std::vector<Vec2> smoothedPlaces(const std::vector<Vec2>& places, size_t reach) {
    std::vector<double> x, y;
    for (const Vec2& place : places) {
        x.push_back(place.x);
        y.push_back(place.y);
    }
    x = smoothed(x, reach, Beyond::Continued);
    y = smoothed(y, reach, Beyond::Continued);
    std::vector<Vec2> result;
    for (size_t k = 0; k < places.size(); ++k) result.emplace_back(x[k], y[k]);
    return result;
}

/// Headings towards where the track will be; at rest the last one stays.
std::vector<double> headingsOf(const std::vector<Vec2>& places, const Moments& moments) {
    constexpr double kRest = 0.5;  // metres
    const size_t n = places.size();
    const size_t ahead = std::clamp(moments.reach(kAheadSeconds), size_t{1}, n - 1);
    std::vector<double> headings(n);
    bool known = false;
    size_t firstKnown = 0;
    for (size_t k = 0; k < n; ++k) {
        const size_t from = std::min(k, n - 1 - ahead);
        const Vec2 way = places[from + ahead] - places[from];
        if (glm::length(way) < kRest) {
            headings[k] = known ? headings[k - 1] : 0;
            continue;
        }
        const double heading = degFromRad(std::atan2(way.x, way.y));
        headings[k] = known ? nearestTurnDeg(heading, headings[k - 1]) : heading;
        if (!known) firstKnown = k;
        known = true;
    }
    std::fill_n(headings.begin(), firstKnown, headings[firstKnown]);
    return smoothed(headings, moments.reach(kHeadingSeconds), Beyond::Mirrored);
}

class TrackPath final : public FlightPath {
public:
    TrackPath(const Moments& moments, const std::vector<Vec2>& places,
              const std::vector<double>& heights, const TrackPathOptions& options)
        : eyes_(eyesOf(moments, places, heights)),
          headings_(monotoneSpline(knotsOf(moments), headingsOf(places, moments))),
          options_(options) {}

    double begin() const override { return eyes_.begin(); }
    double end() const override { return eyes_.end(); }
    Pose at(double seconds) const override {
        Pose pose;
        pose.eye = WorldPoint::fromVec(eyes_.at(seconds));
        pose.headingDeg = normalHeadingDeg(headings_.at(seconds));
        pose.pitchDeg = options_.pitchDeg;
        pose.fovDeg = options_.fovDeg;
        return pose;
    }

private:
    static std::vector<double> knotsOf(const Moments& moments) {
        std::vector<double> knots(moments.count);
        for (size_t k = 0; k < moments.count; ++k) knots[k] = moments.at(k);
        return knots;
    }
    static Spline<Vec3> eyesOf(const Moments& moments, const std::vector<Vec2>& places,
                               const std::vector<double>& heights) {
        std::vector<Vec3> eyes;
        for (size_t k = 0; k < places.size(); ++k) eyes.emplace_back(places[k], heights[k]);
        return smoothSpline(knotsOf(moments), std::move(eyes));
    }

    Spline<Vec3> eyes_;
    Spline<double> headings_;
    TrackPathOptions options_;
};

/// The smoothed way at even moments. At constant speed it is walked again after smoothing, since
/// cut corners are shorter.
std::vector<Vec2> smoothWay(const std::vector<Vec2>& places, const std::vector<double>& times,
                            std::optional<double> speed, Moments& moments) {
    if (!speed) {
        moments = momentsOf(0, times.back() - times.front());
        std::vector<double> at = times;
        for (double& t : at) t -= times.front();
        return smoothedPlaces(resampled(at, places, moments), moments.reach(kWaySeconds));
    }
    std::vector<double> at = metresAlong(places);
    for (double& metres : at) metres /= *speed;
    moments = momentsOf(0, at.back());
    const std::vector<Vec2> smooth =
        smoothedPlaces(resampled(at, places, moments), moments.reach(kWaySeconds));
    at = metresAlong(smooth);
    for (double& metres : at) metres /= *speed;
    moments = momentsOf(0, at.back());
    return resampled(at, smooth, moments);
}

}  // namespace

Result<std::unique_ptr<FlightPath>> makeTrackPath(const std::vector<Vec2>& places,
                                                  const std::vector<double>& times,
                                                  const Ground& ground,
                                                  const TrackPathOptions& options,
                                                  const std::string& name) {
    TERRAY_ASSERT(places.size() >= 2 && (options.speed || times.size() == places.size()));
    constexpr double kShortest = 1;
    if (metresAlong(places).back() < kShortest)
        return makeError(ErrorCode::Input,
                         "'{}': the track is less than a metre long; give one that moves", name);
    Moments moments;
    const std::vector<Vec2> way = smoothWay(places, times, options.speed, moments);
    const std::vector<double> along = groundAlong(way, ground, options.spacing);
    if (along.empty())
        return makeError(ErrorCode::Input,
                         "'{}': the track nowhere crosses the terrain; check that both are of the "
                         "same place",
                         name);
    const std::vector<double> heights =
        followedHeights(along, options.heightAboveGround, moments.reach(kHeightSeconds));
    return std::unique_ptr<FlightPath>(std::make_unique<TrackPath>(moments, way, heights, options));
}

}  // namespace terray
