// SPDX-License-Identifier: Apache-2.0
// The smallest program: open a terrain, make a picture of it.
#include <terray/terray.h>
#include <cstdio>

int main(int argc, char** argv) {
    const auto terrain = terray::Terrain::open(argc > 1 ? argv[1] : "dem.tif");
    if (!terrain) return std::puts(terrain.error().message.c_str()), 1;
    const auto stats = terray::renderToFiles(*terrain, {}, {}, {.path = "terray.png"});
    if (!stats) return std::puts(stats.error().message.c_str()), 1;
    std::printf("terray.png: %.0f ms\n", stats->totalMs);
}
