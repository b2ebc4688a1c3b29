// SPDX-License-Identifier: Apache-2.0
// The cameras of the measurements, placed on any terrain by the same rules.
#pragma once

#include <string>
#include <vector>

#include "scene.h"
#include "view/camera.h"

namespace terray::bench {

struct NamedCamera {
    std::string name;
    Camera camera;
};

/// low50, mid500, high3000, down5000, valley, mountain: perspective, horizontal field of view 60
/// degrees.
std::vector<NamedCamera> speedCameras(const Scene& scene, int width, int height);

/// Two more for comparisons: mid500 rolled by 30 degrees, and one from outside the terrain.
std::vector<NamedCamera> sideCameras(const Scene& scene, int width, int height);

/// Six more for exactness: rolled, up, from outside, from under the ground, panorama, ortho.
std::vector<NamedCamera> oddCameras(const Scene& scene, int width, int height);

}  // namespace terray::bench
