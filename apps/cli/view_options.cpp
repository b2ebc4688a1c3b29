// SPDX-License-Identifier: Apache-2.0
// Camera flags.
#include <array>

#include "options.h"
#include "parse.h"

namespace terray::cli {
namespace {

constexpr std::array<std::pair<const char*, Projection>, 3> kProjections{
    {{"perspective", Projection::Perspective},
     {"panorama", Projection::Panorama},
     {"ortho", Projection::Ortho}}};

constexpr const char* kCamera = "Camera";

}  // namespace

void ViewOptions::addTo(CLI::App& command) {
    const auto number = [&](const char* name, const char* value, const char* help,
                            std::optional<double>& target) {
        addText(command, kCamera, name, value, help,
                [name, &target](const std::string& text) { target = parseNumber(name, text); });
    };
    addText(command, kCamera, "--size", "WxH", "pixels (default 1920x1080)",
            [this](const std::string& text) { size = parseSize("--size", text); });
    addText(command, kCamera, "--projection", "NAME",
            "perspective (default), panorama (360 degrees wide) or ortho (a map)",
            [this](const std::string& text) {
                projection = parseName("--projection", text, kProjections);
            });
    addText(
        command, kCamera, "--eye", "X,Y,Z",
        "where to look from, in the data's CRS; Z in metres, or +H above the ground (default: the "
        "whole terrain from the south-south-west)",
        [this](const std::string& text) { eye = parsePlace("--eye", text); });
    addText(command, kCamera, "--look-at", "X,Y[,Z]",
            "the place in the middle (default Z: the ground)",
            [this](const std::string& text) { lookAt = parsePlace("--look-at", text); });
    number("--heading", "DEG", "clockwise from grid north", headingDeg);
    number("--pitch", "DEG", "up positive, down negative: -90 to 90", pitchDeg);
    number("--roll", "DEG", "clockwise: right side down", rollDeg);
    number("--fov", "DEG", "vertical field of view, 0.01 to 179 (default 45)", fovDeg);
    addText(command, kCamera, "--extent", "XMIN,YMIN,XMAX,YMAX",
            "what an ortho picture shows (default: all)", [this](const std::string& text) {
                const auto v = parseNumbers("--extent", text, 4);
                extent = Extent{v[0], v[1], v[2], v[3]};
            });
    addSwitch(command, kCamera, "--lonlat", "X,Y are degrees of longitude and latitude", lonLat);
    addText(command, kCamera, "--camera", "FILE.json",
            "all of these from a file; flags win over it",
            [this](const std::string& text) { file = text; });
}

View ViewOptions::resolve() const {
    View view = file.empty() ? View{} : valueOf(readView(file));
    if (size) std::tie(view.width, view.height) = *size;
    if (projection) view.projection = *projection;
    if (eye) view.eye = eye;
    if (lookAt && (headingDeg || pitchDeg))
        failUsage("--look-at does not go with --heading and --pitch; give one or the other");
    if (lookAt) {
        view.lookAt = lookAt;
        view.headingDeg = view.pitchDeg = std::nullopt;
    }
    if (headingDeg || pitchDeg) view.lookAt = std::nullopt;
    if (headingDeg) view.headingDeg = headingDeg;
    if (pitchDeg) view.pitchDeg = pitchDeg;
    if (rollDeg) view.rollDeg = *rollDeg;
    if (fovDeg) view.fovDeg = *fovDeg;
    if (extent) view.extent = extent;
    if (lonLat) view.lonLat = true;
    const char* name = view.projection == Projection::Ortho ? "ortho" : "panorama";
    if (fovDeg && view.projection != Projection::Perspective)
        failUsage(fmt::format("--fov does not go with --projection {}; leave it out", name));
    if (rollDeg && view.projection == Projection::Panorama)
        failUsage("--roll does not go with --projection panorama; leave it out");
    return view;
}

}  // namespace terray::cli
