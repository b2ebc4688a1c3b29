// SPDX-License-Identifier: Apache-2.0
// Where to stand so that a whole terrain fills the picture, looking a given way.
#pragma once

#include "view/camera.h"

namespace terray {

/// Moves the eye of a perspective camera, whose axes, size and field of view are set, so that the
/// box fills 85 % of the width (less where the height does not allow it), centred, with its top in
/// the upper quarter of the picture. Returns the share of the height that the box fills.
double frameBox(Camera& camera, const SceneBox& box);

/// Sets eye and size of an ortho camera, whose axes and picture size are set, so that the box just
/// fits; pixels are square. The eye is put before everything in the box.
void frameOrtho(Camera& camera, const SceneBox& box);

}  // namespace terray
