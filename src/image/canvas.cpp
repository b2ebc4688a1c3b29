// SPDX-License-Identifier: Apache-2.0
// Drawing on a canvas, halos by blurring, composing on pictures.
#include "image/canvas.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"

namespace terray {
namespace {

uint8_t byteOf(float value) { return static_cast<uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

bool isInside(std::span<const Vec2> corners, Vec2 p) {
    bool inside = false;
    for (size_t k = 0, before = corners.size() - 1; k < corners.size(); before = k++) {
        const Vec2 a = corners[before], b = corners[k];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        if (p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
    }
    return inside;
}

/// Mean over 2 * radius + 1 neighbours along lines of `count` values, `step` apart.
void boxBlurLine(float* values, int count, size_t step, int radius, std::vector<float>& line) {
    line.resize(static_cast<size_t>(count));
    for (int k = 0; k < count; ++k) {
        line[static_cast<size_t>(k)] = values[static_cast<size_t>(k) * step];
    }
    const float share = 1.0f / static_cast<float>(2 * radius + 1);
    float sum = 0;
    for (int k = 0; k < std::min(radius, count); ++k) sum += line[static_cast<size_t>(k)];
    for (int k = 0; k < count; ++k) {
        if (k + radius < count) sum += line[static_cast<size_t>(k + radius)];
        if (k - radius - 1 >= 0) sum -= line[static_cast<size_t>(k - radius - 1)];
        values[static_cast<size_t>(k) * step] = sum * share;
    }
}

}  // namespace

Canvas::Canvas(int width, int height)
    : width_(width),
      height_(height),
      pixels_(static_cast<size_t>(width) * static_cast<size_t>(height)) {
    TERRAY_ASSERT(width >= 1 && height >= 1);
}

void Canvas::blend(int x, int y, Ink ink, float cover) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_ || cover <= 0) return;
    Pixel& pixel = at(x, y);
    const float rest = 1 - cover;
    pixel.r = byteOf(cover * ink[0] + rest * pixel.r);
    pixel.g = byteOf(cover * ink[1] + rest * pixel.g);
    pixel.b = byteOf(cover * ink[2] + rest * pixel.b);
    pixel.a = byteOf(cover * 255 + rest * pixel.a);
}

void Canvas::fillRectangle(int x0, int y0, int x1, int y1, Ink ink) {
    for (int y = std::max(y0, 0); y < std::min(y1, height_); ++y) {
        for (int x = std::max(x0, 0); x < std::min(x1, width_); ++x) blend(x, y, ink, 1);
    }
}

void Canvas::fillPolygon(std::span<const Vec2> corners, Ink ink) {
    constexpr int kSide = 4;  // sub-samples a pixel, each way
    Vec2 low = corners[0], high = corners[0];
    for (const Vec2& corner : corners) {
        low = glm::min(low, corner);
        high = glm::max(high, corner);
    }
    const int x0 = std::max(static_cast<int>(std::floor(low.x)), 0);
    const int y0 = std::max(static_cast<int>(std::floor(low.y)), 0);
    const int x1 = std::min(static_cast<int>(std::ceil(high.x)), width_);
    const int y1 = std::min(static_cast<int>(std::ceil(high.y)), height_);
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            int inside = 0;
            for (int s = 0; s < kSide * kSide; ++s) {
                const Vec2 sample{x + (s % kSide + 0.5) / kSide, y + (s / kSide + 0.5) / kSide};
                inside += isInside(corners, sample) ? 1 : 0;
            }
            blend(x, y, ink, static_cast<float>(inside) / (kSide * kSide));
        }
    }
}

void Canvas::drawText(const TextBitmap& text, int x, int y, TextAlign align, Ink ink) {
    if (align == TextAlign::Centre) x -= text.width / 2;
    if (align == TextAlign::Right) x -= text.width;
    const int top = y - text.baseline;
    for (int row = 0; row < text.height; ++row) {
        for (int column = 0; column < text.width; ++column) {
            const float cover = text.coverage[static_cast<size_t>(row * text.width + column)];
            blend(x + column, top + row, ink, cover);
        }
    }
}

void Canvas::addHalo(double radius, Ink ink, float strength) {
    constexpr int kPasses = 3;     // three boxes come close to a bell curve
    constexpr float kGain = 9.0f;  // so that thin strokes get a full halo
    std::vector<float> halo(pixels_.size());
    for (size_t k = 0; k < pixels_.size(); ++k) halo[k] = static_cast<float>(pixels_[k].a) / 255.0f;
    const int box = std::max(1, static_cast<int>(std::lround(radius / 2)));
    std::vector<float> line;
    for (int pass = 0; pass < kPasses; ++pass) {
        for (int y = 0; y < height_; ++y) boxBlurLine(&halo[index(0, y)], width_, 1, box, line);
        for (int x = 0; x < width_; ++x) {
            boxBlurLine(&halo[index(x, 0)], height_, static_cast<size_t>(width_), box, line);
        }
    }
    for (size_t k = 0; k < pixels_.size(); ++k) {
        Pixel& pixel = pixels_[k];
        const float under =
            strength * std::min(1.0f, kGain * halo[k]) * (1 - static_cast<float>(pixel.a) / 255.0f);
        pixel.r = byteOf(pixel.r + under * ink[0]);
        pixel.g = byteOf(pixel.g + under * ink[1]);
        pixel.b = byteOf(pixel.b + under * ink[2]);
        pixel.a = byteOf(pixel.a + under * 255);
    }
}

void Canvas::composeOn(int left, int top, int pictureWidth, int firstRow, int rows,
                       std::span<uint8_t> rgba) const {
    TERRAY_ASSERT(rgba.size() == 4 * static_cast<size_t>(pictureWidth) * static_cast<size_t>(rows));
    const int x0 = std::max(left, 0), x1 = std::min(left + width_, pictureWidth);
    const int y0 = std::max(top, firstRow), y1 = std::min(top + height_, firstRow + rows);
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            const Pixel& over = pixels_[index(x - left, y - top)];
            if (over.a == 0) continue;
            uint8_t* under =
                &rgba[4 * (static_cast<size_t>(y - firstRow) * static_cast<size_t>(pictureWidth) +
                           static_cast<size_t>(x))];
            const float shows = (1 - static_cast<float>(over.a) / 255.0f) * under[3] / 255.0f;
            const float alpha = static_cast<float>(over.a) / 255.0f + shows;
            under[0] = byteOf((over.r + shows * under[0]) / alpha);
            under[1] = byteOf((over.g + shows * under[1]) / alpha);
            under[2] = byteOf((over.b + shows * under[2]) / alpha);
            under[3] = byteOf(alpha * 255);
        }
    }
}

}  // namespace terray
