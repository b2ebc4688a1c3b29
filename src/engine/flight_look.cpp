// SPDX-License-Identifier: Apache-2.0
// Sun and haze settled for a whole flight, so that nothing flickers or breathes.
#include <cmath>
#include <cstdlib>

#include "base/log.h"
#include "engine/flight_state.h"
#include "engine/frame.h"
#include "engine/sunlight.h"
#include "shade/haze.h"

namespace terray {
namespace {

constexpr int kLooks = 64;  ///< moments that are asked, evenly spaced

/// What the views along a flight would choose.
struct Wishes {
    int fromNorthEast = 0;
    double extinction = 0;  ///< mean, per metre
};

Result<Wishes> wishesOf(const Terrain::State& state, const FlightOver& flight,
                        const RenderOptions& options) {
    Wishes wishes;
    const TerrainInfo& info = state.resident->info();
    ShadeSettings settings;
    settings.options = options;
    for (int k = 0; k < kLooks; ++k) {
        auto view = flight.viewAt(std::lerp(flight.path().begin(), flight.path().end(),
                                            k / static_cast<double>(kLooks - 1)));
        if (!view) return view.error();
        auto placed = placeView(state, *view, options);
        if (!placed) return placed.error();
        wishes.fromNorthEast += defaultSunAzimuthDeg(placed->camera) < 180 ? 1 : 0;
        const SceneReach reach = computeReach(placed->camera, info, options.exaggeration);
        const rules::Air air = makeAir(reach, placed->camera, settings);
        // The far edge keeps its contrast although the haze now begins at the eye.
        const double share = 1 - static_cast<double>(air.start) / reach.farthest;
        wishes.extinction += static_cast<double>(air.extinction) * std::max(share, 0.0) / kLooks;
    }
    return wishes;
}

}  // namespace

Result<RenderOptions> settledLook(const Terrain::State& state, const FlightOver& flight,
                                  const RenderOptions& options) {
    constexpr double kVisual = 3.912023;  // contrast of 2 % at the visual range
    RenderOptions settled = options;
    const bool sunGiven = options.sunAzElDeg.has_value() || !options.time.empty();
    if (!options.time.empty()) {
        auto frame = state.makeGeoFrame();
        if (!frame) return frame.error();
        auto sun = sunAzElDegAt(*frame, state.worldCentre(), options.time);
        if (!sun) return sun.error();
        settled.sunAzElDeg = *sun;
        settled.time.clear();
    }
    if (sunGiven && options.hazeKm) return settled;
    auto wishes = wishesOf(state, flight, settled);
    if (!wishes) return wishes.error();
    if (!sunGiven) {
        settled.sunAzElDeg = defaultSunAzElDeg(wishes->fromNorthEast * 2 > kLooks ? 45 : 315);
        log::note("the sun of the whole flight: --sun {:g},{:g}", (*settled.sunAzElDeg)[0],
                  (*settled.sunAzElDeg)[1]);
    }
    if (!options.hazeKm) {
        const double km = wishes->extinction > 0 ? kVisual / wishes->extinction * 1e-3 : 0.0;
        const std::string rounded = fmt::format("{:.3g}", km);  // what is said is what is used
        settled.hazeKm = std::strtod(rounded.c_str(), nullptr);
        log::note("the haze of the whole flight: --haze {}", rounded);
    }
    return settled;
}

}  // namespace terray
