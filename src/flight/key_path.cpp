// SPDX-License-Identifier: Apache-2.0
// Splines over key frames; constant speed by a table of arc length.
#include "flight/key_path.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"
#include "flight/follow.h"
#include "flight/spline.h"

namespace terray {

double normalHeadingDeg(double deg) {
    const double turn = std::fmod(deg, 360.0);
    return turn < 0 ? std::min(turn + 360.0, std::nextafter(360.0, 0.0)) : turn;
}

double nearestTurnDeg(double deg, double before) {
    return deg - 360 * std::round((deg - before) / 360);
}

namespace {

constexpr double kLiftSeconds = 4;  ///< how far ahead a lift begins

/// Where on a curve the eye is after so many metres.
class ArcLength {
public:
    ArcLength(const Spline<Vec3>& curve, const std::vector<double>& knots) {
        constexpr int kSteps = 256;  // a piece
        Vec3 last = curve.at(knots.front());
        std::vector<double> at{knots.front()}, metres{0};
        for (size_t k = 0; k + 1 < knots.size(); ++k) {
            for (int step = 1; step <= kSteps; ++step) {
                at.push_back(std::lerp(knots[k], knots[k + 1], step / double{kSteps}));
                const Vec3 place = curve.at(at.back());
                // Never quite at rest: the way back from metres must be unique.
                metres.push_back(metres.back() + std::max(glm::length(place - last), 1e-9));
                last = place;
            }
            atKnots_.push_back(metres.back());
        }
        knotAfter_ = monotoneSpline(std::move(metres), std::move(at));
    }

    double knotAfter(double metres) const { return knotAfter_->at(metres); }
    /// Metres at each of the curve's knots.
    const std::vector<double>& atKnots() const { return atKnots_; }

private:
    std::vector<double> atKnots_{0};
    std::optional<Spline<double>> knotAfter_;
};

/// A run of keys with targets.
struct TargetRun {
    size_t first = 0, last = 0;
    Spline<Vec3> targets;
};

class KeyPath final : public FlightPath {
public:
    KeyPath(const std::vector<PathKey>& keys, std::vector<double> times, Spline<Vec3> eyes,
            std::optional<ArcLength> way, double speed)
        : times_(std::move(times)),
          eyes_(std::move(eyes)),
          way_(std::move(way)),
          speed_(speed),
          heading_(anglesOf(keys, &PathKey::headingDeg)),
          pitch_(numbersOf(keys, &PathKey::pitchDeg)),
          roll_(anglesOf(keys, &PathKey::rollDeg)),
          fov_(numbersOf(keys, &PathKey::fovDeg)) {
        findTargetRuns(keys);
    }

    double begin() const override { return times_.front(); }
    double end() const override { return times_.back(); }

    Pose at(double seconds) const override {
        const double t = std::clamp(seconds, begin(), end());
        Pose pose;
        pose.eye = WorldPoint::fromVec(eyeAt(t));
        if (lift_) pose.eye.z += lift_->at(t);
        pose.headingDeg = normalHeadingDeg(heading_.at(t));
        pose.pitchDeg = std::clamp(pitch_.at(t), -90.0, 90.0);
        pose.rollDeg = std::remainder(roll_.at(t), 360.0);
        pose.fovDeg = fov_.at(t);
        const auto run = std::partition_point(
            runs_.begin(), runs_.end(), [&](const TargetRun& r) { return times_[r.last] < t; });
        if (run != runs_.end() && times_[run->first] <= t)
            pose.target = WorldPoint::fromVec(run->targets.at(t));
        return pose;
    }

    void liftOver(const KeyPathOptions& options) {
        const Moments moments = momentsOf(begin(), end());
        std::vector<Vec2> places(moments.count);
        std::vector<double> knots(moments.count), lack(moments.count);
        for (size_t k = 0; k < moments.count; ++k) {
            knots[k] = moments.at(k);
            places[k] = Vec2(eyeAt(knots[k]));
        }
        const std::vector<double> ground = groundAlong(places, options.ground, options.spacing);
        if (ground.empty()) return;
        for (size_t k = 0; k < moments.count; ++k)
            lack[k] = std::max(0.0, ground[k] + options.clearance - eyeAt(knots[k]).z);
        lift_ = monotoneSpline(std::move(knots), smoothLift(lack, moments.reach(kLiftSeconds)));
    }

private:
    Vec3 eyeAt(double t) const {
        return eyes_.at(way_ ? way_->knotAfter((t - begin()) * speed_) : t);
    }

    Spline<double> numbersOf(const std::vector<PathKey>& keys, double PathKey::*field) const {
        std::vector<double> values;
        for (const PathKey& key : keys) values.push_back(key.*field);
        return monotoneSpline(times_, std::move(values));
    }

    Spline<double> anglesOf(const std::vector<PathKey>& keys, double PathKey::*field) const {
        std::vector<double> values;
        for (const PathKey& key : keys)
            values.push_back(values.empty() ? key.*field
                                            : nearestTurnDeg(key.*field, values.back()));
        return monotoneSpline(times_, std::move(values));
    }

    void findTargetRuns(const std::vector<PathKey>& keys) {
        for (size_t k = 0; k < keys.size();) {
            size_t last = k;
            while (last < keys.size() && keys[last].target) ++last;
            if (last > k) {
                std::vector<double> times(times_.begin() + static_cast<ptrdiff_t>(k),
                                          times_.begin() + static_cast<ptrdiff_t>(last));
                std::vector<Vec3> targets;
                for (size_t j = k; j < last; ++j) targets.push_back(keys[j].target->vec());
                runs_.push_back({k, last - 1, smoothSpline(std::move(times), std::move(targets))});
            }
            k = std::max(last, k + 1);
        }
    }

    std::vector<double> times_;
    Spline<Vec3> eyes_;
    std::optional<ArcLength> way_;
    double speed_;
    Spline<double> heading_, pitch_, roll_, fov_;
    std::optional<Spline<double>> lift_;
    std::vector<TargetRun> runs_;
};

}  // namespace

Result<std::unique_ptr<FlightPath>> makeKeyPath(std::vector<PathKey> keys,
                                                const KeyPathOptions& options) {
    TERRAY_ASSERT(keys.size() >= 2);
    std::vector<Vec3> eyes;
    std::vector<double> times;
    for (const PathKey& key : keys) {
        eyes.push_back(key.eye.vec());
        times.push_back(key.seconds);
    }
    std::unique_ptr<KeyPath> path;
    if (options.speed) {
        // Knots that grow with the root of the distance: neither cusps nor loops.
        std::vector<double> knots{0};
        for (size_t k = 1; k < eyes.size(); ++k) {
            const double step = std::sqrt(glm::length(eyes[k] - eyes[k - 1]));
            if (step < 1e-3)
                return makeError(ErrorCode::Input,
                                 "{}: the eye stays where it was, which constant speed leaves no "
                                 "time for; move it, or give times instead of a speed",
                                 keys[k].name);
            knots.push_back(knots.back() + step);
        }
        Spline<Vec3> curve = smoothSpline(knots, std::move(eyes));
        ArcLength way(curve, knots);
        for (size_t k = 0; k < keys.size(); ++k) times[k] = way.atKnots()[k] / *options.speed;
        path = std::make_unique<KeyPath>(keys, std::move(times), std::move(curve), std::move(way),
                                         *options.speed);
    } else {
        Spline<Vec3> curve = smoothSpline(times, std::move(eyes));
        path = std::make_unique<KeyPath>(keys, std::move(times), std::move(curve), std::nullopt, 1);
    }
    if (options.clearance > 0) path->liftOver(options);
    return std::unique_ptr<FlightPath>(std::move(path));
}

}  // namespace terray
