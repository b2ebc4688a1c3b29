// SPDX-License-Identifier: Apache-2.0
// Tracks of GPX and KML files: places, times, and the sentences for what is no track.
#include "flight/track_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace terray {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class TrackFile : public testing::Test {
protected:
    TrackFile() : folder_(fs::path(testing::TempDir()) / "terray_track_file") {
        fs::create_directories(folder_);
    }
    ~TrackFile() override { fs::remove_all(folder_); }

    std::string write(const std::string& name, const std::string& text) const {
        std::string path = (folder_ / name).string();
        std::ofstream(path, std::ios::binary) << text;
        return path;
    }
    std::string gpx(const std::string& body) const {
        return write("t.gpx",
                     "<?xml version=\"1.0\"?><gpx version=\"1.1\" creator=\"t\" "
                     "xmlns=\"http://www.topografix.com/GPX/1/1\">" +
                         body + "</gpx>");
    }
    std::string kml(const std::string& body) const {
        return write("t.kml",
                     "<?xml version=\"1.0\"?><kml xmlns=\"http://www.opengis.net/kml/2.2\">"
                     "<Document>" +
                         body + "</Document></kml>");
    }
    void refuses(const std::string& path, const std::string& words) const {
        const auto track = readTrack(path);
        ASSERT_FALSE(track) << words;
        EXPECT_EQ(track.error().code, ErrorCode::Input);
        EXPECT_THAT(track.error().message, HasSubstr(words));
        EXPECT_THAT(track.error().message, HasSubstr(path));
    }

    fs::path folder_;
};

std::string point(double lon, double lat, const std::string& time = "") {
    return "<trkpt lat=\"" + std::to_string(lat) + "\" lon=\"" + std::to_string(lon) + "\">" +
           (time.empty() ? "" : "<time>" + time + "</time>") + "</trkpt>";
}

TEST_F(TrackFile, ReadsGpxTracksWithTimes) {
    const std::string path =
        gpx("<trk><trkseg>" + point(-118.2, 34.25, "2024-02-29T23:59:50Z") +
            point(-118.1, 34.26, "2024-03-01T00:00:00Z") + "</trkseg><trkseg>" +
            point(-118.0, 34.27, "2024-03-01T01:00:20.5+01:00") + "</trkseg></trk>");
    ASSERT_TRUE(looksLikeTrack(path));
    const auto track = readTrack(path);
    ASSERT_TRUE(track) << track.error().message;
    ASSERT_EQ(track->lonLats.size(), 3u);
    EXPECT_NEAR(track->lonLats[1].x, -118.1, 1e-9);
    EXPECT_NEAR(track->lonLats[2].y, 34.27, 1e-9);
    ASSERT_EQ(track->seconds.size(), 3u);
    EXPECT_DOUBLE_EQ(track->seconds[1] - track->seconds[0], 10);
    EXPECT_DOUBLE_EQ(track->seconds[2] - track->seconds[1], 20.5);
}

TEST_F(TrackFile, LeavesOutRepeatedPoints) {
    const auto untimed = readTrack(
        gpx("<trk><trkseg>" + point(1, 2) + point(1, 2) + point(1, 3) + "</trkseg></trk>"));
    ASSERT_TRUE(untimed);
    EXPECT_EQ(untimed->lonLats.size(), 2u);
    EXPECT_TRUE(untimed->seconds.empty());
    EXPECT_EQ(untimed->rests, 1);
    const auto timed =
        readTrack(gpx("<trk><trkseg>" + point(1, 2, "2024-01-01T00:00:00Z") +
                      point(1, 2, "2024-01-01T00:00:09Z") + point(1, 3, "2024-01-01T00:00:09Z") +
                      point(1, 4, "2024-01-01T00:00:19Z") + "</trkseg></trk>"));
    ASSERT_TRUE(timed) << timed.error().message;
    EXPECT_EQ(timed->seconds.size(), 3u);
}

TEST_F(TrackFile, ReadsGpxRoutes) {
    const auto track = readTrack(
        gpx("<rte><rtept lat=\"2\" lon=\"1\"></rtept><rtept lat=\"3\" lon=\"1\"></rtept></rte>"));
    ASSERT_TRUE(track) << track.error().message;
    EXPECT_EQ(track->lonLats[1], Vec2(1, 3));
}

TEST_F(TrackFile, ReadsTheLineOfKml) {
    const auto track = readTrack(
        kml("<Placemark><Point><coordinates>9,9</coordinates></Point></Placemark>"
            "<Placemark><LineString><coordinates>10.5,60,5 10.6,60.1,7 10.7,60.2</coordinates>"
            "</LineString></Placemark>"));
    ASSERT_TRUE(track) << track.error().message;
    ASSERT_EQ(track->lonLats.size(), 3u);
    EXPECT_EQ(track->lonLats[0], Vec2(10.5, 60));
    EXPECT_TRUE(track->seconds.empty());
}

TEST_F(TrackFile, RefusesWhatIsNoSingleTrack) {
    const std::string line =
        "<Placemark><LineString><coordinates>1,2 3,4</coordinates></LineString></Placemark>";
    refuses(kml(line + line), "several lines");
    refuses(kml(""), "no line");
    refuses(gpx(""), "no line");
    const std::string one = "<trk><trkseg>" + point(1, 2) + point(1, 3) + "</trkseg></trk>";
    refuses(gpx(one + one), "several tracks");
    refuses(gpx("<trk><trkseg>" + point(1, 2) + "</trkseg></trk>"), "two or more");
    refuses(gpx("<trk><trkseg>" + point(1, 2, "2024-01-01T00:00:10Z") +
                point(1, 3, "2024-01-01T00:00:09Z") + "</trkseg></trk>"),
            "earlier");
    refuses(gpx("<trk><trkseg>" + point(1, 2) + point(1, 95) + "</trkseg></trk>"), "");
}

TEST_F(TrackFile, RefusesBrokenAndForeignFiles) {
    refuses(write("t.gpx", "<?xml version=\"1.0\"?><gpx><trk><trkse"), "");
    refuses(write("t.xml", "<html><body>no</body></html>"), "neither GPX nor KML");
    refuses((folder_ / "missing.gpx").string(), "neither GPX nor KML");
    EXPECT_FALSE(looksLikeTrack(write("f.txt", "0 1,2,3 4,5")));
    EXPECT_FALSE(looksLikeTrack((folder_ / "missing.gpx").string()));
}

}  // namespace
}  // namespace terray
