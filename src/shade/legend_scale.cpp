// SPDX-License-Identifier: Apache-2.0
// Colours and labels of the legends, by shading.
#include "shade/legend_scale.h"

#include <algorithm>
#include <cmath>

#include "shade/haze.h"
#include "shade/modes.h"
#include "shade/ramp.h"

namespace terray {
namespace {

constexpr int kMostSteps = 1024;  // end of stepsColour()'s scale

Ink inkFromLinear(const rules::Rgb& colour) {
    Ink ink;
    for (int c = 0; c < 3; ++c) {
        const float code = rules::srgbFromLinear(std::clamp(colour[c], 0.0f, 1.0f)) * 255.0f;
        ink[static_cast<size_t>(c)] = static_cast<uint8_t>(code + 0.5f);
    }
    return ink;
}

/// Tints are in scene light: what they display as on ground that is fully lit.
Ink inkFromScene(const rules::Rgb& c) {
    return inkFromLinear(
        {rules::displayFromScene(c.r), rules::displayFromScene(c.g), rules::displayFromScene(c.b)});
}

/// Near is pale, far is dark: as the distance and depth shadings draw it.
rules::Rgb distanceColour(double share) {
    return grey(0.95f - 0.85f * std::clamp(static_cast<float>(share), 0.0f, 1.0f));
}

/// Two to eight round labels from low to high.
std::vector<LegendTick> roundTicks(double low, double high) {
    constexpr double kMostIntervals = 7;
    const double range = high - low;
    if (!(range > 0)) return {{0.5, fmt::format("{:.6g}", low)}};
    const double step = roundUp125(range / kMostIntervals);
    std::vector<LegendTick> ticks;
    for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
        const double value = k == 0 ? 0 : k * step;
        ticks.push_back({(value - low) / range, fmt::format("{:.6g}", value)});
    }
    return ticks;
}

LegendScale linearScale(std::string title, double low, double high,
                        std::function<Ink(double)> colourOfValue) {
    LegendScale scale;
    scale.title = std::move(title);
    scale.ticks = roundTicks(low, high);
    scale.colour = [=, ofValue = std::move(colourOfValue)](double position) {
        return ofValue(low + position * (high - low));
    };
    return scale;
}

LegendScale distanceScale(std::string word, const TerrainInfo& info, const RayFrame& rays) {
    const SceneReach reach = computeReach(rays.camera(), info, rays.exaggeration());
    const double nearest = static_cast<double>(reach.nearest);
    const double farthest = static_cast<double>(reach.farthest);
    const bool inKm = farthest >= 5000;
    const double unit = inKm ? 1000 : 1;
    return linearScale(
        word + (inKm ? ", km" : ", m"), nearest / unit, farthest / unit, [=](double value) {
            return inkFromLinear(
                distanceColour((value * unit - nearest) / std::max(farthest - nearest, 1e-3)));
        });
}

LegendScale mipScale(const TerrainInfo& info) {
    const int mips = info.scheme.mipCount();
    LegendScale scale;
    scale.title = "mip";
    for (int mip = 0; mip < mips; ++mip) {
        scale.ticks.push_back({(mip + 0.5) / mips, std::to_string(mip)});
    }
    scale.colour = [mips](double position) {
        return inkFromLinear(mipColour(std::clamp(static_cast<int>(position * mips), 0, mips - 1)));
    };
    return scale;
}

LegendScale stepsScale(std::string title) {
    const double decades = std::log2(kMostSteps);
    LegendScale scale;
    scale.title = std::move(title);
    for (int steps = 1; steps <= kMostSteps; steps *= 4) {
        scale.ticks.push_back({std::log2(steps) / decades, std::to_string(steps)});
    }
    scale.colour = [decades](double position) {
        return inkFromLinear(stepsColour(static_cast<float>(std::exp2(position * decades))));
    };
    return scale;
}

}  // namespace

double roundUp125(double value) {
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= value * (1 - 1e-9)) return factor * power;
    }
    return 10 * power;
}

double roundDown125(double value) {
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {10.0, 5.0, 2.0}) {
        if (factor * power <= value * (1 + 1e-9)) return factor * power;
    }
    return power;
}

std::optional<LegendScale> legendScale(Shading shading, const TerrainInfo& info,
                                       const RayFrame& rays, const HeightRamp* ramp) {
    const double low = static_cast<double>(info.minZ), high = static_cast<double>(info.maxZ);
    switch (shading) {
        case Shading::Ramp:
        case Shading::Grid:
            if (!ramp) return std::nullopt;
            return linearScale("m", low, high, [tints = *ramp](double height) {
                return inkFromScene(tints.at(static_cast<float>(height)).colour);
            });
        case Shading::Height:
            return linearScale("m", low, high, [=](double height) {
                const double range = std::max(high - low, 1e-3);
                return inkFromLinear(scaleColour(static_cast<float>((height - low) / range)));
            });
        case Shading::Slope:
            return linearScale("slope, \xC2\xB0", 0, 90, [](double degrees) {
                return inkFromLinear(slopeColour(static_cast<float>(degrees)));
            });
        case Shading::Distance: return distanceScale("distance", info, rays);
        case Shading::Depth: return distanceScale("depth", info, rays);
        case Shading::Mip: return mipScale(info);
        case Shading::Steps: return stepsScale("steps");
        case Shading::Shadow: return stepsScale("shadow steps");
        case Shading::Photo:
        case Shading::Hillshade:
        case Shading::Normal:
        case Shading::Light: break;
    }
    return std::nullopt;
}

}  // namespace terray
