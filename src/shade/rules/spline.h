// SPDX-License-Identifier: Apache-2.0
// Weights of the uniform cubic B-spline: smooth normals between posts, exact on paraboloids.
#pragma once

namespace terray::rules {

/// Value and slope weights of the four posts -1, 0, 1, 2 around the place f in 0..1.
struct SplineWeights {
    float value[4], slope[4];
};

inline SplineWeights splineWeights(float f) {
    const float g = 1.0f - f, f2 = f * f, f3 = f2 * f;
    constexpr float kSixth = 1.0f / 6.0f;
    return {{g * g * g * kSixth, (3.0f * f3 - 6.0f * f2 + 4.0f) * kSixth,
             (-3.0f * f3 + 3.0f * f2 + 3.0f * f + 1.0f) * kSixth, f3 * kSixth},
            {-0.5f * g * g, 0.5f * (3.0f * f2 - 4.0f * f), 0.5f * (-3.0f * f2 + 2.0f * f + 1.0f),
             0.5f * f2}};
}

}  // namespace terray::rules
