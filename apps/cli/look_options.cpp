// SPDX-License-Identifier: Apache-2.0
// Look, surface and technique flags.
#include "names.h"
#include "options.h"
#include "parse.h"

namespace terray::cli {
namespace {

constexpr const char* kLook = "Look";
constexpr const char* kSurface = "Surface";
constexpr const char* kTechnique = "Technique";

void addLight(CLI::App& command, RenderOptions& render) {
    addText(command, kLook, "--sun", "AZ,EL",
            "the sun: azimuth from true north, elevation, degrees",
            [&render](const std::string& text) {
                const auto v = parseNumbers("--sun", text, 2);
                render.sunAzElDeg = {{v[0], v[1]}};
            });
    addText(
        command, kLook, "--time", "ISO8601",
        "the sun of that moment at the place seen, as 2024-06-21T08:30:00Z (UTC unless an offset "
        "is given)",
        [&render](const std::string& text) { render.time = text; });
    addText(command, kLook, "--shadows", "on|off", "ray-cast shadows (default on)",
            [&render](const std::string& text) { render.shadows = parseOnOff("--shadows", text); });
    addText(command, kLook, "--haze", "KM", "visual range, 0 = none (default: by the scene)",
            [&render](const std::string& text) { render.hazeKm = parseNumber("--haze", text); });
    addText(command, kLook, "--background", "NAME", "sky (default), transparent or #rrggbb",
            [&render](const std::string& text) { render.background = text; });
}

void addDecoration(CLI::App& command, RenderOptions& render) {
    addText(
        command, kLook, "--contours", "M", "contour lines every M metres",
        [&render](const std::string& text) { render.contoursM = parseNumber("--contours", text); });
    addSwitch(command, kLook, "--legend", "draw a legend", render.legend);
    addSwitch(command, kLook, "--scale-bar", "draw a scale bar", render.scaleBar);
    addSwitch(command, kLook, "--north-arrow", "draw a north arrow", render.northArrow);
    addSwitch(command, kLook, "--base", "draw a plain plinth under the terrain", render.base);
}

void addSurface(CLI::App& command, RenderOptions& render) {
    addText(command, kSurface, "--surface", "NAME", "bilinear (default) or constant",
            [&render](const std::string& text) {
                render.surface = parseName("--surface", text, kSurfaces);
            });
    addText(command, kSurface, "--tolerance", "PX",
            "largest error on the screen, pixels; 0 = always finest (default 2/3)",
            [&render](const std::string& text) {
                render.tolerancePx = parseNumber("--tolerance", text);
            });
    addText(
        command, kSurface, "--curvature", "on|off", "of the globe (default: on with a CRS)",
        [&render](const std::string& text) { render.curvature = parseOnOff("--curvature", text); });
    addText(command, kSurface, "--refraction", "K", "of the air (default 0.13)",
            [&render](const std::string& text) {
                render.refraction = parseNumber("--refraction", text);
            });
    addText(command, kSurface, "--exaggeration", "X", "of heights, 0.001 to 1000 (default 1)",
            [&render](const std::string& text) {
                render.exaggeration = parseNumber("--exaggeration", text);
            });
}

}  // namespace

void LookOptions::addTo(CLI::App& command) {
    addText(
        command, kLook, "--shading", "NAME",
        "how the ground is coloured, see 'terray shadings' (default: photo if there is one, else "
        "ramp)",
        [this](const std::string& text) {
            render.shading = parseName("--shading", text, kShadings);
        });
    addText(command, kLook, "--ramp", "NAME|FILE",
            "colours by height: a name of 'terray shadings' or a GDAL colour text file",
            [this](const std::string& text) { render.ramp = text; });
    addText(command, kLook, "--relief-on-photo", "PERCENT",
            "light on photos, 0 to 100 (default 50)", [this](const std::string& text) {
                render.reliefOnPhotoPercent = parseNumber("--relief-on-photo", text);
                needsPhoto = "--relief-on-photo";
            });
    addLight(command, render);
    addDecoration(command, render);
    addSurface(command, render);
    addSwitch(command, kSurface, "--allow-missing",
              "draw a coarser tile where one of a store cannot be read", render.allowMissing);
    addText(command, kTechnique, "--technique", "NAME",
            "see 'terray techniques' (default ray_cast)",
            [this](const std::string& text) { render.technique = text; });
    addText(command, kTechnique, "--device", "NAME",
            "auto (default: the CPU), cpu, vulkan or vulkan:N, see 'terray devices'",
            [this](const std::string& text) { render.device = text; });
    addText(command, kTechnique, "--samples", "N", "rays a pixel: 1, 2, 4 (default), 8 or 16",
            [this](const std::string& text) { render.samples = parseInteger("--samples", text); });
}

void LookOptions::checkPhoto(const SourceInfo& info) const {
    if (!needsPhoto.empty() && info.photo.empty()) {
        failUsage(needsPhoto + " needs a photo: give --photo, or a store that has one");
    }
}

}  // namespace terray::cli
