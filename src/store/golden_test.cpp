// SPDX-License-Identifier: Apache-2.0
// The bytes that the store encodes itself are fixed: a change here is a new version of the format.
#include <gtest/gtest.h>

#include "store/edges.h"
#include "store/format.h"
#include "store/hashes.h"
#include "store/manifest.h"

namespace terray {
namespace {

std::string hex(std::span<const std::byte> bytes) {
    std::string text;
    for (const std::byte b : bytes) text += fmt::format("{:02x}", static_cast<unsigned>(b));
    return text;
}

StoreManifest sample() {
    StoreManifest m;
    m.info.scheme = {1025, 600};
    m.info.worldFromLattice = {{500000.5, 4100000.25}, {2, 0}, {0, -2}};
    m.info.ellipsoidRadius = 6371000;
    m.info.format = PostFormat::Int16;
    m.info.z0 = -12.5f;
    m.info.zStep = 0.0625f;
    m.info.minZ = 3.5f;
    m.info.maxZ = 900.125f;
    m.maxError = 0.25;
    m.holes = 7;
    m.sources = {{"dem.tif", 123456, 1700000000, 0x0123456789ABCDEFu}};
    m.notes = {"metres are assumed"};
    m.files = {"height/m0/y0_x0.tif"};
    m.hashes = "00000000deadbeef";
    m.plan = "0000000000c0ffee";
    return m;
}

constexpr const char* kManifest = R"({
 "format": "terray store",
 "version": 1,
 "crs_name": "",
 "crs_wkt": "",
 "geotransform": [
  499999.5,
  2.0,
  0.0,
  4100001.25,
  0.0,
  -2.0
 ],
 "columns": 1025,
 "rows": 600,
 "mips": 2,
 "lattice": {
  "origin": [
   500000.5,
   4100000.25
  ],
  "column": [
   2.0,
   0.0
  ],
  "row": [
   0.0,
   -2.0
  ],
  "metres_per_crs_unit": 1.0,
  "radius_of_curvature": 6371000.0
 },
 "height": {
  "unit": "m",
  "min": 3.5,
  "max": 900.125,
  "holes": 7,
  "hole_value": 65535,
  "type": "uint16",
  "offset": -12.5,
  "scale": 0.0625,
  "max_error": 0.25
 },
 "layers": [
  "height"
 ],
 "data_crs_name": "",
 "data_crs_wkt": "",
 "sources": [
  {
   "name": "dem.tif",
   "bytes": 123456,
   "modified": 1700000000,
   "header_hash": "0123456789abcdef"
  }
 ],
 "notes": [
  "metres are assumed"
 ],
 "files": [
  "height/m0/y0_x0.tif"
 ],
 "plan": "0000000000c0ffee",
 "hashes": "00000000deadbeef",
 "check": "27969f0424dc832c"
}
)";

TEST(Golden, Hash) {
    EXPECT_EQ(hashText(hashOf({})), "2d06800538d394c2");  // XXH3_64bits of nothing, as published
}

TEST(Golden, EdgeHeader) {
    TerrainInfo info = sample().info;
    EXPECT_EQ(hex(encodeEdgeHeader(info, 1)),
              "544552524159454401000000010000000100000001000000020000000104"
              "0000");
    EXPECT_EQ(edgeRange(info, {0, 1, 1}).offset, 32u + 3 * 2050);
    EXPECT_EQ(edgeFileBytes(info, 0), 32u + 4 * 2050);
}

TEST(Golden, HashesFile) {
    const FileHashes file = hashFile("a", bytesOf("headerBLOCKtail"), {{6, 5}});
    const Bytes bytes = encodeHashes({file});
    EXPECT_EQ(hex(bytes),
              "544552524159485301000000010000000100610f00000000000000837de023b3f539a2010000"
              "0006000000000000000500000000000000a1c4a4a15af193fba4e1cc49c6f9a97483a2e3f9ca"
              "ea16b6");
    const auto back = decodeHashes("hashes.bin", bytes);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ((*back)[0], file);
}

TEST(Golden, Manifest) {
    const std::string text = manifestText(sample());
    EXPECT_EQ(text, kManifest);
    const auto back = parseManifest("terrain.json", text);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(manifestText(*back), text);
    EXPECT_EQ(back->info.worldFromLattice.origin, sample().info.worldFromLattice.origin);
}

TEST(Golden, ManifestWithPhotoAndSourceInPlaceComesBack) {
    StoreManifest m = sample();
    m.photo = PhotoLayer{700, 300, {{1.5, 2}, {0.5, 0}, {0, -0.5}}, 80, "bands 1, 2, 3"};
    m.photoSources = {{"photo.tif", 7, 8, 9}};
    m.inPlace = InPlaceSource{"../dem.tif", "Int16", -32768.0, -100, 3};
    const std::string text = manifestText(m);
    for (const char* part : {"\"photo\"\n ]", "\"quality\": 80", "\"mips\": 2,\n  \"lattice\"",
                             "\"path\": \"../dem.tif\"", "\"nodata\": -32768.0"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << text;
    }
    const auto back = parseManifest("terrain.json", text);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(manifestText(*back), text);
    EXPECT_EQ(back->photo->worldFromPixel.origin, Vec2(1.5, 2));
    for (const char* type : {"Float32", "Int32"}) {  // not what the posts are, and unknown
        m.inPlace->type = type;
        EXPECT_FALSE(parseManifest("terrain.json", manifestText(m)).ok()) << type;
    }
    m.inPlace.reset();
    m.photo->columns = 0;
    EXPECT_FALSE(parseManifest("terrain.json", manifestText(m)).ok());
}

TEST(Golden, Paths) {
    EXPECT_EQ(photoShardPath({2, 16, 3}), "photo/m2/y3_x16.tif");
    EXPECT_EQ(shardPath({2, 16, 3}), "height/m2/y3_x16.tif");
    EXPECT_EQ(edgesPath(1), "edges/m1.bin");
    EXPECT_EQ(boundsPath(0), "bounds/m0.tif");
}

TEST(Manifest, EveryDamagedByteAndOtherVersionsAreRefused) {
    const std::string text = manifestText(sample());
    for (size_t k = 0; k < text.size(); ++k) {
        std::string bad = text;
        bad[k] = static_cast<char>(bad[k] ^ 4);
        EXPECT_FALSE(parseManifest("terrain.json", bad).ok()) << k;
        EXPECT_FALSE(parseManifest("terrain.json", text.substr(0, k)).ok()) << k;
    }
    for (const char* version : {"\"version\": 0", "\"version\": 2"}) {
        std::string other = text;
        other.replace(other.find("\"version\": 1"), 12, version);
        const auto result = parseManifest("terrain.json", other);
        ASSERT_FALSE(result.ok());
        EXPECT_NE(result.error().message.find("this Terray reads version 1"), std::string::npos);
    }
}

TEST(Manifest, NumbersThatMakeNoTerrainAreRefused) {
    for (int what = 0; what < 6; ++what) {
        StoreManifest m = sample();
        if (what == 0) m.info.scheme.columns = 1;
        if (what == 1) m.info.scheme.rows = int64_t{1} << 40;
        if (what == 2) m.info.worldFromLattice.row = m.info.worldFromLattice.column;
        if (what == 3) m.info.zStep = 0;
        if (what == 4) m.info.metresPerCrsUnit = -1;
        if (what == 5) m.maxError = -1;
        const auto result = parseManifest("terrain.json", manifestText(m));
        EXPECT_FALSE(result.ok()) << what;
    }
}

TEST(Hashes, EveryDamagedByteIsRefused) {
    const FileHashes file = hashFile("height/a", bytesOf("headerBLOCKtail"), {{6, 5}, {0, 0}});
    const Bytes bytes = encodeHashes({file, file});
    for (size_t k = 0; k < bytes.size(); ++k) {
        Bytes bad = bytes;
        bad[k] ^= std::byte{8};
        EXPECT_FALSE(decodeHashes("hashes.bin", bad).ok()) << k;
        EXPECT_FALSE(decodeHashes("hashes.bin", std::span(bytes).first(k)).ok()) << k;
    }
}

TEST(Hashes, PathsOutOfTheStoreAreRefused) {
    for (const char* path : {"../a", "/etc/passwd", "height/../../a", "http://host/a", ""}) {
        const auto result = decodeHashes("hashes.bin", encodeHashes({hashFile(path, {}, {})}));
        ASSERT_FALSE(result.ok()) << path;
        EXPECT_NE(result.error().message.find("outside"), std::string::npos);
    }
}

}  // namespace
}  // namespace terray
