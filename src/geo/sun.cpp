// SPDX-License-Identifier: Apache-2.0
// The sun's place by Meeus' low-precision theory (Astronomical Algorithms, 2nd edition 1998,
// chapters 12, 13, 22 and 25; the one that NOAA's solar calculator uses): good to 0.01 degree
// within a century of 2000. Apparent place, without refraction.
#include "geo/sun.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "math/types.h"

namespace terray {
namespace {

constexpr double kJ2000 = 2451545.0;  ///< 2000-01-01 12:00

double sinDeg(double deg) { return std::sin(radFromDeg(deg)); }
double cosDeg(double deg) { return std::cos(radFromDeg(deg)); }

/// 0 <= result < 360.
double fullCircle(double deg) {
    const double turned = std::fmod(deg, 360.0);
    const double positive = turned < 0 ? turned + 360 : turned;
    return positive < 360 ? positive : 0;
}

/// Dynamical time minus universal time in days: a parabola through the published values of 1950
/// (29 s), 2000 (64 s) and 2020 (69 s); 10 s are 0.0001 degree of the sun's longitude.
double deltaT(double julianDay) {
    const double centuries = (julianDay - kJ2000) / 36525;
    const double seconds = 64 + 40 * centuries - 60 * centuries * centuries;
    return std::clamp(seconds, 20.0, 100.0) / 86400;
}

/// Apparent right ascension and declination, and the nutation in right ascension; degrees.
struct Equatorial {
    double rightAscension = 0, declination = 0, equationOfEquinoxes = 0;
};

Equatorial apparentSun(double julianDay) {
    const double t = (julianDay + deltaT(julianDay) - kJ2000) / 36525;
    const double meanLongitude = 280.46646 + t * (36000.76983 + t * 0.0003032);
    const double anomaly = 357.52911 + t * (35999.05029 - t * 0.0001537);
    const double centre = (1.914602 - t * (0.004817 + t * 0.000014)) * sinDeg(anomaly) +
                          (0.019993 - t * 0.000101) * sinDeg(2 * anomaly) +
                          0.000289 * sinDeg(3 * anomaly);
    const double node = 125.04 - 1934.136 * t;  // of the moon's orbit: nutation
    const double nutation = -0.00478 * sinDeg(node);
    const double aberration = -0.00569;
    const double longitude = meanLongitude + centre + aberration + nutation;
    const double obliquity =
        23.4392911 - t * (0.0130042 + t * (1.64e-7 - t * 5.036e-7)) + 0.00256 * cosDeg(node);
    return {degFromRad(std::atan2(cosDeg(obliquity) * sinDeg(longitude), cosDeg(longitude))),
            degFromRad(std::asin(sinDeg(obliquity) * sinDeg(longitude))),
            nutation * cosDeg(obliquity)};
}

/// Sidereal time at Greenwich, degrees (Meeus, equation 12.4).
double meanSiderealTime(double julianDay) {
    const double days = julianDay - kJ2000, t = days / 36525;
    return 280.46061837 + 360.98564736629 * days + t * t * (0.000387933 - t / 38710000);
}

/// Days from 1970-01-01 in the Gregorian calendar (Hinnant, days_from_civil).
int64_t daysFromCivil(int64_t year, int month, int day) {
    year -= month <= 2;
    const int64_t era = (year >= 0 ? year : year - 399) / 400;
    const int64_t yearOfEra = year - era * 400;
    const int64_t dayOfYear = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
    return era * 146097 + yearOfEra * 365 + yearOfEra / 4 - yearOfEra / 100 + dayOfYear - 719468;
}

int daysInMonth(int year, int month) {
    constexpr std::array<int, 12> kDays{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    const bool isLeap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    return month == 2 && isLeap ? 29 : kDays[static_cast<size_t>(month - 1)];
}

/// Takes text apart from the front; a step that does not fit fails and stays failed.
class Scanner {
public:
    explicit Scanner(std::string_view text) : rest_(text) {}
    bool take(std::string_view choices) {
        if (rest_.empty() || choices.find(rest_.front()) == std::string_view::npos) return false;
        rest_.remove_prefix(1);
        return true;
    }
    void expect(std::string_view choices) { good_ = take(choices) && good_; }
    int number(size_t digits) {
        int value = 0;
        for (size_t k = 0; k < digits; ++k) {
            const char c = k < rest_.size() ? rest_[k] : 'x';
            if (c < '0' || c > '9') good_ = false;
            value = good_ ? value * 10 + (c - '0') : 0;
        }
        rest_.remove_prefix(std::min(digits, rest_.size()));
        return value;
    }
    /// ".25" after whole seconds: its digits are read, at least one.
    double fraction() {
        double value = 0, unit = 0.1;
        if (!take(".,")) return 0;
        if (!isDigit()) good_ = false;
        for (; isDigit(); unit /= 10) value += unit * number(1);
        return value;
    }
    bool isDigit() const { return !rest_.empty() && rest_[0] >= '0' && rest_[0] <= '9'; }
    bool startsWith(char c) const { return !rest_.empty() && rest_.front() == c; }
    bool isDone() const { return good_ && rest_.empty(); }

private:
    std::string_view rest_;
    bool good_ = true;
};

struct Fields {
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
    double fraction = 0;
    bool hasOffset = false;
    int offsetMinutes = 0;
};

std::optional<Fields> scan(const std::string& text) {
    Scanner in(text);
    Fields f;
    f.year = in.number(4);
    in.expect("-");
    f.month = in.number(2);
    in.expect("-");
    f.day = in.number(2);
    in.expect("Tt ");
    f.hour = in.number(2);
    in.expect(":");
    f.minute = in.number(2);
    if (in.take(":")) {
        f.second = in.number(2);
        f.fraction = in.fraction();
    }
    if (in.take("Zz")) {
        f.hasOffset = true;
    } else if (in.startsWith('+') || in.startsWith('-')) {
        const int sign = in.startsWith('-') ? -1 : 1;
        in.take("+-");
        const int hours = in.number(2);
        in.take(":");
        const int minutes = in.isDone() ? 0 : in.number(2);
        f.hasOffset = true;
        f.offsetMinutes = sign * (hours * 60 + minutes);
        if (hours > 15 || minutes > 59) return std::nullopt;
    }
    if (!in.isDone()) return std::nullopt;
    return f;
}

std::optional<Error> checkRanges(const Fields& f, const std::string& text) {
    const auto bad = [&](const char* what, int value, int lowest, int highest) {
        return makeError(ErrorCode::Usage, "--time {}: the {} {} is not within {} to {}", text,
                         what, value, lowest, highest);
    };
    if (f.year < 1600) return bad("year", f.year, 1600, 9999);
    if (f.month < 1 || f.month > 12) return bad("month", f.month, 1, 12);
    const int days = daysInMonth(f.year, f.month);
    if (f.day < 1 || f.day > days) return bad("day", f.day, 1, days);
    if (f.hour > 23) return bad("hour", f.hour, 0, 23);
    if (f.minute > 59) return bad("minute", f.minute, 0, 59);
    if (f.second > 59) return bad("second", f.second, 0, 59);
    return std::nullopt;
}

std::string utcText(int64_t secondsSince1970) {
    const int64_t day =
        secondsSince1970 >= 0 ? secondsSince1970 / 86400 : (secondsSince1970 - 86399) / 86400;
    const int64_t second = secondsSince1970 - day * 86400;
    // civil date from days (Hinnant)
    const int64_t shifted = day + 719468;
    const int64_t era = (shifted >= 0 ? shifted : shifted - 146096) / 146097;
    const int64_t dayOfEra = shifted - era * 146097;
    const int64_t yearOfEra =
        (dayOfEra - dayOfEra / 1460 + dayOfEra / 36524 - dayOfEra / 146096) / 365;
    const int64_t dayOfYear = dayOfEra - (365 * yearOfEra + yearOfEra / 4 - yearOfEra / 100);
    const int64_t monthIndex = (5 * dayOfYear + 2) / 153;
    const int64_t month = monthIndex < 10 ? monthIndex + 3 : monthIndex - 9;
    const int64_t year = yearOfEra + era * 400 + (month <= 2 ? 1 : 0);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", year, month,
                       dayOfYear - (153 * monthIndex + 2) / 5 + 1, second / 3600, second / 60 % 60,
                       second % 60);
}

}  // namespace

Result<Moment> parseIsoTime(const std::string& text) {
    const std::optional<Fields> fields = scan(text);
    if (!fields) {
        return makeError(ErrorCode::Usage,
                         "--time '{}' is not an ISO 8601 moment; write it like "
                         "2024-06-21T12:00:00Z or 2024-06-21T14:00+02:00",
                         text.substr(0, 60));
    }
    if (const auto error = checkRanges(*fields, text)) return *error;
    const int64_t days = daysFromCivil(fields->year, fields->month, fields->day);
    const int64_t seconds = days * 86400 + fields->hour * 3600 +
                            (fields->minute - fields->offsetMinutes) * 60 + fields->second;
    Moment moment;
    moment.julianDay = 2440587.5 + (static_cast<double>(seconds) + fields->fraction) / 86400;
    moment.hadOffset = fields->hasOffset;
    moment.utcText = utcText(seconds);
    return moment;
}

SunPosition sunPosition(double julianDay, double longitudeDeg, double latitudeDeg) {
    const Equatorial sun = apparentSun(julianDay);
    const double siderealTime = meanSiderealTime(julianDay) + sun.equationOfEquinoxes;
    const double hourAngle = siderealTime + longitudeDeg - sun.rightAscension;
    const double south = sinDeg(latitudeDeg) * cosDeg(sun.declination) * cosDeg(hourAngle) -
                         cosDeg(latitudeDeg) * sinDeg(sun.declination);
    const double west = cosDeg(sun.declination) * sinDeg(hourAngle);
    const double up = sinDeg(latitudeDeg) * sinDeg(sun.declination) +
                      cosDeg(latitudeDeg) * cosDeg(sun.declination) * cosDeg(hourAngle);
    const double level = std::hypot(south, west);
    const double parallax = 0.00244 * level;  // the observer stands off the earth's centre
    return {fullCircle(degFromRad(std::atan2(west, south)) + 180),
            degFromRad(std::atan2(up, level)) - parallax};
}

}  // namespace terray
