// SPDX-License-Identifier: Apache-2.0
// Reads camera files (JSON). Every error names the file and the key.
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/result.h"
#include "terray/view.h"

namespace terray {
namespace {

using nlohmann::json;

constexpr std::streamsize kMaxFileBytes = 1 << 20;  // a camera is a few lines: not a raster

/// Fills one View from one file's keys.
class ViewReader {
public:
    ViewReader(std::string path, View defaults) : path_(std::move(path)), view_(defaults) {}

    Result<View> read(const json& object) {
        for (const auto& [key, value] : object.items()) TERRAY_TRY(readKey(key, value));
        if (object.contains("look_at") &&
            (object.contains("heading") || object.contains("pitch"))) {
            return bad("look_at", "does not go with 'heading' and 'pitch'; give one or the other");
        }
        return view_;
    }

private:
    Error bad(const std::string& key, const std::string& what) const {
        return makeError(ErrorCode::Input, "camera file '{}': '{}' {}", path_, key, what);
    }

    Result<void> readKey(const std::string& key, const json& value) {
        if (key == "eye") return readPlace(key, value, view_.eye, 3);
        if (key == "look_at") return readPlace(key, value, view_.lookAt, 2);
        if (key == "heading") return readOptional(key, value, view_.headingDeg);
        if (key == "pitch") return readPitch(key, value);
        if (key == "roll") return readNumber(key, value, view_.rollDeg);
        if (key == "fov") return readFov(key, value);
        if (key == "projection") return readProjection(key, value);
        if (key == "size") return readSize(key, value);
        if (key == "extent") return readExtent(key, value);
        if (key == "lonlat") {
            if (!value.is_boolean()) return bad(key, "must be true or false");
            view_.lonLat = value.get<bool>();
            return {};
        }
        return bad(
            key,
            "is not a key of camera files; known are eye, look_at, heading, pitch, roll, fov, "
            "projection, size, extent, lonlat");
    }

    Result<void> readNumber(const std::string& key, const json& value, double& out) const {
        if (!value.is_number() || !std::isfinite(value.get<double>())) {
            return bad(key, "must be a number");
        }
        out = value.get<double>();
        return {};
    }

    Result<void> readOptional(const std::string& key, const json& value,
                              std::optional<double>& out) const {
        double number = 0;
        TERRAY_TRY(readNumber(key, value, number));
        out = number;
        return {};
    }

    Result<void> readPitch(const std::string& key, const json& value) {
        TERRAY_TRY(readOptional(key, value, view_.pitchDeg));
        if (std::abs(*view_.pitchDeg) > 90) return bad(key, "must be -90 (straight down) to 90");
        return {};
    }

    Result<void> readFov(const std::string& key, const json& value) {
        TERRAY_TRY(readNumber(key, value, view_.fovDeg));
        if (view_.fovDeg < 0.01 || view_.fovDeg > 179)
            return bad(key, "must be 0.01 to 179 degrees");
        return {};
    }

    Result<void> readPlace(const std::string& key, const json& value, std::optional<Place>& out,
                           size_t least) const {
        if (!value.is_array() || value.size() < least || value.size() > 3) {
            return bad(key, least == 3 ? "must be [X, Y, Z] or [X, Y, \"+H\"]"
                                       : "must be [X, Y], [X, Y, Z] or [X, Y, \"+H\"]");
        }
        Place place;
        TERRAY_TRY(readNumber(key, value[0], place.x));
        TERRAY_TRY(readNumber(key, value[1], place.y));
        if (value.size() == 3) TERRAY_TRY(readHeight(key, value[2], place));
        out = place;
        return {};
    }

    /// A number, or a string "+H" for H metres above the ground.
    Result<void> readHeight(const std::string& key, const json& value, Place& place) const {
        double height = 0;
        if (value.is_string()) {
            const std::string text = value.get<std::string>();
            const json number = text.size() > 1 && text[0] == '+'
                                    ? json::parse(text.substr(1), nullptr, false)
                                    : json();
            if (!number.is_number() || !std::isfinite(number.get<double>())) {
                return bad(key, "has a Z that is neither metres nor \"+H\" above the ground");
            }
            height = number.get<double>();
            place.aboveGround = true;
        } else {
            TERRAY_TRY(readNumber(key, value, height));
        }
        place.z = height;
        return {};
    }

    Result<void> readProjection(const std::string& key, const json& value) {
        const std::string name = value.is_string() ? value.get<std::string>() : "";
        if (name == "perspective") {
            view_.projection = Projection::Perspective;
        } else if (name == "panorama") {
            view_.projection = Projection::Panorama;
        } else if (name == "ortho") {
            view_.projection = Projection::Ortho;
        } else {
            return bad(key, "must be \"perspective\", \"panorama\" or \"ortho\"");
        }
        return {};
    }

    Result<void> readSize(const std::string& key, const json& value) {
        const auto isSize = [](const json& v) {
            return v.is_number_integer() && v.get<double>() >= 1 && v.get<double>() <= 1e6;
        };
        if (!value.is_array() || value.size() != 2 || !isSize(value[0]) || !isSize(value[1])) {
            return bad(key, "must be [WIDTH, HEIGHT], 1 to 1000000 pixels each");
        }
        view_.width = value[0].get<int>();
        view_.height = value[1].get<int>();
        return {};
    }

    Result<void> readExtent(const std::string& key, const json& value) {
        if (!value.is_array() || value.size() != 4) {
            return bad(key, "must be [XMIN, YMIN, XMAX, YMAX]");
        }
        Extent extent;
        TERRAY_TRY(readNumber(key, value[0], extent.xMin));
        TERRAY_TRY(readNumber(key, value[1], extent.yMin));
        TERRAY_TRY(readNumber(key, value[2], extent.xMax));
        TERRAY_TRY(readNumber(key, value[3], extent.yMax));
        if (!(extent.xMin < extent.xMax && extent.yMin < extent.yMax)) {
            return bad(key, "is empty; give XMIN < XMAX and YMIN < YMAX");
        }
        view_.extent = extent;
        return {};
    }

    std::string path_;
    View view_;
};

Result<std::string> readText(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        return makeError(ErrorCode::Input, "camera file '{}' cannot be opened; check the name",
                         path);
    }
    std::string text(static_cast<size_t>(kMaxFileBytes), '\0');
    file.read(text.data(), kMaxFileBytes);
    if (file.bad() || file.gcount() == kMaxFileBytes || file.gcount() == 0) {
        return makeError(ErrorCode::Input,
                         "'{}' is no camera file; give a JSON object such as "
                         "{{\"eye\": [X, Y, Z], \"heading\": 90}}",
                         path);
    }
    text.resize(static_cast<size_t>(file.gcount()));
    return text;
}

}  // namespace

Result<View> readView(const std::string& path, View defaults) {
    Result<std::string> text = readText(path);
    if (!text) return text.error();
    const json object = json::parse(*text, nullptr, false);
    if (!object.is_object()) {
        return makeError(ErrorCode::Input,
                         "camera file '{}' is not a valid JSON object; check it with a JSON linter",
                         path);
    }
    return ViewReader(path, defaults).read(object);
}

}  // namespace terray
