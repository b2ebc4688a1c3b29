// SPDX-License-Identifier: Apache-2.0
// The shader text as C++: how much it leaves open, and that it always ends. That its hits are the
// oracle's is tested with every other kernel's (kernel/test_trace.h).
#include <gtest/gtest.h>

#include <cmath>

#include "kernel/glsl/test_program.h"
#include "kernel/test_cuts.h"
#include "kernel/test_trace.h"

namespace terray {
namespace {

using test::CutChoice;
using test::Place;
using test::Random;
using test::ShaderShares;
using test::TestCut;
using test::towards;
using test::traceByShader;
using test::uniform;

/// Rays of a perspective picture.
std::vector<Ray> pictureRays(const Place& eye, double azimuth, double pitch, double scale) {
    std::vector<Ray> rays;
    const double ca = std::cos(azimuth), sa = std::sin(azimuth);
    const double cp = std::cos(pitch), sp = std::sin(pitch);
    for (int j = 0; j < 72; ++j)
        for (int i = 0; i < 128; ++i) {
            const double right = (i - 63.5) / 110, up = (35.5 - j) / 110;
            const double ahead = cp - up * sp;
            const double x = ahead * ca - right * sa, y = ahead * sa + right * ca;
            rays.push_back(towards(eye,
                                   {eye[0] + x * scale, eye[1] + y * scale, eye[2] + sp + up * cp},
                                   scale, 6.8e-8));
        }
    return rays;
}

TEST(ShaderText, LeavesLittleOpenInPictures) {
    for (const bool int16 : {false, true}) {
        CutChoice choice;
        choice.int16 = int16;
        TestCut terrain(test::roughTerrain(1025, 1025, 300, 3), choice);
        for (const auto& shader : test::shaderTraces())
            for (const SurfaceKind surface : test::kAllSurfaces) {
                SCOPED_TRACE(shader.name);
                terrain.setSurface(surface);
                ShaderShares shares;
                for (const double height : {320.0, 800.0, 3000.0})
                    for (const double pitch : {-0.05, -0.4, -1.5})
                        traceByShader(terrain.cut(),
                                      pictureRays({130, 120, height}, 0.7, pitch, 0.1),
                                      shader.trace, shares);
                RecordProperty("uncertain", std::to_string(shares.uncertain));
                EXPECT_GT(shares.share(shares.certainHits), 0.4);
                EXPECT_LT(shares.share(shares.uncertain), 0.01);
                EXPECT_LT(shares.share(shares.placesOpen), 0.03);
                printf(
                    "%s surface %u int16 %d: uncertain %.4f%% open %.4f%% hits %.1f%% steps %.2f\n",
                    shader.name, surface, int16, 100 * shares.share(shares.uncertain),
                    100 * shares.share(shares.placesOpen), 100 * shares.share(shares.certainHits),
                    shares.share(shares.steps));
            }
    }
}

}  // namespace
}  // namespace terray
