// SPDX-License-Identifier: Apache-2.0
// Names of height units as GDAL drivers, netCDF files and vertical CRSs write them.
#include "raster/height_unit.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace terray {
namespace {

constexpr double kFoot = 0.3048;
constexpr double kUsSurveyFoot = 1200.0 / 3937.0;

struct Alias {
    std::string_view text;
    std::string_view name;
    double metres;
};
constexpr std::array kAliases{
    Alias{"m", "m", 1},
    Alias{"metre", "m", 1},
    Alias{"metres", "m", 1},
    Alias{"meter", "m", 1},
    Alias{"meters", "m", 1},
    Alias{"ft", "ft", kFoot},
    Alias{"foot", "ft", kFoot},
    Alias{"feet", "ft", kFoot},
    Alias{"internationalfoot", "ft", kFoot},
    Alias{"usft", "us-ft", kUsSurveyFoot},
    Alias{"ftus", "us-ft", kUsSurveyFoot},
    Alias{"sft", "us-ft", kUsSurveyFoot},
    Alias{"ussurveyfoot", "us-ft", kUsSurveyFoot},
    Alias{"ussurveyfeet", "us-ft", kUsSurveyFoot},
    Alias{"footus", "us-ft", kUsSurveyFoot},
    Alias{"feetus", "us-ft", kUsSurveyFoot},
    Alias{"footussurvey", "us-ft", kUsSurveyFoot},
    Alias{"surveyfoot", "us-ft", kUsSurveyFoot},
    Alias{"km", "km", 1000},
    Alias{"kilometre", "km", 1000},
    Alias{"kilometer", "km", 1000},
    Alias{"dm", "dm", 0.1},
    Alias{"decimetre", "dm", 0.1},
    Alias{"decimeter", "dm", 0.1},
    Alias{"cm", "cm", 0.01},
    Alias{"centimetre", "cm", 0.01},
    Alias{"centimeter", "cm", 0.01},
    Alias{"mm", "mm", 0.001},
    Alias{"millimetre", "mm", 0.001},
    Alias{"millimeter", "mm", 0.001},
};

}  // namespace

HeightUnitFacts describeHeightUnit(HeightUnit unit) {
    switch (unit) {
        case HeightUnit::Foot: return {"ft", kFoot};
        case HeightUnit::UsSurveyFoot: return {"us-ft", kUsSurveyFoot};
        case HeightUnit::Metre: break;
    }
    return {"m", 1};
}

std::optional<HeightUnitFacts> parseHeightUnit(std::string_view text) {
    std::string key;  // letters only, so that "US_survey_foot", "Foot (US survey)", "us-ft" agree
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalpha(byte) != 0) key += static_cast<char>(std::tolower(byte));
    }
    const auto found = std::find_if(kAliases.begin(), kAliases.end(),
                                    [&](const Alias& alias) { return alias.text == key; });
    if (found == kAliases.end()) return std::nullopt;
    return HeightUnitFacts{std::string(found->name), found->metres};
}

}  // namespace terray
