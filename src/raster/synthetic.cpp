// SPDX-License-Identifier: Apache-2.0
// The fractal and the town, made row by row, and the names that stand for them.
#include "raster/synthetic.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "base/assert.h"
#include "raster/synthetic_noise.h"

namespace terray {
namespace {

using synthetic::hashPlace;
using synthetic::NoiseOctave;

constexpr float kZStep = 0.05f;  ///< metres per code of Int16 posts
constexpr int64_t kMaxPosts = int64_t{1} << 24;
constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

/// The power of two (as its exponent) of posts that comes near a length.
int log2Posts(double metres, double cell, int smallest) {
    constexpr int kLargest = 16;
    int exponent = smallest;
    while (exponent < kLargest && cell * std::ldexp(1.5, exponent) < metres) ++exponent;
    return exponent;
}

/// Four ridged octaves (Musgrave's ridged multifractal: ridges carry smaller ridges), then plain
/// ones down to two posts, rougher where the ground is high. Makes the rows of one window.
/// confined.
class FractalRows {
public:
    FractalRows(const SyntheticOptions& options, int64_t column, int64_t width)
        : width_(static_cast<size_t>(width)), weight_(width_) {
        const int coarsest = log2Posts(kLongest, options.cell, 6);
        float amplitude = 1;
        for (int log2 = coarsest; log2 >= 1; --log2) {
            octaves_.emplace_back(log2, options.seed, column, width);
            amplitudes_.push_back(amplitude);
            amplitude *= kPersistence;
        }
    }

    void makeRow(int64_t row, float* out) {
        std::fill_n(out, width_, 0.0f);
        std::fill(weight_.begin(), weight_.end(), 1.0f);
        for (size_t o = 0; o < kRidged; ++o) addRidges(octaves_[o].row(row), amplitudes_[o], out);
        for (size_t i = 0; i < width_; ++i) {
            weight_[i] = kSmoothest + (1 - kSmoothest) * std::min(1.0f, out[i]);
        }
        for (size_t o = kRidged; o < octaves_.size(); ++o) {
            addRoughness(octaves_[o].row(row), amplitudes_[o], out);
        }
        for (size_t i = 0; i < width_; ++i) {
            out[i] = std::clamp((out[i] - kLowest) * kScale, 0.0f, kTop);
        }
    }

    static constexpr float kTop = 2800;  ///< metres

private:
    // Tuned so that the range is filled and 27 % of the cells of 10 m are steeper than 60 degrees.
    static constexpr double kLongest = 10240;           ///< longest wave, metres
    static constexpr float kPersistence = 0.65975396f;  ///< 2^-0.6: amplitudes of halved waves
    static constexpr float kSharpness = 1.7f, kFeedback = 1.6f;
    static constexpr float kSmoothest = 0.3f;  ///< share of the roughness that valleys keep
    static constexpr float kLowest = 0.08f, kScale = 1252.8f;
    static constexpr size_t kRidged = 4;

    void addRidges(const float* noise, float amplitude, float* __restrict out) {
        float* const weight = weight_.data();
        for (size_t i = 0; i < width_; ++i) {
            const float crest = std::max(0.0f, 1 - std::abs(noise[i]) * kSharpness);
            const float ridge = crest * crest * weight[i];
            out[i] += amplitude * ridge;
            weight[i] = std::min(1.0f, ridge * kFeedback);
        }
    }

    void addRoughness(const float* noise, float amplitude, float* __restrict out) const {
        const float* const weight = weight_.data();
        for (size_t i = 0; i < width_; ++i) out[i] += amplitude * noise[i] * weight[i];
    }

    size_t width_;
    std::vector<NoiseOctave> octaves_;
    std::vector<float> amplitudes_;
    std::vector<float> weight_;  // of the next ridges, then of the roughness
};

/// What stands on a lot: a box around a centre with a shape inside.
struct TownShape {
    enum Kind { Flat, Gable, Dome, Pond } kind = Flat;
    double x = 0, y = 0, halfX = 0, halfY = 0;  ///< metres
    double wall = 0, roof = 0;                  ///< metres above ground, and above the wall
};

/// What `shape` adds to the ground at an offset from its centre; NaN makes a hole.
float townHeight(const TownShape& shape, double dx, double dy) {
    const double u = std::abs(dx) / shape.halfX, v = std::abs(dy) / shape.halfY;
    switch (shape.kind) {
        case TownShape::Flat: return static_cast<float>(shape.wall);
        case TownShape::Gable: return static_cast<float>(shape.wall + shape.roof * (1 - v));
        case TownShape::Dome:
            if (u * u + v * v > 1) return 0;
            return static_cast<float>(shape.wall + shape.roof * std::sqrt(1 - u * u - v * v));
        case TownShape::Pond: return u * u + v * v > 1 ? 0.0f : kVoid;
    }
    return 0;
}

/// Lots of 40 m, each with a house, a tower, a pond or trees, on waves of ground.
class TownRows {
public:
    TownRows(const SyntheticOptions& options, int64_t column, int64_t width)
        : cell_(options.cell), seed_(options.seed), column_(column), width_(width) {
        const std::array<double, 3> waves{1024, 256, 32};  // metres
        for (const double wave : waves) {
            ground_.emplace_back(log2Posts(wave, cell_, 1), seed_, column, width);
        }
    }

    void makeRow(int64_t row, float* out) {
        const std::array<float, 3> amplitudes{20, 6, 0.5f};  // metres
        std::fill_n(out, width_, 30.0f);
        for (size_t o = 0; o < ground_.size(); ++o) {
            const float* const noise = ground_[o].row(row);
            for (int64_t i = 0; i < width_; ++i) out[i] += amplitudes[o] * noise[i];
        }
        const double y = static_cast<double>(row) * cell_;
        const auto lotRow = static_cast<int64_t>(std::floor(y / kLot));
        if (shapes_.empty() || lotRow != lotRow_) buildShapes(lotRow);
        for (const TownShape& shape : shapes_) {
            if (std::abs(y - shape.y) <= shape.halfY) place(shape, y, out);
        }
        cutStrip(y, out);
    }

    static constexpr float kTop = 160;  ///< metres; no tower is higher

private:
    static constexpr double kLot = 40;                       ///< metres
    static constexpr double kStripEvery = 1500, kStrip = 6;  ///< metres

    void buildShapes(int64_t lotRow) {
        shapes_.clear();
        lotRow_ = lotRow;
        const auto lotOf = [&](int64_t i) {
            return static_cast<int64_t>(std::floor(static_cast<double>(i) * cell_ / kLot));
        };
        for (int64_t lot = lotOf(column_); lot <= lotOf(column_ + width_ - 1); ++lot) {
            buildLot(lot, lotRow);
        }
    }

    void buildLot(int64_t lotX, int64_t lotY) {
        uint32_t salt = seed_ * 16;
        const auto random = [&](double lo, double hi) {
            return lo + (hi - lo) * (hashPlace(lotX, lotY, salt++) * 0x1p-32);
        };
        const double x = (static_cast<double>(lotX) + 0.5) * kLot;
        const double y = (static_cast<double>(lotY) + 0.5) * kLot;
        const double kind = random(0, 1);
        if (kind < 0.06) {
            shapes_.push_back({TownShape::Pond, x, y, random(8, 18), random(8, 18), 0, 0});
            return;
        }
        if (kind < 0.12) {
            shapes_.push_back(
                {TownShape::Flat, x - 5, y, random(4, 8), random(4, 8), random(35, 95), 0});
        } else if (kind < 0.7) {
            const bool gabled = random(0, 1) < 0.6;
            shapes_.push_back({gabled ? TownShape::Gable : TownShape::Flat, x - 5, y, random(4, 10),
                               random(4, 8), random(3, 9), random(2, 5)});
        } else {
            const double left = random(6, 12), up = random(6, 12), down = random(6, 12);
            addTree(x - left, y - up, random(2, 6));
            addTree(x - left, y + down, random(2, 6));
        }
        const double along = random(-12, 12);
        addTree(x + 13, y + along, random(2, 6));
    }

    void addTree(double x, double y, double radius) {
        shapes_.push_back({TownShape::Dome, x, y, radius, radius, radius, radius * 1.5});
    }

    void place(const TownShape& shape, double y, float* out) const {
        const auto first = static_cast<int64_t>(std::ceil((shape.x - shape.halfX) / cell_));
        const auto last = static_cast<int64_t>(std::floor((shape.x + shape.halfX) / cell_));
        for (int64_t i = std::max(first, column_); i <= std::min(last, column_ + width_ - 1); ++i) {
            out[i - column_] +=
                townHeight(shape, static_cast<double>(i) * cell_ - shape.x, y - shape.y);
        }
    }

    /// A slanting strip without data, as between two flight lines.
    void cutStrip(double y, float* out) const {
        for (int64_t i = 0; i < width_; ++i) {
            const double across =
                static_cast<double>(column_ + i) * cell_ + 0.5 * y + kStripEvery / 2;
            const double phase = across - kStripEvery * std::floor(across / kStripEvery);
            if (phase < kStrip) out[i] = kVoid;
        }
    }

    double cell_;
    uint32_t seed_;
    int64_t column_, width_, lotRow_ = 0;
    std::vector<NoiseOctave> ground_;
    std::vector<TownShape> shapes_;  // of the lots that the current row crosses
};

uint16_t codeOf(float z) {
    return z == z ? static_cast<uint16_t>(static_cast<int32_t>(z * (1 / kZStep) + 0.5f))
                  : kHolePost;
}

float heightOf(uint16_t code) {
    return code == kHolePost ? kVoid : kZStep * static_cast<float>(code);
}

template <class Rows>
class SyntheticReader final : public HeightReader {
public:
    explicit SyntheticReader(const SyntheticOptions& options) : options_(options) {}

    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                      std::span<float> posts) override {
        checkWindow(column, row, width, height, posts.size());
        Rows rows(options_, column, width);
        for (int64_t j = 0; j < height; ++j) {
            float* const out = posts.data() + j * width;
            rows.makeRow(row + j, out);
            if (options_.format == PostFormat::Float32) continue;
            for (int64_t i = 0; i < width; ++i) out[i] = heightOf(codeOf(out[i]));
        }
        return {};
    }

    Result<void> readCodes(int64_t column, int64_t row, int64_t width, int64_t height,
                           std::span<uint16_t> codes) override {
        TERRAY_ASSERT(options_.format == PostFormat::Int16);
        checkWindow(column, row, width, height, codes.size());
        Rows rows(options_, column, width);
        std::vector<float> heights(static_cast<size_t>(width));
        for (int64_t j = 0; j < height; ++j) {
            rows.makeRow(row + j, heights.data());
            std::transform(heights.begin(), heights.end(), codes.begin() + j * width, codeOf);
        }
        return {};
    }

private:
    void checkWindow([[maybe_unused]] int64_t column, [[maybe_unused]] int64_t row,
                     [[maybe_unused]] int64_t width, [[maybe_unused]] int64_t height,
                     [[maybe_unused]] size_t size) const {
        TERRAY_ASSERT(column >= 0 && row >= 0 && width > 0 && height > 0);
        TERRAY_ASSERT(column + width <= options_.columns && row + height <= options_.rows);
        TERRAY_ASSERT(size == static_cast<size_t>(width) * static_cast<size_t>(height));
    }

    SyntheticOptions options_;
};

template <class Rows>
class SyntheticSource final : public HeightSource {
public:
    SyntheticSource(const SyntheticOptions& options, std::string name) : options_(options) {
        TERRAY_ASSERT(options.columns >= 2 && options.rows >= 2 && options.cell > 0);
        const double cell = options.cell;
        info_.name = std::move(name);
        info_.scheme = {options.columns, options.rows};
        info_.worldFromLattice = {
            {0, static_cast<double>(options.rows - 1) * cell}, {cell, 0}, {0, -cell}};
        info_.format = options.format;
        if (options.format == PostFormat::Int16) info_.zStep = kZStep;
        info_.maxZ = Rows::kTop;
    }

    const TerrainInfo& info() const override { return info_; }
    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        return std::unique_ptr<HeightReader>(std::make_unique<SyntheticReader<Rows>>(options_));
    }

private:
    SyntheticOptions options_;
    TerrainInfo info_;
};

template <class T>
bool parseNumber(std::string_view text, T lo, T hi, T& out) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return false;
    if (!(value >= lo && value <= hi)) return false;
    out = value;
    return true;
}

bool applyKey(std::string_view key, std::string_view value, SyntheticOptions& options) {
    const int64_t fewest = 2;
    if (key == "columns") return parseNumber(value, fewest, kMaxPosts, options.columns);
    if (key == "rows") return parseNumber(value, fewest, kMaxPosts, options.rows);
    if (key == "cell") return parseNumber(value, 1e-3, 1e6, options.cell);
    if (key == "seed") return parseNumber(value, 0u, ~0u, options.seed);
    if (key == "format" && (value == "int16" || value == "float")) {
        options.format = value == "int16" ? PostFormat::Int16 : PostFormat::Float32;
        return true;
    }
    return false;
}

/// "size=4096&cell=10": `size` first, so that `columns` and `rows` override it wherever they stand.
Result<void> applyQuery(const std::string& name, std::string_view query,
                        SyntheticOptions& options) {
    for (const bool sizePass : {true, false}) {
        for (std::string_view rest = query; !rest.empty();) {
            const std::string_view item = rest.substr(0, rest.find('&'));
            rest.remove_prefix(std::min(rest.size(), item.size() + 1));
            const size_t equals = item.find('=');
            const std::string_view key = item.substr(0, equals);
            const std::string_view value =
                equals == std::string_view::npos ? "" : item.substr(equals + 1);
            bool good = true;
            if (sizePass && key == "size") {
                good = parseNumber(value, int64_t{2}, kMaxPosts, options.columns);
                options.rows = options.columns;
            } else if (!sizePass && key != "size") {
                good = applyKey(key, value, options);
            }
            if (!good) {
                return makeError(ErrorCode::Usage,
                                 "'{}': '{}' is not understood; keys are size, columns, rows (2 to "
                                 "{}), cell (metres), seed, format (int16 or float)",
                                 name, item, kMaxPosts);
            }
        }
    }
    return {};
}

}  // namespace

std::unique_ptr<HeightSource> makeFractal(const SyntheticOptions& options) {
    return std::make_unique<SyntheticSource<FractalRows>>(options, "synthetic:fractal");
}

std::unique_ptr<HeightSource> makeTown(const SyntheticOptions& options) {
    return std::make_unique<SyntheticSource<TownRows>>(options, "synthetic:town");
}

Result<std::unique_ptr<HeightSource>> makeSynthetic(const std::string& name) {
    constexpr std::string_view kPrefix = "synthetic:";
    std::unique_ptr<HeightSource> source;
    if (!name.starts_with(kPrefix)) return source;
    const std::string_view text = std::string_view(name).substr(kPrefix.size());
    const size_t mark = text.find('?');
    const std::string_view kind = text.substr(0, mark);
    SyntheticOptions options;
    if (kind == "town") options.cell = 1;
    if (mark != std::string_view::npos) {
        TERRAY_TRY(applyQuery(name, text.substr(mark + 1), options));
    }
    if (kind == "fractal") {
        source = std::make_unique<SyntheticSource<FractalRows>>(options, name);
    } else if (kind == "town") {
        source = std::make_unique<SyntheticSource<TownRows>>(options, name);
    } else {
        return makeError(ErrorCode::Usage,
                         "'{}' is not a synthetic terrain; there are synthetic:fractal and "
                         "synthetic:town",
                         name);
    }
    return source;
}

}  // namespace terray
