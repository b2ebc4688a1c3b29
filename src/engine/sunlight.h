// SPDX-License-Identifier: Apache-2.0
// Which sun lights a frame: by azimuth and elevation, by time, or the map maker's default.
#pragma once

#include "engine/places.h"
#include "shade/shade.h"
#include "view/camera.h"

namespace terray {

/// Azimuths are from true north; the meridian convergence at the terrain's centre is taken off.
/// `seen`: the place that --time is for. Says in a note what --time gives.
Result<Sun> computeSun(const Terrain::State& state, const GeoFrame& frame, const Camera& camera,
                       Vec2 seen, const RenderOptions& options);

/// Azimuth of the default sun, degrees: 315, or 45 for pictures that look to the south so that
/// slopes stay modelled.
double defaultSunAzimuthDeg(const Camera& camera);

}  // namespace terray
