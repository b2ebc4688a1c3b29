// SPDX-License-Identifier: Apache-2.0
// The two HeightSources of this room. Both are const-shared; every reader opens the file for
// itself.
#include "raster/raster_source.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "base/assert.h"
#include "raster/sample_reader.h"

namespace terray {
namespace {

constexpr int64_t kFewestRows = 64, kMostRows = kTilePosts;

class RasterReader : public HeightReader {
public:
    RasterReader(const RasterHeader& header, std::optional<PostCodes> codes,
                 std::unique_ptr<SampleReader> samples)
        : header_(header), codes_(codes), samples_(std::move(samples)) {}

    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                      std::span<float> posts) override {
        const SampleWindow window{column, row, width, height};
        TERRAY_ASSERT(posts.size() == window.size());
        return codes_ ? readDecoded(window, posts) : samples_->readHeights(window, posts);
    }

    Result<void> readCodes(int64_t column, int64_t row, int64_t width, int64_t height,
                           std::span<uint16_t> codes) override {
        const SampleWindow window{column, row, width, height};
        TERRAY_ASSERT(codes_ && codes.size() == window.size());
        return samples_->readCodes(window, *codes_, codes);
    }

private:
    /// Heights by way of the codes, so that both kinds of post agree to the last bit.
    Result<void> readDecoded(const SampleWindow& window, std::span<float> posts) {
        return forEachPart(
            window, header_, kPartSamples, [&](const SampleWindow& part) -> Result<void> {
                scratch_.resize(part.size());
                TERRAY_TRY(samples_->readCodes(part, *codes_, scratch_));
                for (int64_t j = 0; j < part.height; ++j) {
                    const uint16_t* in = scratch_.data() + j * part.width;
                    float* out = posts.data() + (part.row - window.row + j) * window.width +
                                 (part.column - window.column);
                    for (int64_t i = 0; i < part.width; ++i) {
                        out[i] = in[i] == kHolePost ? std::numeric_limits<float>::quiet_NaN()
                                                    : codes_->decode(in[i]);
                    }
                }
                return {};
            });
    }

    RasterHeader header_;
    std::optional<PostCodes> codes_;
    std::unique_ptr<SampleReader> samples_;
    std::vector<uint16_t> scratch_;
};

class RasterSource : public HeightSource {
public:
    RasterSource(TerrainInfo info, RasterHeader header, std::optional<PostCodes> codes)
        : info_(std::move(info)), header_(std::move(header)), codes_(codes) {}

    const TerrainInfo& info() const override { return info_; }

    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        Result<std::unique_ptr<SampleReader>> samples = SampleReader::open(header_);
        if (!samples) return samples.error();
        return std::unique_ptr<HeightReader>(
            std::make_unique<RasterReader>(header_, codes_, std::move(*samples)));
    }

    int64_t preferredRows() const override {
        const int64_t block = std::clamp<int64_t>(header_.blockRows, 1, kMostRows);
        return block >= kFewestRows ? block : (kFewestRows + block - 1) / block * block;
    }

private:
    TerrainInfo info_;
    RasterHeader header_;
    std::optional<PostCodes> codes_;
};

class WarpedSource : public HeightSource {
public:
    WarpedSource(TerrainInfo info, WarpPlan plan)
        : info_(std::move(info)), plan_(std::move(plan)) {}

    const TerrainInfo& info() const override { return info_; }
    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        return makeWarpReader(plan_);
    }
    /// Rows of the lattice slant through those of the file: tall bands read it fewer times.
    int64_t preferredRows() const override { return kMostRows - 1; }

private:
    TerrainInfo info_;
    WarpPlan plan_;
};

}  // namespace

std::unique_ptr<HeightSource> makeRasterSource(TerrainInfo info, RasterHeader header,
                                               std::optional<PostCodes> codes) {
    return std::make_unique<RasterSource>(std::move(info), std::move(header), codes);
}

std::unique_ptr<HeightSource> makeWarpedSource(TerrainInfo info, WarpPlan plan) {
    return std::make_unique<WarpedSource>(std::move(info), std::move(plan));
}

}  // namespace terray
