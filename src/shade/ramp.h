// SPDX-License-Identifier: Apache-2.0
// Height to tint: built-in hypsometric ramps that adapt to the data, and GDAL colour text files.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "shade/batch.h"
#include "shade/rules/colour.h"
#include "shade/shade.h"

namespace terray {

/// What a ramp has to know of the heights that it colours.
struct HeightSurvey {
    float minZ = 0, maxZ = 0;       ///< metres
    std::vector<float> cumulative;  ///< share of the ground below minZ + k/(n-1) * (maxZ - minZ)
    bool sea = false;               ///< 0 is plausibly the level of a sea
    bool town = false;              ///< walls: low relief with many cliffs of small cells
};
/// A grid of heights to survey (NaN: hole).
struct SurveyGrid {
    std::span<const float> heights;  ///< row by row
    int width = 0;
    double cell = 1;  ///< metres between posts
    float minZ = 0, maxZ = 0;
    bool hasCrs = false;  ///< without one, 0 is never taken for a sea
};
HeightSurvey surveyHeights(const SurveyGrid& grid);

/// A colour for a height, in scene-linear light.
struct Tint {
    rules::Rgb colour{0.0f};
    float rock = 0;   ///< how far steep ground of this tint leans to rock grey, 0..1
    float cover = 1;  ///< alpha of colour files
};

/// One line of a GDAL colour text file, or one stop of a legend.
struct ColourStop {
    double height = 0;
    float r = 0, g = 0, b = 0, a = 255;  ///< 8-bit sRGB
};
/// Reads the text of a GDAL color-relief file: `value r g b [a]` or `value name`, values may be
/// percentages of the range, `nv` or `default`. Stops come back sorted. `path` is for messages.
Result<std::vector<ColourStop>> parseColourText(const std::string& text, const std::string& path,
                                                double minZ, double maxZ);

/// Height to tint by table. const-shared.
class HeightRamp {
public:
    /// A built-in name, a file's path, or empty: chosen by the survey. Errors: Usage, Input.
    static Result<HeightRamp> make(const std::string& nameOrFile, const HeightSurvey& survey);
    static HeightRamp fromStops(std::span<const ColourStop> stops, float minZ, float maxZ);

    Tint at(float height) const;
    float minZ() const { return minZ_; }
    float maxZ() const { return maxZ_; }

private:
    friend class TintTable;
    /// A quarter of a metre keeps beaches of whole-metre data from growing a pixel into the land.
    static constexpr float kShore = 0.25f;
    struct Table {
        float from = 0, perMetre = 0;
        std::vector<Tint> tints;
        Tint at(float height) const;
    };
    Table land_, sea_;  ///< sea_ is empty unless the survey says sea
    float minZ_ = 0, maxZ_ = 1;
};

/// A ramp on ground of one colour, as batches read it: 16-bit fixed point, linear between entries.
/// const-shared.
class TintTable {
public:
    /// `bare` shows where a colour file's ramp has no cover.
    TintTable(const HeightRamp& ramp, const rules::Rgb& bare);
    void at(const Floats& height, FloatsRgb& colour, Floats& rock) const;

private:
    struct Part {
        float from = 0, perMetre = 0, last = 0;
        int32_t first = 0;
    };
    Part append(const HeightRamp::Table& table, const rules::Rgb& bare);
    std::vector<uint16_t> codes_;  ///< r, g, b, rock
    Part land_, sea_;
    float shore_;  ///< below it the sea's part holds
};

}  // namespace terray
