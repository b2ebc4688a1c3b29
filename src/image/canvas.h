// SPDX-License-Identifier: Apache-2.0
// A small drawing laid over pictures: lines, shapes and words in ink, with a halo that keeps them
// legible on any ground.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "image/text.h"
#include "math/types.h"

namespace terray {

/// 8-bit sRGB.
using Ink = std::array<uint8_t, 3>;

/// Where text stands relative to its place.
enum class TextAlign { Left, Centre, Right };

/// A transparent sheet to draw on; pixel (0, 0) is the upper left one. confined while drawing,
/// const-shared afterwards.
class Canvas {
public:
    Canvas(int width, int height);

    int width() const { return width_; }
    int height() const { return height_; }

    /// Fills [x0, x1) x [y0, y1), pixels; parts outside are left out.
    void fillRectangle(int x0, int y0, int x1, int y1, Ink ink);
    /// Fills a polygon (even-odd), anti-aliased; pixel centres are at half-integers.
    void fillPolygon(std::span<const Vec2> corners, Ink ink);
    /// Text with its baseline at row y, aligned at column x.
    void drawText(const TextBitmap& text, int x, int y, TextAlign align, Ink ink);
    /// Surrounds all that is drawn by a soft halo about `radius` pixels wide. Call it last.
    void addHalo(double radius, Ink ink, float strength);

    /// Composes the sheet, its corner at (left, top) of the picture, on rows of the picture: 4
    /// bytes a pixel, straight alpha.
    void composeOn(int left, int top, int pictureWidth, int firstRow, int rows,
                   std::span<uint8_t> rgba) const;

private:
    struct Pixel {
        uint8_t r = 0, g = 0, b = 0, a = 0;  // premultiplied
    };
    Pixel& at(int x, int y) { return pixels_[index(x, y)]; }
    size_t index(int x, int y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
    }
    void blend(int x, int y, Ink ink, float cover);

    int width_ = 0, height_ = 0;
    std::vector<Pixel> pixels_;
};

}  // namespace terray
