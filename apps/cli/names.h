// SPDX-License-Identifier: Apache-2.0
// Names of surfaces, shadings and buffers on the command line.
#pragma once

#include <array>
#include <utility>

#include "terray/options.h"

namespace terray::cli {

inline constexpr std::array<std::pair<const char*, Surface>, 2> kSurfaces{
    {{"bilinear", Surface::Bilinear}, {"constant", Surface::Constant}}};

inline constexpr std::array<std::pair<const char*, Shading>, 13> kShadings{
    {{"photo", Shading::Photo},
     {"ramp", Shading::Ramp},
     {"hillshade", Shading::Hillshade},
     {"normal", Shading::Normal},
     {"slope", Shading::Slope},
     {"height", Shading::Height},
     {"depth", Shading::Depth},
     {"distance", Shading::Distance},
     {"mip", Shading::Mip},
     {"steps", Shading::Steps},
     {"shadow-steps", Shading::Shadow},
     {"grid", Shading::Grid},
     {"light", Shading::Light}}};

inline constexpr std::array<std::pair<const char*, Aov>, 9> kAovs{{{"distance", Aov::Distance},
                                                                   {"depth", Aov::Depth},
                                                                   {"position", Aov::Position},
                                                                   {"normal", Aov::Normal},
                                                                   {"height", Aov::Height},
                                                                   {"mip", Aov::Mip},
                                                                   {"steps", Aov::Steps},
                                                                   {"shadow", Aov::Shadow},
                                                                   {"error", Aov::Error}}};

}  // namespace terray::cli
