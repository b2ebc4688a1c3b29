// SPDX-License-Identifier: Apache-2.0
// The frame's light from its sun: how strong and how warm sun, sky and bounced light are.
#pragma once

#include "shade/rules/light.h"
#include "shade/shade.h"

namespace terray {

/// Plain ground.
inline const rules::Rgb kClay = rules::sceneFromCodes(217, 215, 211);

/// Sun to sky about 4 : 1 on level ground under the default sun; a low sun is warmer and leaves
/// more to the sky; below the horizon only dusk light is left, still readable.
rules::Light makeLight(const Sun& sun);

}  // namespace terray
