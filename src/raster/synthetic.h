// SPDX-License-Identifier: Apache-2.0
// Synthetic terrains: seeded, the same on every machine, made on demand; for tests and benches.
#pragma once

#include <memory>
#include <string>

#include "tile/height_source.h"

namespace terray {

struct SyntheticOptions {
    int64_t columns = 1024, rows = 1024;  ///< posts
    double cell = 10;                     ///< metres
    uint32_t seed = 1;
    PostFormat format = PostFormat::Float32;
};

/// The fractal of the speed measurements: ridges of 10 km and smaller, rough down to the post,
/// 0..2800 m; with 10 m cells about a quarter of the cells are steeper than 60 degrees. The value
/// of post (i, j) depends on i, j, cell and seed only. World: the lower left post is at (0, 0).
/// Int16 posts are rounded to 0.05 m.
std::unique_ptr<HeightSource> makeFractal(const SyntheticOptions& options);

/// A town: gentle ground with houses and towers (vertical walls), trees, and holes (ponds, a strip
/// every 1.5 km). Made for cells of about 1 m. 0..160 m; otherwise like the fractal.
std::unique_ptr<HeightSource> makeTown(const SyntheticOptions& options);

/// "synthetic:fractal?size=4096&cell=10&seed=1&format=int16" and "synthetic:town?...": sources for
/// the command line and benches; `columns` and `rows` override `size`, format is int16 or float.
/// Null if the name is not a synthetic one; a bad kind, key or value is a Usage error.
Result<std::unique_ptr<HeightSource>> makeSynthetic(const std::string& name);

}  // namespace terray
