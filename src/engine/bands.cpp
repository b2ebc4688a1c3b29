// SPDX-License-Identifier: Apache-2.0
// Bands of image tiles: cast, shade, resolve, while the last band is being written.
#include "engine/bands.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>

#include "base/interrupt.h"
#include "base/progress.h"
#include "base/stopwatch.h"
#include "engine/sample_pattern.h"

namespace terray {
namespace {

constexpr Vec2 kCentre{0.5, 0.5};  ///< of a pixel

/// One thread's buffers and figures.
struct Worker {
    std::vector<Hit> own;       ///< cast by this thread
    std::span<const Hit> hits;  ///< of the image tile at hand
    std::vector<Colour> sum;
    std::vector<uint8_t> display;
    std::vector<float> aov;
    BandFigures figures;
};

/// Copies a tile's rows into a band's: `channels` values a pixel.
template <class T>
void copyTile(const ImageTile& tile, int firstRow, int pictureWidth, size_t channels,
              const std::vector<T>& from, std::vector<T>& to) {
    const size_t width = static_cast<size_t>(tile.width) * channels;
    for (int row = 0; row < tile.height; ++row) {
        const size_t line = static_cast<size_t>(tile.y - firstRow + row);
        const size_t begin =
            (line * static_cast<size_t>(pictureWidth) + static_cast<size_t>(tile.x)) * channels;
        std::copy_n(from.begin() + static_cast<ptrdiff_t>(static_cast<size_t>(row) * width), width,
                    to.begin() + static_cast<ptrdiff_t>(begin));
    }
}

class BandRenderer {
public:
    BandRenderer(const Frame& frame, const BandDemand& demand)
        : frame_(frame),
          demand_(demand),
          onDevice_(frame.onDevice),
          ahead_(frame.cut.cut(), frame.rays, offsetsOf(frame, demand)) {}

    /// Error: the device's, or a photo that cannot be read.
    Result<void> render(Band& band, Progress& progress) {
        const int tilesX = (frame_.camera().width + kTileWidth - 1) / kTileWidth;
        const int tilesY = (band.rows + kTileHeight - 1) / kTileHeight;
        std::vector<ImageTile> tiles;
        for (int y = 0; y < tilesY; ++y)
            for (int x = 0; x < tilesX; ++x) tiles.push_back(tileAt(x, y, band));
        const size_t step = onDevice_ != nullptr ? ahead_.tilesAtOnce() : tiles.size();
        for (size_t first = 0; first < tiles.size() && !isInterrupted(); first += step) {
            const auto part = std::span(tiles).subspan(first, std::min(step, tiles.size() - first));
            TERRAY_TRY(castAhead(part));
            tbb::parallel_for(size_t{0}, part.size(), [&](size_t k) {
                if (isInterrupted()) return;
                renderTile(part[k], workers_.local(), band);
                progress.advance();
            });
        }
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        if (frame_.photo && demand_.picture()) TERRAY_TRY(finishPhoto(band));
        if (frame_.annotations && demand_.display)
            frame_.annotations->drawOn(band.firstRow, band.rows, band.display);
        return {};
    }

    BandFigures figures() const {
        BandFigures sum = ofDevice_;
        for (const Worker& w : again_) {
            sum.displayMs += w.figures.displayMs + w.figures.shade.displayMs;
            sum.shade.shadowMs += w.figures.shade.shadowMs;
            sum.traceMs += w.figures.traceMs;
            sum.shadeMs += w.figures.shadeMs;
        }
        for (const Worker& w : workers_) {
            sum.trace.add(w.figures.trace);
            sum.lateHits += w.figures.lateHits;
            sum.shade.shadowRays += w.figures.shade.shadowRays;
            sum.shade.shadowMs += w.figures.shade.shadowMs;
            sum.displayMs += w.figures.displayMs + w.figures.shade.displayMs;
            sum.traceMs += w.figures.traceMs;
            sum.shadeMs += w.figures.shadeMs;
        }
        return sum;
    }

private:
    /// The places in a pixel through which rays are cast.
    static std::vector<Vec2> offsetsOf(const Frame& frame, const BandDemand& demand) {
        std::vector<Vec2> offsets;
        if (demand.picture()) {
            const auto pattern = samplePattern(frame.options.samples);
            offsets.assign(pattern.begin(), pattern.end());
        }
        if (!demand.aovs.empty() && (!demand.picture() || frame.options.samples != 1))
            offsets.push_back(kCentre);
        return offsets;
    }

    /// On a device all rays of some image tiles are cast before any of them is shaded.
    Result<void> castAhead(std::span<const ImageTile> tiles) {
        ahead_.clear();
        if (onDevice_ == nullptr) return {};
        BandFigures figures = ofDevice_;  // of half a cast nothing counts
        const auto cast =
            ahead_.cast(*onDevice_, {tiles.begin(), tiles.end()}, figures.trace, figures.device);
        if (cast) {
            ofDevice_ = figures;
            return {};
        }
        onDevice_ = nullptr;
        ofDevice_.lostDevice = true;
        return frame_.caster->giveUpIfLost(cast.error());
    }

    ImageTile tileAt(int x, int y, const Band& band) const {
        ImageTile tile{x * kTileWidth, band.firstRow + y * kTileHeight, 0, 0};
        tile.width = std::min(kTileWidth, frame_.camera().width - tile.x);
        tile.height = std::min(kTileHeight, band.firstRow + band.rows - tile.y);
        return tile;
    }

    /// Image tiles that lacked blocks of a photo are made once more; their rays count once.
    Result<void> finishPhoto(Band& band) {
        return frame_.photo->finishBand([&](std::span<const ImageTile> tiles) {
            tbb::parallel_for(size_t{0}, tiles.size(), [&](size_t k) {
                if (!isInterrupted()) drawTile(tiles[k], again_.local(), band);
            });
        });
    }

    /// True if the worker's hits are those through the pixels' centres.
    bool drawTile(const ImageTile& tile, Worker& worker, Band& band) const {
        PhotoUse& photo = worker.figures.shade.photo;
        if (frame_.photo) frame_.shader->prepareUse(photo);
        const bool haveCentres = frame_.options.samples == 1;
        if (haveCentres && !demand_.linear)
            castAndShow(tile, worker, band);
        else
            castAndShade(tile, worker, band);
        if (frame_.photo) frame_.photo->note(tile, photo);
        return haveCentres;
    }

    void renderTile(const ImageTile& tile, Worker& worker, Band& band) const {
        const bool haveCentres = demand_.picture() && drawTile(tile, worker, band);
        if (demand_.aovs.empty()) return;
        if (!haveCentres) cast(tile, kCentre, worker);
        fillAovs(tile, worker, band);
    }

    void cast(const ImageTile& tile, Vec2 offset, Worker& worker) const {
        worker.hits = ahead_.hitsOf(tile, offset);
        if (!worker.hits.empty()) return;
        const CpuStopwatch watch;
        worker.own.resize(tile.pixelCount());
        frame_.technique->castTile(frame_.cut.cut(), frame_.rays, tile, offset, worker.own,
                                   worker.figures.trace);
        worker.hits = worker.own;
        worker.figures.traceMs += watch.elapsedMs();
        if (!frame_.cut.mayBeLate()) return;
        worker.figures.lateHits += static_cast<uint64_t>(
            std::count_if(worker.hits.begin(), worker.hits.end(),
                          [&](const Hit& hit) { return isHit(hit) && frame_.cut.isLate(hit); }));
    }

    /// Calls shade(part, its hits, its first pixel) for a few rows at a time: what shading keeps of
    /// a pixel is many times its hit.
    template <class Shade>
    void eachPart(const ImageTile& tile, Worker& worker, const Shade& shade) const {
        const CpuStopwatch watch;
        constexpr int kRows = 32;
        for (int row = 0; row < tile.height; row += kRows) {
            const ImageTile part{tile.x, tile.y + row, tile.width,
                                 std::min(kRows, tile.height - row)};
            const size_t first = static_cast<size_t>(row) * static_cast<size_t>(tile.width);
            shade(part, worker.hits.subspan(first, part.pixelCount()), first);
        }
        worker.figures.shadeMs += watch.elapsedMs();
    }

    /// One sample a pixel, and nothing but the display wants it.
    void castAndShow(const ImageTile& tile, Worker& worker, Band& band) const {
        const Vec2 offset = samplePattern(1)[0];
        cast(tile, offset, worker);
        worker.display.resize(tile.pixelCount() * 4);
        eachPart(tile, worker, [&](const ImageTile& part, auto hits, size_t first) {
            frame_.shader->showTile(
                part, offset, hits,
                std::span(worker.display).subspan(4 * first, 4 * part.pixelCount()),
                worker.figures.shade);
        });
        copyTile(tile, band.firstRow, frame_.camera().width, 4, worker.display, band.display);
    }

    void castAndShade(const ImageTile& tile, Worker& worker, Band& band) const {
        const std::span<const Vec2> pattern = samplePattern(frame_.options.samples);
        const float weight = 1.0f / static_cast<float>(pattern.size());
        worker.sum.assign(tile.pixelCount(), Colour{});
        for (const Vec2 offset : pattern) {
            cast(tile, offset, worker);
            eachPart(tile, worker, [&](const ImageTile& part, auto hits, size_t first) {
                frame_.shader->shadeTile(part, offset, hits, weight,
                                         std::span(worker.sum).subspan(first, part.pixelCount()),
                                         worker.figures.shade);
            });
        }
        resolve(tile, worker, band);
    }

    void resolve(const ImageTile& tile, Worker& worker, Band& band) const {
        const int width = frame_.camera().width;
        if (demand_.linear) copyTile(tile, band.firstRow, width, 1, worker.sum, band.linear);
        if (!demand_.display) return;
        const CpuStopwatch watch;
        worker.display.resize(tile.pixelCount() * 4);
        frame_.shader->toDisplay(worker.sum, worker.display);
        copyTile(tile, band.firstRow, width, 4, worker.display, band.display);
        const double ms = watch.elapsedMs();
        worker.figures.displayMs += ms;
        worker.figures.shadeMs += ms;
    }

    void fillAovs(const ImageTile& tile, Worker& worker, Band& band) const {
        const CpuStopwatch watch;
        for (size_t k = 0; k < demand_.aovs.size(); ++k) {
            const auto channels = static_cast<size_t>(aovChannels(demand_.aovs[k]));
            worker.aov.resize(tile.pixelCount() * channels);
            frame_.shader->fillAov(demand_.aovs[k], tile, worker.hits, worker.aov);
            copyTile(tile, band.firstRow, frame_.camera().width, channels, worker.aov,
                     band.aovs[k]);
        }
        worker.figures.shadeMs += watch.elapsedMs();
    }

    const Frame& frame_;
    const BandDemand& demand_;
    DeviceTechnique* onDevice_;
    TilesAhead ahead_;
    BandFigures ofDevice_;
    tbb::enumerable_thread_specific<Worker> workers_;
    tbb::enumerable_thread_specific<Worker> again_;  ///< of tiles that are made once more
};

size_t bytesPerPixel(const BandDemand& demand) {
    size_t bytes = (demand.linear ? sizeof(Colour) : 0) + (demand.display ? 4 : 0);
    for (const Aov aov : demand.aovs)
        bytes += sizeof(float) * static_cast<size_t>(aovChannels(aov));
    return bytes;
}

void resizeBand(Band& band, int width, const BandDemand& demand) {
    const size_t pixels = static_cast<size_t>(band.rows) * static_cast<size_t>(width);
    if (demand.linear) band.linear.resize(pixels);
    if (demand.display) band.display.resize(pixels * 4);
    band.aovs.resize(demand.aovs.size());
    for (size_t k = 0; k < demand.aovs.size(); ++k)
        band.aovs[k].resize(pixels * static_cast<size_t>(aovChannels(demand.aovs[k])));
}

}  // namespace

int bandRows(int width, const BandDemand& demand) {
    constexpr size_t kBandBytes = size_t{32} << 20;
    constexpr size_t kRows = 2 * kTileHeight;
    const size_t row = bytesPerPixel(demand) * static_cast<size_t>(width);
    const size_t rows = std::clamp(kBandBytes / row, size_t{1}, kRows);
    return static_cast<int>(rows > kTileHeight ? rows / kTileHeight * kTileHeight : rows);
}

Result<BandFigures> renderBands(const Frame& frame, const BandDemand& demand,
                                const std::function<Result<void>(const Band&)>& sink) {
    const int width = frame.camera().width, height = frame.camera().height;
    const int step = bandRows(width, demand);
    const double bands = (height + step - 1) / step;
    const double tilesPerBand =
        ((width + kTileWidth - 1) / kTileWidth) * ((step + kTileHeight - 1) / kTileHeight);
    Progress progress("rendering", bands * tilesPerBand);
    BandRenderer renderer(frame, demand);
    Band pair[2];
    Result<void> written;
    tbb::task_group writing;
    int turn = 0;
    for (int row = 0; row < height; row += step, turn ^= 1) {
        Band& band = pair[turn];
        band.firstRow = row;
        band.rows = std::min(step, height - row);
        resizeBand(band, width, demand);
        const Result<void> rendered = renderer.render(band, progress);
        writing.wait();
        if (!rendered) return rendered.error();
        if (!written) return written.error();
        writing.run([&band, &written, &sink] { written = sink(band); });
    }
    writing.wait();
    if (!written) return written.error();
    return renderer.figures();
}

}  // namespace terray
