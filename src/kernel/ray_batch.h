// SPDX-License-Identifier: Apache-2.0
// Up to 64 rays at once, one array per quantity: what a technique fills and the tracer steps.
#pragma once

#include "kernel/layout/layout.h"

namespace terray {

constexpr int kBatchRays = 64;

/// Rays as in Ray (kernel/layout). Neighbours that look the same way stand together, 16 by 16.
struct alignas(64) RayBatch {
    double x[kBatchRays], y[kBatchRays], z[kBatchRays];
    double dx[kBatchRays], dy[kBatchRays], dz[kBatchRays], bend[kBatchRays];
    double begin[kBatchRays],
        end[kBatchRays];       ///< tMin, tMax; the tracer narrows them to what can hit
    double clear[kBatchRays];  ///< the ray is known to be above the surface until here
    bool above[kBatchRays];    ///< out: it stays above, in holes too, until its hit or its end

    Ray ray(int k) const {
        return {x[k], y[k], z[k], dx[k], dy[k], dz[k], bend[k], begin[k], end[k]};
    }
    void set(int k, const Ray& ray) {
        x[k] = ray.x;
        y[k] = ray.y;
        z[k] = ray.z;
        dx[k] = ray.dx;
        dy[k] = ray.dy;
        dz[k] = ray.dz;
        bend[k] = ray.bend;
        begin[k] = clear[k] = ray.tMin;
        end[k] = ray.tMax;
    }
};

}  // namespace terray
