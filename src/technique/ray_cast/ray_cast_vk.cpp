// SPDX-License-Identifier: Apache-2.0
// ray_cast on a Vulkan device: rays placed in double precision on the CPU, traced in float on the
// device, and what float leaves open decided on the CPU again (kernel/device_rays.h).
#include "technique/ray_cast/ray_cast_vk.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>

#include "base/stopwatch.h"
#include "device/vulkan/commands.h"
#include "kernel/beam.h"
#include "kernel/device_rays.h"
#include "technique/ray_cast/column_march.h"
#include "technique/ray_cast/tile_mirror.h"

namespace terray {
namespace {

constexpr uint32_t kSpirv[] = {
#include "technique/ray_cast/ray_cast.comp.inc"
};

constexpr size_t kBeamBlocks = 4, kBeamRays = kBeamBlocks * kBatchRays;
/// Beams on their way at a time, twice; fewer where the device has less memory.
constexpr size_t kMostBeams = 512, kLeastBeams = 16;
constexpr uint64_t kUploadBytes = uint64_t{8} << 20;

struct PixelPlace {
    uint8_t x, y;
};
/// The pixels of a block as invocations have them: 4 x 2 after 4 x 2, so that those which run
/// together see the same ground.
constexpr std::array<PixelPlace, kBatchRays> pixelOrder() {
    std::array<PixelPlace, kBatchRays> order{};
    for (size_t k = 0; k < order.size(); ++k)
        order[k] = {static_cast<uint8_t>(k / 8 % 2 * 4 + k % 4),
                    static_cast<uint8_t>(k / 16 * 2 + k / 4 % 2)};
    return order;
}
constexpr auto kOrder = pixelOrder();

/// 16 x 16 pixels of an image tile.
struct BeamPlace {
    size_t tile;
    int x, y;  ///< in the image tile
};

/// A part of a picture on its way through the device.
struct Flight {
    vulkan::Buffer rays, hits, back;
    std::vector<RayBatch> batches;  ///< kBeamBlocks a beam
    std::span<const BeamPlace> beams;
    vulkan::Ticket ticket = 0;
};

/// What a call of cast() works on.
struct CastJob {
    const TerrainCut& cut;
    const RayFrame& rays;
    std::span<const ImageTile> tiles;
    std::vector<size_t> firstHit;  ///< per tile
    Vec2 offset;
    std::span<Hit> hits;
    tbb::enumerable_thread_specific<TraceCounters> counters;

    struct Pixels {
        int x, y, width, height;  ///< in the image tile
    };
    /// The pixels of a block of a beam, cut off at the tile's sides; width or height <= 0: none.
    Pixels pixelsOf(const BeamPlace& beam, size_t block) const {
        const ImageTile& tile = tiles[beam.tile];
        const int x = beam.x + static_cast<int>(block % 2) * kBlockSide;
        const int y = beam.y + static_cast<int>(block / 2) * kBlockSide;
        return {x, y, std::min(kBlockSide, tile.width - x), std::min(kBlockSide, tile.height - y)};
    }
};

class RayCastVk final : public DeviceTechnique {
public:
    static Result<std::unique_ptr<DeviceTechnique>> open(const DeviceRequest& request);

    /// Buffers may go when nothing works on them any more; of a lost device nothing does.
    ~RayCastVk() override {
        if (device_ && !device_->isLost()) static_cast<void>(device_->waitIdle());
    }
    std::string deviceName() const override { return device_->name(); }
    bool isLost() const override { return device_->isLost(); }
    Result<void> prepare(const TerrainCut& cut, DeviceFigures& figures) override;
    Result<void> cast(const TerrainCut& cut, const RayFrame& rays, std::span<const ImageTile> tiles,
                      Vec2 offset, std::span<Hit> hits, TraceCounters& counters,
                      DeviceFigures& figures) override;

private:
    RayCastVk() = default;
    Result<void> makeFlights();
    Result<void> makeFlight(Flight& flight) const;
    Result<void> makePipeline(const TerrainCut& cut);
    Result<void> fly(CastJob& job, std::span<const BeamPlace> beams, DeviceFigures& figures);
    static void place(CastJob& job, Flight& flight);
    Result<void> submit(Flight& flight);
    Result<void> finish(CastJob& job, Flight& flight, DeviceFigures& figures);

    std::unique_ptr<vulkan::Device> device_;
    std::unique_ptr<vulkan::Uploader> uploader_;
    std::unique_ptr<TileMirror> mirror_;
    /// Per post format and surface, made when they are first met.
    std::array<std::array<std::unique_ptr<vulkan::ComputePipeline>, 3>, 2> pipelines_;
    const vulkan::ComputePipeline* pipeline_ = nullptr;
    size_t beamsAtOnce_ = kMostBeams;
    std::array<Flight, 2> flights_;
};

Result<std::unique_ptr<DeviceTechnique>> RayCastVk::open(const DeviceRequest& request) {
    std::unique_ptr<RayCastVk> technique(new RayCastVk);
    vulkan::DeviceOptions options;
    options.which = request.which;
    options.validation = vulkan::wantsValidation();
    options.budgetBytes = request.budgetBytes;
    options.cacheFolder = vulkan::defaultCacheFolder();
    options.submitsUntilLost = request.submitsUntilLost;
    auto device = vulkan::Device::open(options);
    if (!device) return device.error();
    technique->device_ = std::move(*device);
    auto uploader = vulkan::Uploader::make(*technique->device_, kUploadBytes);
    if (!uploader) return uploader.error();
    technique->uploader_ = std::move(*uploader);
    technique->mirror_ = std::make_unique<TileMirror>(*technique->device_, *technique->uploader_);
    TERRAY_TRY(technique->makeFlights());
    return std::unique_ptr<DeviceTechnique>(std::move(technique));
}

Result<void> RayCastVk::makeFlight(Flight& flight) const {
    const uint64_t rays = beamsAtOnce_ * kBeamRays;
    const auto make = [&](vulkan::Buffer& buffer, uint64_t bytes, vulkan::MemoryKind kind) {
        auto made = device_->makeBuffer(bytes, kind);
        if (!made) return Result<void>(made.error());
        buffer = std::move(*made);
        return Result<void>();
    };
    TERRAY_TRY(make(flight.rays, rays * sizeof(TraceRay), vulkan::MemoryKind::Upload));
    TERRAY_TRY(make(flight.hits, rays * sizeof(TraceHit), vulkan::MemoryKind::Device));
    return make(flight.back, rays * sizeof(TraceHit), vulkan::MemoryKind::Readback);
}

/// As many rays at once as there is memory for.
Result<void> RayCastVk::makeFlights() {
    for (;; beamsAtOnce_ /= 2) {
        flights_ = {};
        Result<void> made;
        for (Flight& flight : flights_)
            if (made) made = makeFlight(flight);
        if (made || beamsAtOnce_ / 2 < kLeastBeams) {
            for (Flight& flight : flights_) flight.batches.resize(beamsAtOnce_ * kBeamBlocks);
            return made;
        }
    }
}

Result<void> RayCastVk::makePipeline(const TerrainCut& cut) {
    auto& pipeline = pipelines_[cut.format][cut.surface];
    if (!pipeline) {
        auto made =
            vulkan::ComputePipeline::make(*device_, kSpirv, {5, 0, {cut.format, cut.surface}});
        if (!made) return made.error();
        pipeline = std::move(*made);
    }
    pipeline_ = pipeline.get();
    return {};
}

Result<void> RayCastVk::prepare(const TerrainCut& cut, DeviceFigures& figures) {
    TERRAY_TRY(makePipeline(cut));
    const uint64_t before = uploader_->uploadedBytes();
    auto brought = mirror_->bring(cut);
    if (!brought && !device_->isLost()) static_cast<void>(uploader_->flush());
    figures.uploadedBytes += uploader_->uploadedBytes() - before;
    return brought;
}

/// The rays of a flight, on all cores: of each beam, how far all its rays are clear.
void RayCastVk::place(CastJob& job, Flight& flight) {
    const std::span<TraceRay> rays = flight.rays.mapped<TraceRay>();
    tbb::parallel_for(size_t{0}, flight.beams.size(), [&](size_t b) {
        const BeamPlace& beam = flight.beams[b];
        const ImageTile& tile = job.tiles[beam.tile];
        BeamWalk walk(job.cut,
                      beamOf(job.rays, tile.x + beam.x, tile.y + beam.y, kBeamSide, kBeamSide));
        const double clear = walk.clearTo(std::numeric_limits<double>::infinity());
        for (size_t k = 0; k < kBeamBlocks; ++k) {
            const size_t block = b * kBeamBlocks + k;
            const auto out = rays.subspan(block * kBatchRays, kBatchRays);
            const CastJob::Pixels pixels = job.pixelsOf(beam, k);
            std::array<double, kBatchRays> px, py;
            size_t count = 0;
            for (const auto& [x, y] : kOrder) {
                if (x >= pixels.width || y >= pixels.height) continue;
                px[count] = tile.x + pixels.x + x + job.offset.x;
                py[count++] = tile.y + pixels.y + y + job.offset.y;
            }
            if (count > 0) {
                RayBatch& batch = flight.batches[block];
                job.rays.fillBatch(std::span(px).first(count), std::span(py).first(count), clear,
                                   batch);
                placeTraceRays(job.cut, batch, static_cast<int>(count), walk.level(), out);
            }
            TraceRay none{};
            none.tEnd = -1;
            std::fill(out.begin() + static_cast<ptrdiff_t>(count), out.end(), none);
        }
    });
}

Result<void> RayCastVk::submit(Flight& flight) {
    const uint64_t rays = flight.beams.size() * kBeamRays;
    auto begun = device_->begin();
    if (!begun) return begun.error();
    vulkan::Commands& commands = **begun;
    commands.stamp(0);
    TERRAY_TRY(commands.dispatch(
        *pipeline_,
        {&mirror_->header(), &mirror_->squares(), &mirror_->tiles(), &flight.rays, &flight.hits},
        {}, static_cast<uint32_t>(rays / kBatchRays)));
    commands.stamp(1);
    commands.barrier(vulkan::Stage::Compute, vulkan::Stage::Transfer);
    commands.copy(flight.hits, 0, flight.back, 0, rays * sizeof(TraceHit));
    commands.barrier(vulkan::Stage::Transfer, vulkan::Stage::Host);
    commands.barrier(vulkan::Stage::Transfer, vulkan::Stage::Compute);  // hits are written again
    const auto ticket = device_->submit();
    if (!ticket) return ticket.error();
    flight.ticket = *ticket;
    return {};
}

/// Waits for a flight and puts its hits in their places.
Result<void> RayCastVk::finish(CastJob& job, Flight& flight, DeviceFigures& figures) {
    TERRAY_TRY(device_->wait(flight.ticket));
    figures.deviceMs += device_->msBetween(flight.ticket, 0, 1).value_or(0);
    const std::span<const TraceHit> found = flight.back.mapped<TraceHit>();
    tbb::parallel_for(size_t{0}, flight.beams.size() * kBeamBlocks, [&](size_t block) {
        const BeamPlace& beam = flight.beams[block / kBeamBlocks];
        const CastJob::Pixels pixels = job.pixelsOf(beam, block % kBeamBlocks);
        if (pixels.width <= 0 || pixels.height <= 0) return;
        const int count = pixels.width * pixels.height;
        std::array<Hit, kBatchRays> hits;
        TraceCounters& counters = job.counters.local();
        finishTraceHits(job.cut, flight.batches[block], count,
                        found.subspan(block * kBatchRays, static_cast<size_t>(count)),
                        std::span(hits).first(static_cast<size_t>(count)), counters);
        counters.beams += static_cast<uint64_t>(count);
        const auto stride = static_cast<size_t>(job.tiles[beam.tile].width);
        const std::span<Hit> out =
            job.hits.subspan(job.firstHit[beam.tile] + static_cast<size_t>(pixels.y) * stride +
                             static_cast<size_t>(pixels.x));
        size_t k = 0;
        for (const auto& [x, y] : kOrder)
            if (x < pixels.width && y < pixels.height) out[y * stride + x] = hits[k++];
    });
    flight.beams = {};
    return {};
}

/// While the device traces one flight the cores place and finish the other.
Result<void> RayCastVk::fly(CastJob& job, std::span<const BeamPlace> beams,
                            DeviceFigures& figures) {
    size_t turn = 0;
    for (size_t begin = 0; begin < beams.size(); begin += beamsAtOnce_, turn ^= 1) {
        Flight& flight = flights_[turn];
        if (!flight.beams.empty()) TERRAY_TRY(finish(job, flight, figures));
        flight.beams = beams.subspan(begin, std::min(beamsAtOnce_, beams.size() - begin));
        place(job, flight);
        TERRAY_TRY(submit(flight));
    }
    for (int k = 0; k < 2; ++k, turn ^= 1)
        if (!flights_[turn].beams.empty()) TERRAY_TRY(finish(job, flights_[turn], figures));
    return {};
}

Result<void> RayCastVk::cast(const TerrainCut& cut, const RayFrame& rays,
                             std::span<const ImageTile> tiles, Vec2 offset, std::span<Hit> hits,
                             TraceCounters& counters, DeviceFigures& figures) {
    const Stopwatch watch;
    CastJob job{cut, rays, tiles, {}, offset, hits, {}};
    std::vector<BeamPlace> beams;
    size_t first = 0;
    for (size_t k = 0; k < tiles.size(); ++k) {
        job.firstHit.push_back(first);
        first += tiles[k].pixelCount();
        for (int y = 0; y < tiles[k].height; y += kBeamSide)
            for (int x = 0; x < tiles[k].width; x += kBeamSide) beams.push_back({k, x, y});
    }
    if (const auto flown = fly(job, beams, figures); !flown) {
        if (!device_->isLost()) static_cast<void>(device_->waitIdle());
        for (Flight& flight : flights_) flight.beams = {};
        return flown.error();
    }
    for (const TraceCounters& c : job.counters) counters.add(c);
    figures.castMs += watch.elapsedMs();
    return {};
}

}  // namespace

Result<std::unique_ptr<DeviceTechnique>> openRayCast(const DeviceRequest& request) {
    return RayCastVk::open(request);
}

}  // namespace terray
