// SPDX-License-Identifier: Apache-2.0
// `terray-bench latency`: how long a tile of a store takes from its request to its slot, while all
// cores render.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <random>
#include <thread>

#include "commands.h"
#include "store/store.h"
#include "stream/streamer.h"
#include "terray/process.h"
#include "terray/renderer.h"

namespace terray::bench {
namespace {

struct LatencyOptions {
    std::string store;
    double perSecond = 50, seconds = 10;
    int memoryMiB = 512;
    bool idle = false;
};

/// Frames of another terrain, on all cores, until it is destroyed.
class Rendering {
public:
    Rendering() : terrain_(Terrain::open("synthetic:fractal?size=2048&cell=10&seed=1")) {
        if (terrain_) thread_ = std::thread([this] { work(); });
    }
    ~Rendering() {
        stop_ = true;
        if (thread_.joinable()) thread_.join();
        fmt::print("{} frames of 1280 x 720 beside it\n", frames_.load());
    }

private:
    void work() {
        View view;
        view.width = 1280;
        view.height = 720;
        RenderOptions options;
        options.samples = 1;
        std::vector<uint8_t> rgba(size_t{1280} * 720 * 4);
        while (!stop_) frames_ += render(*terrain_, view, options, rgba).ok() ? 1 : 0;
    }
    Result<Terrain> terrain_;
    std::atomic<bool> stop_{false};
    std::atomic<int> frames_{0};
    std::thread thread_;
};

/// Asks for tiles that are absent, at random moments.
LatencyFigures ask(const ResidentTerrain& terrain, const LatencyOptions& options) {
    Streamer& streamer = *terrain.streamer();
    const ResidentTerrain::Pool& pool = terrain.pool();
    const uint32_t tiles = pool.firstTile[static_cast<size_t>(pool.firstKept)];
    std::mt19937 random(1);
    std::exponential_distribution<double> pause(options.perSecond);
    std::vector<TileId> wanted;
    const auto begin = std::chrono::steady_clock::now();
    double at = 0;
    while (at < options.seconds) {
        at += pause(random);
        std::this_thread::sleep_until(begin + std::chrono::duration<double>(at));
        for (int tries = 0; tries < 1000; ++tries) {
            const uint32_t number = static_cast<uint32_t>(random() % tiles);
            if (pool.isHere(number)) continue;
            wanted.push_back(pool.tileOf(number));
            break;
        }
        if (wanted.size() > streamer.room() / 2) wanted.erase(wanted.begin());
        streamer.update(wanted);
    }
    static_cast<void>(streamer.bring(wanted));
    return streamer.figures().latency;
}

int run(const LatencyOptions& options) {
    setQuiet(true);
    auto store = Store::open(options.store, uint64_t{1} << 30);
    if (!store) {
        fmt::print(stderr, "{}\n", store.error().message);
        return 3;
    }
    const int kept = (*store)->info().scheme.mipCount() - 1;
    BuildStats stats;
    auto terrain = ResidentTerrain::stream(std::move(*store), kept,
                                           static_cast<uint64_t>(options.memoryMiB) << 20, stats);
    if (!terrain) {
        fmt::print(stderr, "{}\n", terrain.error().message);
        return 3;
    }
    std::unique_ptr<Rendering> rendering;
    if (!options.idle) rendering = std::make_unique<Rendering>();
    const LatencyFigures figures = ask(**terrain, options);
    rendering.reset();
    fmt::print(
        "{} tiles at {:g} requests a second: median {:.2f} ms, 90 % {:.1f} ms, 99 % {:.1f} ms\n",
        (*terrain)->streamer()->figures().loaded, options.perSecond, figures.quantile(0.5),
        figures.quantile(0.9), figures.quantile(0.99));
    return 0;
}

}  // namespace

void addLatency(CLI::App& program, Job& job) {
    auto options = std::make_shared<LatencyOptions>();
    CLI::App* command = program.add_subcommand(
        "latency", "time from a tile's request to its slot, while all cores render");
    command->add_option("store", options->store, "a store whose tiles are read")->required();
    command->add_option("--rate", options->perSecond, "requests a second, at random moments")
        ->capture_default_str();
    command->add_option("--seconds", options->seconds)->capture_default_str();
    command->add_option("--memory", options->memoryMiB, "MiB of tiles")->capture_default_str();
    command->add_flag("--idle", options->idle, "render nothing beside it");
    command->callback([options, &job] { job = [options] { return run(*options); }; });
}

}  // namespace terray::bench
