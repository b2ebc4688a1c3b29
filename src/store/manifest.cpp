// SPDX-License-Identifier: Apache-2.0
// Writing terrain.json, and reading it without trusting it.
#include "store/manifest.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "store/format.h"
#include "store/hashes.h"

namespace terray {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFormatName = "terray store";
constexpr const char* kNoCheck = "0000000000000000";
constexpr int64_t kMostPosts = int64_t{1} << 31;  ///< a side: lattice cells are 32-bit numbers

ordered_json pair(Vec2 v) { return {v.x, v.y}; }

ordered_json sourcesJson(const std::vector<StoreSource>& sources) {
    ordered_json json = ordered_json::array();
    for (const StoreSource& source : sources) {
        json.push_back({{"name", source.name},
                        {"bytes", source.bytes},
                        {"modified", source.modified},
                        {"header_hash", hashText(source.headerHash)}});
    }
    return json;
}

ordered_json inPlaceJson(const InPlaceSource& source) {
    ordered_json json{{"path", source.path}, {"type", source.type}};
    if (source.nodata && std::isfinite(*source.nodata)) json["nodata"] = *source.nodata;
    json["base"] = source.base;
    json["shift"] = source.shift;
    return json;
}

ordered_json photoJson(const StoreManifest& m) {
    const PhotoLayer& photo = *m.photo;
    const GeoTransform transform = photo.geoTransform(m.info.metresPerCrsUnit, 0, 0, 0);
    return {{"geotransform", transform.values},
            {"columns", photo.columns},
            {"rows", photo.rows},
            {"mips", photo.mipCount()},
            {"lattice",
             {{"origin", pair(photo.worldFromPixel.origin)},
              {"column", pair(photo.worldFromPixel.column)},
              {"row", pair(photo.worldFromPixel.row)}}},
            {"compression", photo.isLossless() ? "zstd" : "jpeg"},
            {"quality", photo.quality},
            {"description", photo.description},
            {"sources", sourcesJson(m.photoSources)}};
}

ordered_json toJson(const StoreManifest& m) {
    const TerrainInfo& info = m.info;
    const GeoTransform transform = geoTransformOf(info, 0, 0, 0);
    const bool isInt16 = info.format == PostFormat::Int16;
    ordered_json json{
        {"format", kFormatName},
        {"version", kStoreVersion},
        {"crs_name", m.crsName},
        {"crs_wkt", info.crsWkt},
        {"geotransform", transform.values},
        {"columns", info.scheme.columns},
        {"rows", info.scheme.rows},
        {"mips", info.scheme.mipCount()},
        {"lattice",
         {{"origin", pair(info.worldFromLattice.origin)},
          {"column", pair(info.worldFromLattice.column)},
          {"row", pair(info.worldFromLattice.row)},
          {"metres_per_crs_unit", info.metresPerCrsUnit},
          {"radius_of_curvature", info.ellipsoidRadius}}},
        {"height",
         {{"unit", "m"},
          {"min", info.minZ},
          {"max", info.maxZ},
          {"holes", m.holes},
          {"hole_value", isInt16 ? ordered_json(kHolePost) : ordered_json("nan")},
          {"type", isInt16 ? "uint16" : "float32"},
          {"offset", isInt16 ? info.z0 : 0.0f},
          {"scale", isInt16 ? info.zStep : 1.0f},
          {"max_error", m.maxError}}},
        {"layers", m.photo ? ordered_json{"height", "photo"} : ordered_json{"height"}},
        {"data_crs_name", m.dataCrsName},
        {"data_crs_wkt", m.dataCrsWkt},
        {"sources", sourcesJson(m.sources)},
        {"notes", m.notes},
        {"files", m.files},
        {"plan", m.plan},
        {"hashes", m.hashes},
    };
    if (m.inPlace) json["in_place"] = inPlaceJson(*m.inPlace);
    if (m.photo) json["photo"] = photoJson(m);
    return json;
}

std::string dump(const ordered_json& json) {
    return json.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

Vec2 pairOf(const ordered_json& json) {
    return {json.at(0).get<double>(), json.at(1).get<double>()};
}

void fillHeights(const ordered_json& json, StoreManifest& m) {
    TerrainInfo& info = m.info;
    const ordered_json& height = json.at("height");
    info.minZ = height.at("min").get<float>();
    info.maxZ = height.at("max").get<float>();
    m.holes = height.at("holes").get<uint64_t>();
    m.maxError = height.at("max_error").get<double>();
    const std::string type = height.at("type").get<std::string>();
    if (type == "uint16") {
        info.format = PostFormat::Int16;
        info.z0 = height.at("offset").get<float>();
        info.zStep = height.at("scale").get<float>();
    } else if (type != "float32") {
        throw std::invalid_argument("unknown type of heights '" + type + "'");
    }
}

std::vector<StoreSource> sourcesOf(const ordered_json& json) {
    std::vector<StoreSource> sources;
    for (const ordered_json& source : json) {
        sources.push_back({source.at("name").get<std::string>(), source.at("bytes").get<uint64_t>(),
                           source.at("modified").get<int64_t>(),
                           std::stoull(source.at("header_hash").get<std::string>(), nullptr, 16)});
    }
    return sources;
}

void fillInPlace(const ordered_json& json, StoreManifest& m) {
    InPlaceSource& source = m.inPlace.emplace();
    source.path = json.at("path").get<std::string>();
    source.type = json.at("type").get<std::string>();
    if (json.contains("nodata")) source.nodata = json.at("nodata").get<double>();
    source.base = json.at("base").get<int64_t>();
    source.shift = json.at("shift").get<int>();
}

Affine2 latticeOf(const ordered_json& lattice) {
    return {pairOf(lattice.at("origin")), pairOf(lattice.at("column")), pairOf(lattice.at("row"))};
}

void fillPhoto(const ordered_json& json, StoreManifest& m) {
    PhotoLayer& photo = m.photo.emplace();
    photo.columns = json.at("columns").get<int64_t>();
    photo.rows = json.at("rows").get<int64_t>();
    photo.worldFromPixel = latticeOf(json.at("lattice"));
    photo.quality = json.at("quality").get<int>();
    photo.description = json.at("description").get<std::string>();
    m.photoSources = sourcesOf(json.at("sources"));
}

StoreManifest fromJson(const ordered_json& json) {
    StoreManifest m;
    TerrainInfo& info = m.info;
    info.crsWkt = json.at("crs_wkt").get<std::string>();
    m.crsName = json.at("crs_name").get<std::string>();
    info.scheme = {json.at("columns").get<int64_t>(), json.at("rows").get<int64_t>()};
    const ordered_json& lattice = json.at("lattice");
    info.worldFromLattice = latticeOf(lattice);
    info.metresPerCrsUnit = lattice.at("metres_per_crs_unit").get<double>();
    info.ellipsoidRadius = lattice.at("radius_of_curvature").get<double>();
    fillHeights(json, m);
    m.dataCrsName = json.at("data_crs_name").get<std::string>();
    m.dataCrsWkt = json.at("data_crs_wkt").get<std::string>();
    m.sources = sourcesOf(json.at("sources"));
    if (json.contains("in_place")) fillInPlace(json.at("in_place"), m);
    if (json.contains("photo")) fillPhoto(json.at("photo"), m);
    m.notes = json.at("notes").get<std::vector<std::string>>();
    m.files = json.at("files").get<std::vector<std::string>>();
    m.hashes = json.at("hashes").get<std::string>();
    m.plan = json.at("plan").get<std::string>();
    return m;
}

bool isSane(const PhotoLayer& photo) {
    const Affine2& map = photo.worldFromPixel;
    return photo.columns > 0 && photo.rows > 0 && photo.columns <= kMostPosts &&
           photo.rows <= kMostPosts && photo.quality >= 0 && photo.quality <= 100 &&
           std::isfinite(map.origin.x) && std::isfinite(map.origin.y) && std::isfinite(map.det()) &&
           std::abs(map.det()) > 0;
}

bool isSane(const InPlaceSource& source, const StoreManifest& m) {
    const bool isFloat = source.type == "Float32";
    if (!isFloat && source.type != "Int16" && source.type != "UInt16") return false;
    return isFloat == (m.info.format == PostFormat::Float32) && m.sources.size() == 1 &&
           !source.path.empty() && source.shift >= 0 && source.shift <= 16 &&
           std::abs(source.base) <= 1 << 20;
}

bool isSane(const StoreManifest& m) {
    if (m.inPlace && !isSane(*m.inPlace, m)) return false;
    if (m.photo && !isSane(*m.photo)) return false;
    const TerrainInfo& info = m.info;
    const TilingScheme& scheme = info.scheme;
    if (scheme.columns < 2 || scheme.rows < 2 || scheme.columns > kMostPosts ||
        scheme.rows > kMostPosts || scheme.mipCount() > kMaxMips) {
        return false;
    }
    const Affine2& map = info.worldFromLattice;
    for (const double value : {map.origin.x, map.origin.y, map.det(), info.ellipsoidRadius}) {
        if (!std::isfinite(value)) return false;
    }
    if (!(std::abs(map.det()) > 0) || !(info.metresPerCrsUnit > 0) || !(m.maxError >= 0)) {
        return false;
    }
    const bool codes = std::isfinite(info.z0) && std::isfinite(info.zStep) && info.zStep > 0;
    return info.format == PostFormat::Float32 || codes;
}

}  // namespace

Result<std::unique_ptr<ShardFile>> openShard(const std::string& folder,
                                             const StoreManifest& manifest, ShardId shard) {
    if (shard.mip == 0 && manifest.inPlace) {
        return ShardFile::openInPlace(manifest.inPlace->pathFrom(folder), *manifest.inPlace,
                                      manifest.info, shard);
    }
    return ShardFile::open(folder + (folder.ends_with('/') ? "" : "/") + shardPath(shard),
                           manifest.info, shard);
}

std::string manifestText(const StoreManifest& manifest) {
    ordered_json json = toJson(manifest);
    json["check"] = kNoCheck;
    const std::string check = hashText(hashOf(bytesOf(dump(json))));
    json["check"] = check;
    return dump(json);
}

Result<StoreManifest> parseManifest(const std::string& name, const std::string& text) {
    try {
        const ordered_json json = ordered_json::parse(text);
        if (!json.is_object() || json.value("format", "") != kFormatName) {
            return makeError(ErrorCode::Input, "'{}' is not the manifest of a Terray store", name);
        }
        const int version = json.value("version", 0);
        if (version != kStoreVersion) {
            return makeError(ErrorCode::Input,
                             "'{}' has version {}; this Terray reads version {}: bake it again",
                             name, version, kStoreVersion);
        }
        const std::string check = json.at("check").get<std::string>();
        const size_t at = text.rfind(check);
        std::string unchecked = text;
        if (check.size() != 16 || at == std::string::npos) throw std::invalid_argument("no check");
        unchecked.replace(at, check.size(), kNoCheck);
        if (hashText(hashOf(bytesOf(unchecked))) != check) {
            throw std::invalid_argument("it does not have the hash that it states");
        }
        StoreManifest manifest = fromJson(json);
        if (!isSane(manifest)) throw std::invalid_argument("its numbers make no terrain");
        return manifest;
    } catch (const std::exception& why) {
        return makeError(ErrorCode::Input, "'{}' is damaged: {}", name, why.what());
    }
}

}  // namespace terray
