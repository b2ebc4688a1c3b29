// SPDX-License-Identifier: Apache-2.0
// Exposure and colour of the light for any height of the sun.
#include "shade/light.h"

#include "shade/rules/lines.h"

namespace terray {

using rules::Rgb;

rules::Light makeLight(const Sun& sun) {
    constexpr Rgb kHighSun{1.00f, 0.95f, 0.86f}, kLowSun{1.00f, 0.80f, 0.58f};
    constexpr Rgb kSky{0.58f, 0.74f, 1.00f}, kDusk{0.46f, 0.58f, 0.95f};
    constexpr Rgb kGround{1.00f, 0.90f, 0.76f};
    // Level ground gets this much of each under a sun at 40 degrees; together 1.
    constexpr float kLevelSun = 0.82f, kLevelSky = 0.18f;
    rules::Light light;
    const auto sine = static_cast<float>(sun.towards.z);
    if (sun.belowHorizon || sine <= 0) {
        light.sky = kDusk * (0.42f / rules::luminance(kDusk));
        light.bounce = kGround * 0.05f;
        return light;
    }
    // Below 25 degrees the exposure no longer follows the sun down: evenings are darker than noon.
    const float facing = kLevelSun / std::max(sine, 0.42f);
    const Rgb colour = glm::mix(kLowSun, kHighSun, rules::smoothStep(0.0f, 0.4f, sine));
    light.sun = colour * (facing / rules::luminance(colour));
    const float sky = kLevelSky + 0.12f * (1.0f - rules::smoothStep(0.0f, 0.5f, sine));
    light.sky = kSky * (sky / rules::luminance(kSky));
    light.bounce = kGround * 0.17f;
    return light;
}

}  // namespace terray
