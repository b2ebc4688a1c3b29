// SPDX-License-Identifier: Apache-2.0
// Which sun lights a frame: by azimuth and elevation, by time, or the map maker's default.
#pragma once

#include <array>

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

/// The default sun of those pictures: azimuth, elevation.
std::array<double, 2> defaultSunAzElDeg(double azimuthDeg);

/// Azimuth and elevation that --time gives at a place; says so in a note.
Result<std::array<double, 2>> sunAzElDegAt(const GeoFrame& frame, Vec2 seen,
                                           const std::string& time);

}  // namespace terray
