// SPDX-License-Identifier: Apache-2.0
// Pictures of distances, read and compared.
#include "peers/agreement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terray::bench {

std::vector<float> readPicture(const Caster& caster, int width, int height) {
    std::vector<float> picture(static_cast<size_t>(width) * static_cast<size_t>(height));
    tbb::enumerable_thread_specific<Scratch> scratches;
    castTiles(width, height, scratches, [&](const ImageTile& tile, Scratch& scratch) {
        std::array<float, size_t{kTileWidth} * kTileHeight> values;
        caster.castTile(tile, scratch);
        caster.readTile(tile, scratch, values);
        for (int y = 0; y < tile.height; ++y)
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(y) * tile.width, tile.width,
                        picture.begin() + static_cast<std::ptrdiff_t>(tile.y + y) * width + tile.x);
    });
    return picture;
}

Agreement compareDistances(const std::vector<float>& a, const std::vector<float>& b) {
    size_t both = 0, far = 0, flips = 0;
    Agreement agreement;
    for (size_t k = 0; k < a.size(); ++k) {
        if (std::isfinite(a[k]) != std::isfinite(b[k])) ++flips;
        if (!std::isfinite(a[k]) || !std::isfinite(b[k])) continue;
        ++both;
        const double apart = std::abs(static_cast<double>(a[k]) - static_cast<double>(b[k]));
        far += apart > 0.1 ? 1 : 0;
        agreement.worst = std::max(agreement.worst, apart);
    }
    if (both != 0) agreement.farShare = static_cast<double>(far) / static_cast<double>(both);
    if (!a.empty())
        agreement.flipShare = static_cast<double>(flips) / static_cast<double>(a.size());
    return agreement;
}

double shareOfDifferent(const std::vector<float>& a, const std::vector<float>& b,
                        const std::vector<bool>& marked) {
    size_t counted = 0, different = 0;
    for (size_t k = 0; k < a.size(); ++k) {
        if (!marked[k]) continue;
        ++counted;
        different += a[k] != b[k] ? 1 : 0;
    }
    return counted == 0 ? 0 : static_cast<double>(different) / static_cast<double>(counted);
}

}  // namespace terray::bench
