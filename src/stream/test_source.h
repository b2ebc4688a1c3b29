// SPDX-License-Identifier: Apache-2.0
// A HeightSource over an array, for tests; can be told to fail.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "stream/resident.h"

namespace terray::test {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class ArraySource final : public HeightSource {
public:
    ArraySource(int64_t columns, int64_t rows, PostFormat format,
                const std::function<float(int64_t, int64_t)>& height)
        : posts_(static_cast<size_t>(columns * rows)) {
        info_.name = "array";
        info_.scheme = {columns, rows};
        info_.worldFromLattice = {{1000, 2000}, {10, 0}, {0, -10}};
        info_.format = format;
        info_.z0 = -100;
        info_.zStep = 0.125f;
        for (int64_t j = 0; j < rows; ++j) {
            for (int64_t i = 0; i < columns; ++i) {
                posts_[static_cast<size_t>(j * columns + i)] = decoded(height(i, j));
            }
        }
    }
    const TerrainInfo& info() const override { return info_; }
    TerrainInfo& info() { return info_; }
    int64_t preferredRows() const override { return 7; }
    void failAtRow(int64_t row) { failingRow_ = row; }

    float at(int64_t i, int64_t j) const {
        return posts_[static_cast<size_t>(j * info_.scheme.columns + i)];
    }

    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        return std::unique_ptr<HeightReader>(new Reader(*this));
    }

private:
    class Reader final : public HeightReader {
    public:
        explicit Reader(const ArraySource& source) : source_(source) {}
        Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                          std::span<float> posts) override {
            return each(column, row, width, height, [&](size_t k, float z) { posts[k] = z; });
        }
        Result<void> readCodes(int64_t column, int64_t row, int64_t width, int64_t height,
                               std::span<uint16_t> codes) override {
            return each(column, row, width, height,
                        [&](size_t k, float z) { codes[k] = source_.code(z); });
        }

    private:
        Result<void> each(int64_t column, int64_t row, int64_t width, int64_t height,
                          const std::function<void(size_t, float)>& put) {
            if (source_.failingRow_ >= row && source_.failingRow_ < row + height) {
                return Error{ErrorCode::Input, "row cannot be read"};
            }
            size_t k = 0;
            for (int64_t j = row; j < row + height; ++j) {
                for (int64_t i = column; i < column + width; ++i) put(k++, source_.at(i, j));
            }
            return {};
        }
        const ArraySource& source_;
    };

    uint16_t code(float z) const {
        if (std::isnan(z)) return kHolePost;
        return static_cast<uint16_t>(std::lround((z - info_.z0) / info_.zStep));
    }
    float decoded(float z) const {
        if (info_.format == PostFormat::Float32 || std::isnan(z)) return z;
        return std::fma(info_.zStep, static_cast<float>(code(z)), info_.z0);
    }

    TerrainInfo info_;
    std::vector<float> posts_;
    int64_t failingRow_ = -1;
};

/// Rolling hills with noise and, if asked, holes: single posts and a disc. Heights 0 .. 600.
inline std::function<float(int64_t, int64_t)> hills(uint32_t seed, bool holes) {
    return [seed, holes](int64_t i, int64_t j) {
        std::minstd_rand random(
            static_cast<uint32_t>(i * 7919 + j * 104729 + int64_t{seed} * 15485863 + 1));
        random.discard(3);
        const double noise = static_cast<double>(random() % 1000) / 100.0;
        const auto x = static_cast<double>(i), y = static_cast<double>(j);
        const bool disc = std::hypot(x - 300, y - 250) < 60;
        if (holes && (disc || random() % 4000 == 0)) return kNaN;
        return static_cast<float>(300 + 200 * std::sin(x / 90) * std::cos(y / 70) + noise);
    };
}

inline std::unique_ptr<ResidentTerrain> built(const HeightSource& source) {
    BuildStats stats;
    auto terrain = ResidentTerrain::build(source, uint64_t{4} << 30, stats);
    return terrain.ok() ? std::move(*terrain) : nullptr;
}

}  // namespace terray::test
