// SPDX-License-Identifier: Apache-2.0
// Ranges of options. The ranges stand in `terray render --help` too.
#include "engine/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "device/devices.h"
#include "geo/sun.h"
#include "image/writer.h"
#include "technique/technique.h"
#include "view/camera.h"

namespace terray {
namespace {

/// Error unless value is finite and within [low, high].
Result<void> within(const char* option, double value, double low, double high,
                    const char* unit = "") {
    if (std::isfinite(value) && value >= low && value <= high) return {};
    return makeError(ErrorCode::Usage, "{}: {} is out of range; give {:g} to {:g}{}{}", option,
                     value, low, high, *unit != '\0' ? " " : "", unit);
}

Result<void> checkDeviceOption(const std::string& device) {
    const auto wish = parseDevice(device);
    return wish ? checkDevice(*wish) : wish.error();
}

Result<void> checkSun(const RenderOptions& options) {
    if (options.sunAzElDeg) {
        TERRAY_TRY(within("--sun azimuth", (*options.sunAzElDeg)[0], -360, 720, "degrees"));
        TERRAY_TRY(within("--sun elevation", (*options.sunAzElDeg)[1], -90, 90, "degrees"));
        if (!options.time.empty())
            return makeError(ErrorCode::Usage,
                             "--sun and --time both place the sun; give one of them");
    }
    if (options.time.empty()) return {};
    auto moment = parseIsoTime(options.time);
    if (!moment) return moment.error();
    return {};
}

Result<void> checkBackground(const std::string& background) {
    if (background == "sky" || background == "transparent") return {};
    const bool colour =
        background.size() == 7 && background[0] == '#' &&
        background.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    if (colour) return {};
    return makeError(ErrorCode::Usage,
                     "--background: '{}' is no background; give sky, transparent or "
                     "#rrggbb",
                     background);
}

}  // namespace

Result<void> checkView(const View& view) {
    TERRAY_TRY(within("--heading", view.headingDeg.value_or(0), -360, 720, "degrees"));
    TERRAY_TRY(within("--roll", view.rollDeg, -360, 360, "degrees"));
    if (view.eye && !view.eye->z)
        return makeError(ErrorCode::Usage,
                         "--eye: the height is missing; give X,Y,Z or X,Y,+H (H metres above the "
                         "ground)");
    // All else by making the camera over a box of nothing; heights above ground do not matter here.
    View anywhere = view;
    if (anywhere.eye) anywhere.eye->aboveGround = false;
    if (view.projection == Projection::Panorama && !view.eye) anywhere.eye = Place{0, 0, 1, false};
    if (anywhere.lookAt) {
        const bool free =
            !view.lookAt->z || view.lookAt->aboveGround || !view.eye || view.eye->aboveGround;
        anywhere.lookAt->aboveGround = false;
        if (free) anywhere.lookAt->z = anywhere.eye ? *anywhere.eye->z - 1 : 0;
    }
    SceneBox nothing;
    nothing.max = {1, 1, 1};
    auto camera = makeCamera(anywhere, nothing);
    if (!camera) return camera.error();
    return {};
}

Result<void> checkOptions(const View& view, const RenderOptions& o) {
    TERRAY_TRY(checkDeviceOption(o.device));
    if (auto technique = makeTechnique(o.technique); !technique) return technique.error();
    constexpr std::array kSamples{1, 2, 4, 8, 16};
    if (std::find(kSamples.begin(), kSamples.end(), o.samples) == kSamples.end())
        return makeError(ErrorCode::Usage, "--samples: {} is not possible; give 1, 2, 4, 8 or 16",
                         o.samples);
    TERRAY_TRY(within("--tolerance", o.tolerancePx, 0, 1000, "pixels"));
    TERRAY_TRY(within("--refraction", o.refraction, -1, 0.99));
    TERRAY_TRY(within("--exaggeration", o.exaggeration, 0.001, 1000));
    TERRAY_TRY(within("--haze", o.hazeKm.value_or(0), 0, 1e9, "km"));
    TERRAY_TRY(within("--contours", o.contoursM, 0, 1e6, "metres"));
    TERRAY_TRY(within("--relief-on-photo", o.reliefOnPhotoPercent, 0, 100, "percent"));
    TERRAY_TRY(checkSun(o));
    TERRAY_TRY(checkBackground(o.background));
    if (view.projection == Projection::Ortho && o.curvature.value_or(false))
        return makeError(ErrorCode::Usage,
                         "--curvature on: an ortho picture is a map, its rays are "
                         "parallel; leave it out");
    return {};
}

Result<void> checkOutputNames(const RenderOptions& options, const OutputOptions& outputs) {
    const bool words = options.legend || options.scaleBar || options.northArrow;
    if (words && isLinearFormat(outputs.path))
        return makeError(
            ErrorCode::Usage,
            "--legend, --scale-bar and --north-arrow are drawn on finished pictures, and "
            "'{}' holds linear light; write a .png, .jpg or .tif",
            outputs.path);
    std::set<std::string> seen;
    if (!outputs.path.empty()) seen.insert(outputs.path);
    for (const AovOutput& aov : outputs.aovs) {
        const auto dot = aov.path.rfind('.');
        const std::string ending = dot == std::string::npos ? "" : aov.path.substr(dot);
        if (ending != ".tif" && ending != ".tiff" && ending != ".exr")
            return makeError(ErrorCode::Usage,
                             "--aov: '{}' must end in .tif or .exr: floats are written", aov.path);
        if (!seen.insert(aov.path).second)
            return makeError(ErrorCode::Usage,
                             "--aov: '{}' is written twice; give each output its own file",
                             aov.path);
    }
    if (seen.empty())
        return makeError(ErrorCode::Usage,
                         "there is nothing to write; give -o FILE or --aov NAME=FILE");
    return {};
}

}  // namespace terray
