// SPDX-License-Identifier: Apache-2.0
// Writes a small DEM into the folder given, opens and renders it: what any user of the library
// does.
#include <terray/terray.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const std::string path = std::string(argv[1]) + "/ridge.asc";
    {
        std::ofstream file(path);
        file << "ncols 20\nnrows 20\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n";
        for (int row = 0; row < 20; ++row) {
            for (int column = 0; column < 20; ++column) {
                file << (column < 10 ? column : 20 - column) * 4 + row << ' ';
            }
            file << '\n';
        }
    }

    terray::OpenOptions open;
    open.assignCrs = "EPSG:32632";
    const auto terrain = terray::Terrain::open(path, open);
    if (!terrain) {
        std::fprintf(stderr, "%s\n", terrain.error().message.c_str());
        return 1;
    }
    terray::View view;
    view.width = 64;
    view.height = 48;
    std::vector<uint8_t> pixels(64 * 48 * 4);
    const auto stats = terray::render(*terrain, view, {}, pixels);
    if (!stats) {
        std::fprintf(stderr, "%s\n", stats.error().message.c_str());
        return 1;
    }
    std::printf("version %s, %llu hits\n", terray::version(),
                static_cast<unsigned long long>(stats->hits));
    return 0;
}
