// SPDX-License-Identifier: Apache-2.0
// A flight as read, and as it runs over one terrain.
#pragma once

#include <memory>
#include <variant>

#include "engine/places.h"
#include "flight/flight_file.h"
#include "flight/path.h"
#include "flight/track_file.h"
#include "terray/flight.h"

namespace terray {

struct Flight::State {
    std::string path;
    FlightOptions options;
    std::string fingerprint;  ///< of the file's bytes
    std::variant<FlightFile, Track> content;
};

/// A flight over a terrain: the view of each moment. confined (maps coordinates back).
class FlightOver {
public:
    /// Says in notes and warnings what it assumed and what looks wrong (a camera underground).
    static Result<FlightOver> make(const Terrain::State& state, const Flight::State& flight,
                                   const RenderOptions& options);

    const FlightPath& path() const { return *path_; }
    /// In the data's CRS; true heights.
    Result<View> viewAt(double seconds) const;

private:
    FlightOver(PlaceResolver places, std::unique_ptr<FlightPath> path)
        : places_(std::move(places)), path_(std::move(path)) {}

    PlaceResolver places_;
    std::unique_ptr<FlightPath> path_;
};

/// Sun and haze of a whole flight in place of what each view would derive; said in notes.
Result<RenderOptions> settledLook(const Terrain::State& state, const FlightOver& flight,
                                  const RenderOptions& options);

}  // namespace terray
