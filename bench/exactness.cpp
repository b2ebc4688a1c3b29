// SPDX-License-Identifier: Apache-2.0
// `terray-bench exactness`: random rays, cameras and shadow rays against the double-precision
// oracle, for every SIMD target. Exit code 1 if there is one violation.
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <random>

#include "base/progress.h"
#include "cameras.h"
#include "commands.h"
#include "kernel/height.h"
#include "kernel/scalar/judge.h"
#include "kernel/trace.h"
#include "scene.h"
#include "stream/cut.h"
#include "technique/technique.h"
#include "view/ray_frame.h"

namespace terray::bench {
namespace {

struct ExactnessOptions {
    std::vector<std::string> sources;  ///< empty: the town and the fractal
    uint64_t rays = 10'000'000;
    int width = 640, height = 360;
    std::string target, surface = "all";
    uint64_t seed = 1;
};

constexpr size_t kBatch = size_t{1} << 17, kSlice = 1024;

template <class Work>
void forSlices(size_t count, const Work& work) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, (count + kSlice - 1) / kSlice),
                      [&](const auto& range) {
                          for (size_t k = range.begin(); k < range.end(); ++k)
                              work(k * kSlice, std::min(kSlice, count - k * kSlice));
                      });
}

struct Tally {
    uint64_t rays = 0, hits = 0, shadowRays = 0, redone = 0, ties = 0, faults = 0;
    uint64_t columns = 0;  ///< of the rays: marched in columns
    void add(const Tally& t) {
        rays += t.rays;
        hits += t.hits;
        shadowRays += t.shadowRays;
        redone += t.redone;
        ties += t.ties;
        faults += t.faults;
        columns += t.columns;
    }
};

/// Judges batches of rays for every target, counts and prints.
class Court {
public:
    explicit Court(std::vector<std::string> targets) : targets_(std::move(targets)) {}

    void judge(const std::string& label, const TerrainCut& cut, const oracle::BlockRanges& ranges,
               const RayFrame& frame, const std::vector<Ray>& rays, uint64_t seed);
    /// The picture of the same rays, as the technique casts it, by the verdicts of the last
    /// judge().
    void judgePicture(const std::string& label, const TerrainCut& cut, const RayFrame& frame,
                      const Technique& technique);
    uint64_t faults() const;
    void print() const;

private:
    void tell(const std::string& target, const std::string& label, const std::string& line);
    Tally judgeSlice(const std::string& target, const std::string& label, const TerrainCut& cut,
                     size_t first, size_t count);

    std::vector<std::string> targets_;
    std::map<std::string, Tally> tallies_;
    std::mutex mutex_;
    int told_ = 0;
    // of the batch
    std::vector<Ray> rays_, suns_;
    std::vector<oracle::ExactHit> exact_;
    std::vector<Hit> starts_;  ///< the oracle's hits: the same shadow rays for every target
    std::vector<uint8_t> shadows_;
};

/// The sun ray of a hit: from its place on the sheet (on the strip: from the view ray's height).
Ray sunRay(const TerrainCut& cut, const RayFrame& frame, const Ray& view,
           const oracle::ExactHit& exact, std::mt19937_64& random) {
    std::uniform_real_distribution<double> azimuth(0, 2 * kPi), elevation(-0.05, 1);
    const double a = azimuth(random), e = elevation(random);
    const LatticePlace place = hitPlace(cut, exact.hit);
    Ray ray =
        frame.latticeRay({{}, {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)}});
    ray.x = place.i;
    ray.y = place.j;
    ray.z = (exact.hit.flags & kHitStrip) != 0 ? view.z + (view.dz + view.bend * exact.t) * exact.t
                                               : hitHeight(cut, exact.hit);
    return ray;
}

void Court::judge(const std::string& label, const TerrainCut& cut,
                  const oracle::BlockRanges& ranges, const RayFrame& frame,
                  const std::vector<Ray>& rays, uint64_t seed) {
    rays_ = rays;
    suns_.assign(rays.size(), Ray{0, 0, 0, 0, 0, 1});
    exact_.assign(rays.size(), {});
    starts_.assign(rays.size(), Hit{});
    shadows_.assign(rays.size(), 0);
    forSlices(rays.size(), [&](size_t first, size_t count) {
        std::mt19937_64 random(seed * 1'000'003 + first);
        for (size_t k = first; k < first + count; ++k) {
            exact_[k] = oracle::firstHit(cut, rays_[k], &ranges);
            if (!isHit(exact_[k].hit)) continue;
            starts_[k] = exact_[k].hit;
            suns_[k] = sunRay(cut, frame, rays_[k], exact_[k], random);
            shadows_[k] = oracle::occluded(cut, starts_[k], suns_[k], &ranges) ? 1 : 0;
        }
    });
    for (const std::string& target : targets_) {
        setSimdTarget(target);
        std::mutex sum;
        forSlices(rays.size(), [&](size_t first, size_t count) {
            const Tally slice = judgeSlice(target, label, cut, first, count);
            const std::lock_guard lock(sum);
            tallies_[target].add(slice);
        });
    }
    setSimdTarget("");
}

void Court::judgePicture(const std::string& label, const TerrainCut& cut, const RayFrame& frame,
                         const Technique& technique) {
    constexpr int kSide = 128;
    const int width = frame.camera().width, height = frame.camera().height;
    const int across = (width + kSide - 1) / kSide, down = (height + kSide - 1) / kSide;
    for (const std::string& target : targets_) {
        setSimdTarget(target);
        std::mutex sum;
        tbb::parallel_for(0, across * down, [&](int k) {
            ImageTile tile{k % across * kSide, k / across * kSide, 0, 0};
            tile.width = std::min(kSide, width - tile.x);
            tile.height = std::min(kSide, height - tile.y);
            std::vector<Hit> hits(tile.pixelCount());
            TraceCounters counters;
            technique.castTile(cut, frame, tile, {0.5, 0.5}, hits, counters);
            Tally slice{hits.size(), counters.hits, 0, counters.redone, 0, 0};
            slice.columns = counters.columns;
            for (size_t pixel = 0; pixel < hits.size(); ++pixel) {
                const int x = tile.x + static_cast<int>(pixel) % tile.width;
                const int y = tile.y + static_cast<int>(pixel) / tile.width;
                const size_t ray =
                    static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
                const oracle::Fault fault =
                    oracle::judge(cut, rays_[ray], hits[pixel], exact_[ray]);
                slice.ties += fault == oracle::Fault::Tie ? 1 : 0;
                if (!oracle::isViolation(fault)) continue;
                ++slice.faults;
                tell(target, label + fmt::format(", picture {},{}", x, y),
                     oracle::describe(fault, rays_[ray], hits[pixel], exact_[ray]));
            }
            const std::lock_guard lock(sum);
            tallies_[target].add(slice);
        });
    }
    setSimdTarget("");
}

Tally Court::judgeSlice(const std::string& target, const std::string& label, const TerrainCut& cut,
                        size_t first, size_t count) {
    Hit hits[kSlice];
    uint8_t shadows[kSlice];
    TraceCounters counters, shadowCounters;
    firstHits(cut, std::span(rays_).subspan(first, count), {hits, count}, counters);
    occluded(cut, std::span(starts_).subspan(first, count), std::span(suns_).subspan(first, count),
             {shadows, count}, shadowCounters);
    Tally tally{count, counters.hits, 0, counters.redone, 0, 0};
    for (size_t k = 0; k < count; ++k) {
        const oracle::ExactHit& exact = exact_[first + k];
        tally.shadowRays += isHit(exact.hit) ? 1 : 0;
        const oracle::Fault fault = oracle::judge(cut, rays_[first + k], hits[k], exact);
        tally.ties += fault == oracle::Fault::Tie ? 1 : 0;
        if (oracle::isViolation(fault)) {
            ++tally.faults;
            tell(target, label, oracle::describe(fault, rays_[first + k], hits[k], exact));
        }
        if (shadows[k] == shadows_[first + k]) continue;
        if (!oracle::isViolation(
                oracle::judgeShadow(cut, starts_[first + k], suns_[first + k], shadows[k] != 0))) {
            ++tally.ties;
            continue;
        }
        ++tally.faults;
        tell(target, label,
             fmt::format("shadow: kernel {}, oracle {}, from {}", shadows[k], shadows_[first + k],
                         oracle::describe(oracle::Fault::None, suns_[first + k], starts_[first + k],
                                          exact)));
    }
    return tally;
}

void Court::tell(const std::string& target, const std::string& label, const std::string& line) {
    constexpr int kTold = 20;
    const std::lock_guard lock(mutex_);
    if (++told_ <= kTold) fmt::print("{}, {}: {}\n", target, label, line);
    if (told_ == kTold) fmt::print("further violations are only counted\n");
}

uint64_t Court::faults() const {
    uint64_t sum = 0;
    for (const auto& [target, tally] : tallies_) sum += tally.faults;
    return sum;
}

void Court::print() const {
    fmt::print("{:<8} {:>12} {:>12} {:>12} {:>12} {:>9} {:>8} {:>11}\n", "target", "rays", "hits",
               "by column", "shadow rays", "redone %", "ties", "violations");
    for (const std::string& target : targets_) {
        const Tally& t = tallies_.at(target);
        fmt::print("{:<8} {:>12} {:>12} {:>12} {:>12} {:>9.4f} {:>8} {:>11}\n", target, t.rays,
                   t.hits, t.columns, t.shadowRays,
                   100.0 * static_cast<double>(t.redone) / static_cast<double>(t.rays), t.ties,
                   t.faults);
    }
}

/// Eyes in, around, above and a little under the terrain's box; targets at heights that occur.
std::vector<Ray> randomRays(const Scene& scene, const RayFrame& frame, size_t count,
                            uint64_t seed) {
    const TerrainInfo& info = scene.terrain->info();
    const auto columns = static_cast<double>(info.scheme.columns - 1);
    const auto rows = static_cast<double>(info.scheme.rows - 1);
    const double low = static_cast<double>(info.minZ);
    const double range = std::max(static_cast<double>(info.maxZ) - low, 1e-3);
    std::vector<Ray> rays(count);
    forSlices(count, [&](size_t first, size_t slice) {
        std::mt19937_64 random(seed * 999'983 + first);
        const auto uniform = [&random](double a, double b) {
            return std::uniform_real_distribution<double>(a, b)(random);
        };
        for (size_t k = first; k < first + slice; ++k) {
            const double spread = random() % 8 == 0 ? 1.0 : 0.05;
            // Half of the rays are short, so that near cells are tested as well as far ones.
            const LatticePoint to{columns * uniform(0, 1), rows * uniform(0, 1)};
            LatticePoint from{columns * uniform(-spread, 1 + spread),
                              rows * uniform(-spread, 1 + spread)};
            if (random() % 2 == 0) from = {to.i + uniform(-200, 200), to.j + uniform(-200, 200)};
            const Vec2 eye = info.worldFromLattice.worldFromLattice(from);
            const Vec2 aim = info.worldFromLattice.worldFromLattice(to);
            const WorldPoint origin{eye.x, eye.y, low + range * uniform(-0.2, 1.8)};
            const WorldPoint target{aim.x, aim.y, low + range * uniform(0, 1)};
            rays[k] = frame.latticeRay({origin, glm::normalize(target - origin)});
        }
    });
    return rays;
}

std::vector<Ray> cameraRays(const RayFrame& frame) {
    const int width = frame.camera().width, height = frame.camera().height;
    std::vector<Ray> rays;
    rays.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) rays.push_back(frame.rayThrough(x + 0.5, y + 0.5));
    return rays;
}

/// A cut, and what lets the oracle hurry.
struct JudgedCut {
    explicit JudgedCut(FrameCut choice) : cut(std::move(choice)), ranges(cut.cut()) {}
    FrameCut cut;
    oracle::BlockRanges ranges;
};

void judgeScene(const Scene& scene, const Technique& technique, SurfaceKind kind, uint64_t rayCount,
                const ExactnessOptions& options, Court& court) {
    std::vector<NamedCamera> cameras = speedCameras(*scene.terrain, options.width, options.height);
    for (NamedCamera& odd : oddCameras(*scene.terrain, options.width, options.height))
        cameras.push_back(std::move(odd));
    const std::string surface = kSurfaceNames[kind];
    Progress progress(scene.name + ", " + surface,
                      static_cast<double>(2 * cameras.size() + rayCount / kBatch));
    const Affine2& lattice = scene.terrain->info().worldFromLattice;
    std::vector<JudgedCut> cuts;  // finest, then one with unlike mips for each camera
    cuts.emplace_back(finestCut(*scene.terrain, kind));
    for (const NamedCamera& named : cameras) {
        CutOptions choice;
        choice.bend = scene.bend;
        choice.surface = kind;
        cuts.emplace_back(selectCut(*scene.terrain, named.camera, choice));
        const RayFrame frame(named.camera, lattice, 1, scene.bend);
        const std::vector<Ray> rays = cameraRays(frame);
        for (const JudgedCut* judged : {&cuts.front(), &cuts.back()}) {
            const std::string mips = judged == &cuts.front() ? "finest" : "2/3 px";
            const std::string label =
                fmt::format("{}, {}, {}, {}", scene.name, surface, named.name, mips);
            const TerrainCut& cut = judged->cut.cut();
            court.judge(label, cut, judged->ranges, frame, rays, options.seed);
            court.judgePicture(label, cut, frame, technique);
            progress.advance();
        }
    }
    uint64_t batch = 0;
    for (uint64_t done = 0; done < rayCount; done += kBatch, ++batch) {
        const NamedCamera& named = cameras[batch % cameras.size()];
        const JudgedCut& judged = batch % 2 == 0 ? cuts.front() : cuts[1 + batch % cameras.size()];
        const RayFrame frame(named.camera, lattice, 1, batch % 3 == 0 ? 0 : scene.bend);
        const size_t count = static_cast<size_t>(std::min<uint64_t>(kBatch, rayCount - done));
        court.judge(fmt::format("{}, {}, random batch {}", scene.name, surface, batch),
                    judged.cut.cut(), judged.ranges, frame,
                    randomRays(scene, frame, count, options.seed + batch), options.seed + batch);
        progress.advance();
    }
}

int runExactness(const ExactnessOptions& options) {
    std::vector<std::string> targets = simdTargets();
    if (!options.target.empty()) {
        if (!setSimdTarget(options.target))
            return report(makeError(ErrorCode::Usage, "--target {}: this machine has {}",
                                    options.target, fmt::join(targets, ", ")));
        targets = {options.target};
    }
    std::vector<std::string> sources = options.sources;
    if (sources.empty())
        sources = {syntheticName("town", 2048, 1, "float"),
                   syntheticName("fractal", 2048, 10, "int16")};
    std::vector<SurfaceKind> surfaces;
    for (const SurfaceKind kind : {kSurfaceBilinear, kSurfaceConstant, kSurfaceTriangles})
        if (options.surface == "all" || options.surface == kSurfaceNames[kind])
            surfaces.push_back(kind);
    auto technique = makeTechnique("ray_cast");
    if (!technique) return report(technique.error());
    Court court(targets);
    const uint64_t share = options.rays / (sources.size() * surfaces.size());
    for (const std::string& source : sources) {
        auto scene = loadScene(source);
        if (!scene) return report(scene.error());
        for (const SurfaceKind kind : surfaces)
            judgeScene(*scene, **technique, kind, share, options, court);
    }
    court.print();
    return court.faults() == 0 ? 0 : 1;
}

}  // namespace

void addExactness(CLI::App& program, Job& job) {
    CLI::App* command =
        program.add_subcommand("exactness", "the tracer against the double-precision oracle");
    const auto options = std::make_shared<ExactnessOptions>();
    command->add_option("sources", options->sources,
                        "DEM files or synthetic:... (default: a town and a fractal)");
    command->add_option("--rays", options->rays, "random rays, over all sources and surfaces")
        ->capture_default_str();
    command->add_option("--width", options->width, "of the twelve cameras' pictures")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--height", options->height)
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--target", options->target,
                        "one SIMD target (default: all of the machine)");
    command->add_option("--surface", options->surface)
        ->check(CLI::IsMember({"bilinear", "constant", "triangles", "all"}))
        ->capture_default_str();
    command->add_option("--seed", options->seed)->capture_default_str();
    command->footer(
        "Example: terray-bench exactness dem.tif --rays 1000000 --target AVX3\n"
        "Exit codes: 0 no violation, 1 some.");
    command->callback([options, &job] { job = [options] { return runExactness(*options); }; });
}

}  // namespace terray::bench
