// SPDX-License-Identifier: Apache-2.0
// Inspection modes: a number of a hit as a colour, unlit. All functions are pure.
#pragma once

#include "shade/rules/colour.h"
#include "shade/shade.h"

namespace terray {

/// True for the modes that show light (photo, ramp, grid, light): they pass through the shoulder.
constexpr bool isLit(Shading shading) {
    return shading == Shading::Photo || shading == Shading::Ramp || shading == Shading::Grid ||
           shading == Shading::Light;
}

/// Colour of 0..1 on a perceptually even scale; display-linear.
rules::Rgb scaleColour(float v);
/// One of eight colours that neighbours tell apart.
rules::Rgb mipColour(int mip);
/// Slope in degrees: pale where flat, over ochre and red to dark purple where vertical.
rules::Rgb slopeColour(float degrees);
/// Steps of a ray, on a logarithmic scale from 1 to 1024.
rules::Rgb stepsColour(float steps);
/// Unit normal: 0.5 + 0.5 n as sRGB codes.
rules::Rgb normalColour(const glm::vec3& normal);
/// A grey of this sRGB value, 0..1.
rules::Rgb grey(float srgb);

}  // namespace terray
