// SPDX-License-Identifier: Apache-2.0
// Leaf maths written once: a ray against one cell. The includer defines `real` (a float, a SIMD vector,
// a GLSL float), LEAF_FN (how a function is declared) and leafMin, leafMax, leafSelectPositive. No guard:
// included once per lane type.
//
// f(s) = ray height - surface height = f0 + f1 s + f2 s^2, s counted from the cell's entry.

struct LeafQuadratic {
    real f0, f1, f2;
};

/// Bilinear cell (posts h00, h10, h01, h11; place u, v; steps du, dv per s) against a ray of height z,
/// slope dz and bend: h00 + b u + c v + d u v along a line is a quadratic (docs/surface.md).
LEAF_FN LeafQuadratic leafBilinear(real h00, real h10, real h01, real h11, real u, real v, real du, real dv,
                                   real z, real dz, real bend) {
    const real b = h10 - h00;
    const real c = h01 - h00;
    const real d = (h11 - h01) - b;
    const real s0 = (h00 + b * u) + v * (c + d * u);
    const real s1 = b * du + c * dv + d * (u * dv + v * du);
    LeafQuadratic q;
    q.f0 = z - s0;
    q.f1 = dz - s1;
    q.f2 = bend - d * du * dv;
    return q;
}

LEAF_FN real leafAt(LeafQuadratic q, real s) { return q.f0 + s * (q.f1 + s * q.f2); }
