// SPDX-License-Identifier: Apache-2.0
// The part of a ray that can hit: inside the rectangle, below the highest thing drawn.
#include <algorithm>
#include <cmath>

#include "kernel/exact/exact.h"

namespace terray::exact {

Clip clipRay(const TerrainCut& cut, const Ray& ray) {
    Clip clip{ray.tMin, ray.tMax};
    const auto slab = [&clip](double origin, double step, double size) {
        if (step == 0.0) {
            if (origin < 0.0 || origin > size) clip.end = -1.0;
            return;
        }
        const double a = -origin / step, b = (size - origin) / step;
        clip.begin = std::max(clip.begin, std::min(a, b));
        clip.end = std::min(clip.end, std::max(a, b));
    };
    slab(ray.x, ray.dx, cut.cellsX);
    slab(ray.y, ray.dy, cut.cellsY);
    if (clip.end < clip.begin) return {0.0, -1.0};
    // The part below the highest thing drawn: an interval, since the ray is a convex parabola or a
    // line.
    const double slack =
        1e-6 + 1e-9 * (std::fabs(ray.z) + std::fabs(static_cast<double>(cut.maxZ)));
    const double c = ray.z - (static_cast<double>(cut.maxZ) + slack);
    if (ray.bend > 0.0) {
        const double disc = ray.dz * ray.dz - 4.0 * ray.bend * c;
        if (disc < 0.0) return {0.0, -1.0};
        const double k = -0.5 * (ray.dz + std::copysign(std::sqrt(disc), ray.dz));
        const double r1 = k / ray.bend, r2 = k != 0.0 ? c / k : 0.0;
        clip.begin = std::max(clip.begin, std::min(r1, r2));
        clip.end = std::min(clip.end, std::max(r1, r2));
    } else if (ray.dz < 0.0) {
        clip.begin = std::max(clip.begin, -c / ray.dz);
    } else if (ray.dz > 0.0) {
        clip.end = std::min(clip.end, -c / ray.dz);
    } else if (c > 0.0) {
        return {0.0, -1.0};
    }
    if (clip.end < clip.begin) return {0.0, -1.0};
    return clip;
}

}  // namespace terray::exact
