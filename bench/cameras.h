// SPDX-License-Identifier: Apache-2.0
// The cameras of the measurements, placed on any terrain by the same rules.
#pragma once

#include <string>
#include <vector>

#include "stream/resident.h"
#include "view/camera.h"

namespace terray::bench {

struct NamedCamera {
    std::string name;
    View view;  ///< world metres
    Camera camera;
};

/// low50, mid500, high3000, down5000, valley, mountain: perspective, horizontal field of view 60
/// degrees.
std::vector<NamedCamera> speedCameras(const ResidentTerrain& terrain, int width, int height);
std::vector<std::string> speedCameraNames();

/// Two more for comparisons: mid500 rolled by 30 degrees, and one from outside the terrain.
std::vector<NamedCamera> sideCameras(const ResidentTerrain& terrain, int width, int height);

/// Six more for exactness: rolled, up, from outside, from under the ground, panorama, ortho.
std::vector<NamedCamera> oddCameras(const ResidentTerrain& terrain, int width, int height);

}  // namespace terray::bench
