// SPDX-License-Identifier: Apache-2.0
// Options, a camera over the ground, a buffer of distances beside the picture, and figures.
#include <terray/terray.h>
#include <cstdio>

namespace {

int fail(const terray::Error& error) {
    std::fprintf(stderr, "%s\n", error.message.c_str());
    return static_cast<int>(error.code);
}

/// From 300 m above the middle of the terrain, looking to the north.
terray::View middleView(const terray::SourceInfo& info) {
    const auto& g = info.geoTransform;
    const double column = 0.5 * static_cast<double>(info.columns);
    const double row = 0.5 * static_cast<double>(info.rows);
    terray::View view;
    view.width = 1280;
    view.height = 720;
    view.eye = terray::Place{g[0] + column * g[1] + row * g[2], g[3] + column * g[4] + row * g[5],
                             300.0, true};
    view.headingDeg = 0;
    view.pitchDeg = -10;
    return view;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: example_render DEM\n");
        return 2;
    }
    const auto terrain = terray::Terrain::open(argv[1]);
    if (!terrain) return fail(terrain.error());

    terray::RenderOptions look;
    look.sunAzElDeg = {{290.0, 25.0}};
    look.samples = 8;
    look.contoursM = 100;
    terray::OutputOptions outputs;
    outputs.path = "view.jpg";
    outputs.aovs = {{terray::Aov::Distance, "distance.tif"}, {terray::Aov::Normal, "normal.exr"}};

    const auto stats = terray::renderToFiles(*terrain, middleView(terrain->info()), look, outputs);
    if (!stats) return fail(stats.error());
    std::printf("%s\n", terray::toJson(*stats).c_str());
    return 0;
}
