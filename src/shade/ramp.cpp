// SPDX-License-Identifier: Apache-2.0
// Surveys the heights and spreads a ramp's stops over them, half by quantiles, half linearly, so
// that flat and alpine terrains both use the whole ramp.
#include "shade/ramp.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "shade/ramp_builtin.h"
#include "shade/rules/lines.h"

namespace terray {
namespace {

constexpr int kBins = 1024;
constexpr size_t kTableSize = 4096;

/// Cumulative shares from a histogram whose peaks (lakes, plains) are cut so that no single height
/// takes a large part of the ramp, smoothed over about one percent of the range.
std::vector<float> cumulativeShares(std::vector<double> bins) {
    double total = 0;
    int used = 0;
    for (double b : bins) total += b, used += b > 0;
    if (total <= 0) return {0.0f, 1.0f};
    const double most = 4.0 * total / std::max(used, 1);
    for (double& b : bins) b = std::min(b, most);
    constexpr int kReach = kBins / 200;
    std::vector<double> smooth(bins.size(), 0.0);
    for (int k = 0; k < kBins; ++k)
        for (int d = -kReach; d <= kReach; ++d)
            smooth[static_cast<size_t>(k)] +=
                bins[static_cast<size_t>(std::clamp(k + d, 0, kBins - 1))];
    std::vector<float> shares{0.0f};
    double sum = 0, all = 0;
    for (double s : smooth) all += s;
    for (double s : smooth) shares.push_back(static_cast<float>((sum += s) / all));
    return shares;
}

/// Sea, not a dry depression: flat water at exactly 0 lies in the data (radar and lidar sets), or
/// they go deeper than any dry land does (the shore of the Dead Sea is at -430 m).
bool looksLikeSea(const SurveyGrid& grid) {
    const std::span<const float> heights = grid.heights;
    const int width = grid.width;
    if (grid.minZ < -450.0f) return true;
    if (grid.minZ > 0.0f) return false;
    size_t flat = 0, valid = 0;
    for (size_t k = static_cast<size_t>(width) + 1; k < heights.size(); ++k) {
        if (std::isnan(heights[k])) continue;
        ++valid;
        flat += std::abs(heights[k]) < 0.01f && std::abs(heights[k - 1]) < 0.01f &&
                std::abs(heights[k - static_cast<size_t>(width)]) < 0.01f;
    }
    return static_cast<double>(flat) > 0.003 * static_cast<double>(valid) && grid.maxZ > 20.0f;
}

/// Houses and trees: a few metres apart, cliffs are common although the relief is low.
bool looksLikeTown(const SurveyGrid& grid) {
    constexpr double kLargestCell = 6.0;
    if (grid.cell > kLargestCell || grid.maxZ - grid.minZ > 300.0f) return false;
    size_t steps = 0, cliffs = 0;
    const auto steepest = static_cast<float>(grid.cell);  // 45 degrees
    for (size_t k = 1; k < grid.heights.size(); ++k) {
        const float rise = std::abs(grid.heights[k] - grid.heights[k - 1]);
        steps += !std::isnan(rise);
        cliffs += rise > steepest;
    }
    return static_cast<double>(cliffs) > 0.03 * static_cast<double>(steps);
}

float shareBelow(const std::vector<float>& cumulative, float position) {
    const float x = std::clamp(position, 0.0f, 1.0f) * static_cast<float>(cumulative.size() - 1);
    const size_t k = std::min(static_cast<size_t>(x), cumulative.size() - 2);
    const float f = x - static_cast<float>(k);
    return cumulative[k] + f * (cumulative[k + 1] - cumulative[k]);
}

Tint stopTint(std::span<const RampStop> stops, float position) {
    size_t k = 1;
    while (k + 1 < stops.size() && stops[k].at < position) ++k;
    const RampStop &a = stops[k - 1], &b = stops[k];
    const float f = std::clamp((position - a.at) / (b.at - a.at), 0.0f, 1.0f);
    const auto mix = [f](float from, float to) { return from + f * (to - from); };
    return {rules::sceneFromCodes(mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)), mix(a.rock, b.rock),
            1.0f};
}

/// Ramp position 0..1 of a height between two ends.
struct Spread {
    const HeightSurvey& survey;
    float from, to, quantiles, reach;
    float survey01(float z) const {
        return (z - survey.minZ) / std::max(survey.maxZ - survey.minZ, 1e-6f);
    }
    float operator()(float z) const {
        const float linear = std::clamp((z - from) / std::max(to - from, 1e-6f), 0.0f, 1.0f);
        const float low = shareBelow(survey.cumulative, survey01(from));
        const float high = shareBelow(survey.cumulative, survey01(to));
        const float share =
            (shareBelow(survey.cumulative, survey01(z)) - low) / std::max(high - low, 1e-6f);
        return reach * (linear + quantiles * (std::clamp(share, 0.0f, 1.0f) - linear));
    }
};

/// How far up the ramp the tops reach: low hills end in beige, high relief in rock, and only
/// mountains that are high themselves in snow.
float snowReach(float relief, float top) {
    return 0.58f + 0.26f * rules::smoothStep(150.0f, 1200.0f, relief) +
           0.16f * rules::smoothStep(1000.0f, 2200.0f, relief) *
               rules::smoothStep(2200.0f, 3600.0f, top);
}

Result<std::string> readSmallFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return makeError(ErrorCode::Input,
                         "'{}' is neither a built-in ramp nor a readable colour text file; "
                         "`terray shadings` lists the built-in ramps",
                         path);
    constexpr std::streamsize kMost = 1 << 20;
    std::string text(static_cast<size_t>(kMost) + 1, '\0');
    file.read(text.data(), kMost + 1);
    if (file.bad())
        return makeError(ErrorCode::Input, "'{}' cannot be read; give a colour text file", path);
    if (file.gcount() > kMost)
        return makeError(ErrorCode::Input,
                         "'{}' is too large for a colour text file (1 MiB at most)", path);
    text.resize(static_cast<size_t>(file.gcount()));
    return text;
}

}  // namespace

HeightSurvey surveyHeights(const SurveyGrid& grid) {
    HeightSurvey survey;
    survey.minZ = grid.minZ;
    survey.maxZ = grid.maxZ;
    survey.sea = grid.hasCrs && looksLikeSea(grid);
    // Without a CRS a pixel may be any size and a height any unit.
    survey.town = grid.hasCrs && looksLikeTown(grid);
    std::vector<double> bins(kBins, 0.0);
    const float scale = static_cast<float>(kBins) / std::max(grid.maxZ - grid.minZ, 1e-6f);
    for (float z : grid.heights) {
        if (std::isnan(z)) continue;
        const int bin = std::clamp(static_cast<int>((z - grid.minZ) * scale), 0, kBins - 1);
        bins[static_cast<size_t>(bin)] += 1;
    }
    survey.cumulative = cumulativeShares(std::move(bins));
    return survey;
}

Tint HeightRamp::Table::at(float height) const {
    const float last = static_cast<float>(tints.size() - 1);
    const float x = std::clamp((height - from) * perMetre, 0.0f, last);
    const size_t k = std::min(static_cast<size_t>(x), tints.size() - 2);
    const float f = x - static_cast<float>(k);
    const Tint &a = tints[k], &b = tints[k + 1];
    return {a.colour + f * (b.colour - a.colour), a.rock + f * (b.rock - a.rock),
            a.cover + f * (b.cover - a.cover)};
}

Tint HeightRamp::at(float height) const {
    if (!sea_.tints.empty() && height < kShore) return sea_.at(height);
    return land_.at(height);
}

Result<HeightRamp> HeightRamp::make(const std::string& nameOrFile, const HeightSurvey& survey) {
    const BuiltinRamp* ramp = findBuiltinRamp(!nameOrFile.empty() ? nameOrFile
                                              : survey.town       ? "paper"
                                                                  : "natural");
    if (!ramp) {
        auto text = readSmallFile(nameOrFile);
        if (!text) return text.error();
        auto stops = parseColourText(*text, nameOrFile, survey.minZ, survey.maxZ);
        if (!stops) return stops.error();
        return fromStops(*stops, survey.minZ, survey.maxZ);
    }
    const auto fill = [&](std::span<const RampStop> stops, float from, float to, float reach) {
        Table table;
        const Spread spread{survey, from, to, ramp->quantiles, reach};
        const float step = std::max(to - from, 1e-3f) / static_cast<float>(kTableSize - 1);
        table.from = from;
        table.perMetre = 1.0f / step;
        for (size_t k = 0; k < kTableSize; ++k)
            table.tints.push_back(stopTint(stops, spread(from + static_cast<float>(k) * step)));
        return table;
    };
    HeightRamp result;
    result.minZ_ = survey.minZ;
    result.maxZ_ = survey.maxZ;
    const bool sea = (survey.sea || ramp->zeroIsSea) && !ramp->sea.empty() && survey.minZ <= 0;
    const float lowest = sea ? 0.0f : survey.minZ;
    const float relief = std::max(survey.maxZ - lowest, 0.0f);
    const float reach = ramp->reservesSnow ? snowReach(relief, survey.maxZ) : 1.0f;
    result.land_ = fill(ramp->land, lowest, std::max(survey.maxZ, lowest), reach);
    if (sea) {
        // Shallow seas stay pale: the deepest blue needs some hundred metres of water.
        const float depth = std::max(-survey.minZ, 200.0f);
        result.sea_ = fill(ramp->sea, -depth, 0.0f, 1.0f);
    }
    return result;
}

HeightRamp HeightRamp::fromStops(std::span<const ColourStop> stops, float minZ, float maxZ) {
    HeightRamp ramp;
    ramp.minZ_ = minZ;
    ramp.maxZ_ = maxZ;
    const double step = std::max(static_cast<double>(maxZ) - minZ, 1e-3) / (kTableSize - 1);
    ramp.land_.from = minZ;
    ramp.land_.perMetre = static_cast<float>(1.0 / step);
    for (size_t k = 0; k < kTableSize; ++k) {
        const double z = minZ + static_cast<double>(k) * step;
        const auto after = std::upper_bound(
            stops.begin(), stops.end(), z,
            [](double height, const ColourStop& stop) { return height < stop.height; });
        const ColourStop& a = after == stops.begin() ? stops.front() : *(after - 1);
        const ColourStop& b = after == stops.end() ? stops.back() : *after;
        const double run = b.height - a.height;
        const float f =
            run > 0 ? std::clamp(static_cast<float>((z - a.height) / run), 0.f, 1.f) : 0;
        const auto mix = [f](float from, float to) { return from + f * (to - from); };
        ramp.land_.tints.push_back(
            {rules::sceneFromCodes(mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)), 0.0f,
             mix(a.a, b.a) / 255.0f});
    }
    return ramp;
}

}  // namespace terray
