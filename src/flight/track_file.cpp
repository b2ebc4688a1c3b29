// SPDX-License-Identifier: Apache-2.0
// Reading tracks over GDAL's vector drivers.
#include "flight/track_file.h"

#include <ogrsf_frmts.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "base/interrupt.h"
#include "dataset/gdal_handle.h"

namespace terray {
namespace {

constexpr size_t kMostPoints = 2'000'000;
constexpr std::uintmax_t kMostTrackBytes = 256u << 20;

/// Collects places; those that repeat the last one are left out with their times.
class TrackBuilder {
public:
    explicit TrackBuilder(const std::string& path) : path_(path) {}

    Result<void> add(double lon, double lat, std::optional<double> seconds) {
        ++points_;
        if (points_ > kMostPoints)
            return makeError(ErrorCode::Input, "'{}' has more than {} points; thin them out", path_,
                             kMostPoints);
        const bool onEarth =
            std::isfinite(lon) && std::isfinite(lat) && std::abs(lon) <= 360 && std::abs(lat) <= 90;
        if (!onEarth)
            return makeError(ErrorCode::Input,
                             "'{}': point {} ({}, {}) is no longitude and latitude", path_, points_,
                             lon, lat);
        if (seconds && timed_ && *seconds < last_)
            return makeError(ErrorCode::Input,
                             "'{}': point {} is earlier than the one before it; sort the track, or "
                             "give --speed",
                             path_, points_);
        const Vec2 place{lon, lat};
        const bool sameTime = seconds && timed_ && *seconds == last_;
        const bool rests = !track_.lonLats.empty() && track_.lonLats.back() == place;
        timed_ = seconds.has_value();
        if (timed_) last_ = *seconds;
        allTimed_ = allTimed_ && timed_;
        // A rest in a timed track takes its time; the same moment twice does not.
        if (sameTime || (rests && !timed_)) {
            ++track_.rests;
            return {};
        }
        track_.lonLats.push_back(place);
        track_.seconds.push_back(seconds.value_or(0));
        return {};
    }

    Result<Track> finish() {
        if (track_.lonLats.size() < 2)
            return makeError(ErrorCode::Input,
                             "'{}': the track has {} points; a flight needs two or more", path_,
                             track_.lonLats.size());
        if (!allTimed_) track_.seconds.clear();
        return std::move(track_);
    }

private:
    std::string path_;
    Track track_;
    size_t points_ = 0;
    bool timed_ = false, allTimed_ = true;
    double last_ = 0;
};

/// Seconds of a date and time, from some fixed day on; nothing if the field is unset.
std::optional<double> secondsOf(const OGRFeature& feature, int field) {
    if (field < 0 || !feature.IsFieldSetAndNotNull(field)) return std::nullopt;
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, zone = 0;
    float second = 0;
    if (!feature.GetFieldAsDateTime(field, &year, &month, &day, &hour, &minute, &second, &zone))
        return std::nullopt;
    const auto y = static_cast<int64_t>(month <= 2 ? year - 1 : year);
    const int64_t shifted = (month + 9) % 12;
    const int64_t days = 365 * y + y / 4 - y / 100 + y / 400 + (shifted * 306 + 5) / 10 + day;
    const double offset = zone > 1 ? (zone - 100) * 900.0 : 0;
    return static_cast<double>(days) * 86400.0 + hour * 3600.0 + minute * 60.0 +
           std::round(static_cast<double>(second) * 1000) / 1000 - offset;
}

/// All points of a GPX layer of points; those of one track or route.
Result<Track> readGpxPoints(OGRLayer& layer, const std::string& path, const char* kind) {
    TrackBuilder builder(path);
    const int id = layer.GetLayerDefn()->GetFieldIndex((std::string(kind) + "_fid").c_str());
    const int time = layer.GetLayerDefn()->GetFieldIndex("time");
    int first = -1;
    for (const auto& feature : layer) {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        const int owner = id >= 0 ? feature->GetFieldAsInteger(id) : 0;
        if (first < 0) first = owner;
        if (owner != first)
            return makeError(ErrorCode::Input, "'{}' has several {}s; leave one in the file", path,
                             kind);
        const OGRGeometryH geometry = OGRGeometry::ToHandle(feature->GetGeometryRef());
        if (!geometry || wkbFlatten(OGR_G_GetGeometryType(geometry)) != wkbPoint) continue;
        TERRAY_TRY(builder.add(OGR_G_GetX(geometry, 0), OGR_G_GetY(geometry, 0),
                               secondsOf(*feature, time)));
    }
    return builder.finish();
}

Result<void> addLine(OGRGeometryH line, TrackBuilder& builder) {
    for (int k = 0; k < OGR_G_GetPointCount(line); ++k)
        TERRAY_TRY(builder.add(OGR_G_GetX(line, k), OGR_G_GetY(line, k), std::nullopt));
    return {};
}

/// Counts lines in a geometry; the last one found stays in `line`.
int linesIn(OGRGeometryH geometry, OGRGeometryH& line) {
    const OGRwkbGeometryType type = wkbFlatten(OGR_G_GetGeometryType(geometry));
    if (type == wkbLineString) {
        line = geometry;
        return 1;
    }
    int lines = 0;
    if (OGR_GT_IsSubClassOf(type, wkbGeometryCollection))
        for (int k = 0; k < OGR_G_GetGeometryCount(geometry); ++k)
            lines += linesIn(OGR_G_GetGeometryRef(geometry, k), line);
    return lines;
}

Result<Track> readLines(GDALDataset& dataset, const std::string& path) {
    TrackBuilder builder(path);
    int lines = 0;
    for (OGRLayer* layer : dataset.GetLayers()) {
        for (const auto& feature : layer) {
            if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
            const OGRGeometryH geometry = OGRGeometry::ToHandle(feature->GetGeometryRef());
            OGRGeometryH line = nullptr;
            if (geometry) lines += linesIn(geometry, line);
            if (lines > 1)
                return makeError(ErrorCode::Input, "'{}' has several lines; leave one in the file",
                                 path);
            if (line) TERRAY_TRY(addLine(line, builder));
        }
    }
    if (lines == 0)
        return makeError(ErrorCode::Input, "'{}' has no line, track or route to fly along", path);
    return builder.finish();
}

}  // namespace

bool looksLikeTrack(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;  // a pipe is read once
    std::ifstream file(path, std::ios::binary);
    char head[64] = {};
    file.read(head, sizeof head);
    std::string text(head, static_cast<size_t>(file.gcount()));
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    for (const char c : text)
        if (std::isspace(static_cast<unsigned char>(c)) == 0) return c == '<';
    return false;
}

Result<Track> readTrack(const std::string& path) {
    std::error_code problem;
    const std::uintmax_t bytes = std::filesystem::file_size(path, problem);
    if (!problem && bytes > kMostTrackBytes)
        return makeError(ErrorCode::Input, "'{}' has more than {} MiB; that is no track", path,
                         kMostTrackBytes >> 20);
    ensureGdal();
    clearGdalMessage();
    const char* const drivers[] = {"GPX", "LIBKML", "KML", nullptr};
    const DatasetHandle dataset(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY,
                                                  drivers, nullptr, nullptr));
    if (!dataset) {
        const std::string why = gdalMessage();
        return makeError(ErrorCode::Input, "'{}' is neither GPX nor KML{}{}", path,
                         why.empty() ? "" : ": ", why);
    }
    const std::string driver = dataset->GetDriver()->GetDescription();
    if (driver != "GPX") return readLines(*dataset, path);
    OGRLayer* tracks = dataset->GetLayerByName("track_points");
    if (tracks && tracks->GetFeatureCount() > 0) return readGpxPoints(*tracks, path, "track");
    OGRLayer* routes = dataset->GetLayerByName("route_points");
    if (routes && routes->GetFeatureCount() > 0) return readGpxPoints(*routes, path, "route");
    return makeError(ErrorCode::Input, "'{}' has no line, track or route to fly along", path);
}

}  // namespace terray
