// SPDX-License-Identifier: Apache-2.0
// Lays out legend (lower left), scale bar and north arrow (lower right), sized by the picture.
#include "shade/annotate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/log.h"
#include "image/canvas.h"
#include "shade/legend_scale.h"

namespace terray {
namespace {

constexpr Ink kInk{28, 30, 34};
constexpr Ink kPaper{255, 255, 255};
constexpr float kHaloStrength = 0.85f;

/// A drawing and its place in the picture.
struct Sticker {
    Canvas canvas;
    int left = 0, top = 0;
};

int rounded(double value) { return static_cast<int>(std::lround(value)); }

/// Height of text in pixels; everything else is measured in it.
double emOf(const Camera& camera) {
    return std::clamp(std::min(0.021 * camera.height, 0.030 * camera.width), 10.0, 200.0);
}

Canvas drawLegend(const LegendScale& scale, const Typeface& face, double em) {
    const int margin = rounded(0.8 * em), barWidth = rounded(em), barHeight = rounded(11 * em);
    const int line = std::max(1, rounded(0.07 * em)), gap = rounded(0.4 * em);
    const TextBitmap title = face.render(scale.title, em);
    std::vector<TextBitmap> labels;
    int labelWidth = title.width - barWidth - gap;
    for (const LegendTick& tick : scale.ticks) {
        labels.push_back(face.render(tick.label, em));
        labelWidth = std::max(labelWidth, labels.back().width);
    }
    const int top = margin + rounded(2.0 * em), left = margin;
    Canvas canvas(left + barWidth + gap + labelWidth + margin, top + barHeight + margin);
    canvas.drawText(title, left, margin + rounded(0.9 * em), TextAlign::Left, kInk);
    canvas.fillRectangle(left - line, top - line, left + barWidth + line, top + barHeight + line,
                         kInk);
    for (int row = 0; row < barHeight; ++row) {
        const double position = (barHeight - row - 0.5) / barHeight;
        canvas.fillRectangle(left, top + row, left + barWidth, top + row + 1,
                             scale.colour(position));
    }
    for (size_t k = 0; k < labels.size(); ++k) {
        const int y = top + rounded((1 - scale.ticks[k].position) * barHeight);
        const int x = left + barWidth + line;
        canvas.fillRectangle(x, y - (line + 1) / 2, x + gap / 2, y - (line + 1) / 2 + line, kInk);
        canvas.drawText(labels[k], left + barWidth + gap, y + rounded(0.36 * em), TextAlign::Left,
                        kInk);
    }
    canvas.addHalo(0.4 * em, kPaper, kHaloStrength);
    return canvas;
}

/// How many metres a pixel shows across the picture, and where that holds.
struct GroundScale {
    double metresPerPixel = 0;
    bool everywhere = true;
};

std::optional<GroundScale> groundScale(const RayFrame& rays, const TerrainCut* cut) {
    const Camera& camera = rays.camera();
    if (camera.projection == Projection::Ortho) return GroundScale{camera.metresPerPixel(), true};
    if (!cut) return std::nullopt;
    const WorldRay centre = camera.rayThrough(0.5 * camera.width, 0.5 * camera.height);
    const Ray ray = rays.latticeRay(centre);
    Hit hit{};
    TraceCounters counters;
    firstHits(*cut, {&ray, 1}, {&hit, 1}, counters);
    if (!isHit(hit)) return std::nullopt;
    const double across = camera.projection == Projection::Panorama
                              ? std::hypot(centre.direction.x, centre.direction.y)
                              : 1.0;
    return GroundScale{static_cast<double>(hit.t) * across / camera.focalPixels(), false};
}

std::string lengthLabel(double metres, bool everywhere) {
    const std::string length = metres >= 1000   ? fmt::format("{:.6g} km", metres / 1000)
                               : metres >= 1    ? fmt::format("{:.6g} m", metres)
                               : metres >= 0.01 ? fmt::format("{:.6g} cm", metres * 100)
                                                : fmt::format("{:.6g} mm", metres * 1000);
    return everywhere ? length : length + " at centre";
}

Canvas drawScaleBar(const GroundScale& scale, const Typeface& face, double em, int pictureWidth) {
    const double longest = std::min(0.22 * pictureWidth, 14 * em);
    const double metres = roundDown125(longest * scale.metresPerPixel);
    const double pixels = metres / scale.metresPerPixel;
    const TextBitmap label = face.render(lengthLabel(metres, scale.everywhere), em);
    const int margin = rounded(0.8 * em), barHeight = std::max(3, rounded(0.38 * em));
    const int width = std::max(label.width, static_cast<int>(std::ceil(pixels)));
    Canvas canvas(width + 2 * margin, rounded(1.4 * em) + barHeight + 2 * margin);
    const double right = margin + width;
    const double top = margin + rounded(1.4 * em), bottom = top + barHeight;
    const double line = std::max(1, rounded(0.07 * em));
    const auto box = [&](double x0, double x1, double inset, Ink ink) {
        const std::array<Vec2, 4> corners{Vec2{x0, top + inset}, Vec2{x1, top + inset},
                                          Vec2{x1, bottom - inset}, Vec2{x0, bottom - inset}};
        canvas.fillPolygon(corners, ink);
    };
    box(right - pixels, right, 0, kInk);
    box(right - 0.5 * pixels, right - line, line, kPaper);
    canvas.drawText(label, margin + width, margin + rounded(0.9 * em), TextAlign::Right, kInk);
    canvas.addHalo(0.4 * em, kPaper, kHaloStrength);
    return canvas;
}

/// Where east and north on the ground point in the picture (x right, y up) at its centre. Looking
/// flatter than `kFlattest`, the arrow stays tilted by that, so that it can be read.
struct GroundAxes {
    Vec2 east, north;
};

GroundAxes groundAxes(const Camera& camera) {
    constexpr double kFlattestDeg = 30;
    const Vec3 level{std::cos(camera.heading), -std::sin(camera.heading), 0};
    const Vec3 ahead{std::sin(camera.heading), std::cos(camera.heading), 0};
    Vec3 right = camera.right, up = camera.up;
    if (std::abs(camera.forward.z) < std::sin(radFromDeg(kFlattestDeg))) {
        const Vec3 upright = glm::cross(level, camera.forward);
        const double cosRoll = glm::dot(camera.right, level);
        const double sinRoll = -glm::dot(camera.right, upright);
        const Vec3 tilted = ahead * std::sin(radFromDeg(kFlattestDeg)) +
                            Vec3{0, 0, std::cos(radFromDeg(kFlattestDeg))};
        right = cosRoll * level - sinRoll * tilted;
        up = cosRoll * tilted + sinRoll * level;
    }
    return {{right.x, up.x}, {right.y, up.y}};
}

Canvas drawNorthArrow(const Camera& camera, const Typeface& face, double em) {
    const GroundAxes axes = groundAxes(camera);
    const double reach = 1.9 * em;
    const int size = rounded(2 * (reach + 1.9 * em));
    Canvas canvas(size, size);
    const Vec2 centre{0.5 * size, 0.5 * size};
    const auto place = [&](double east, double north) {
        const Vec2 p = reach * (east * axes.east + north * axes.north);
        return Vec2{centre.x + p.x, centre.y - p.y};
    };
    const auto outline = [&](double grow) {
        return std::array<Vec2, 4>{place(0, 1 + 2 * grow), place(-0.55 - grow, -0.9 - grow),
                                   place(0, -0.5 - 0.3 * grow), place(0.55 + grow, -0.9 - grow)};
    };
    canvas.fillPolygon(outline(0.09), kInk);
    const std::array<Vec2, 4> whole = outline(0);
    canvas.fillPolygon(std::array<Vec2, 3>{whole[0], whole[1], whole[2]}, kPaper);
    const TextBitmap letter = face.render("N", 1.1 * em);
    const Vec2 direction = glm::normalize(Vec2{axes.north.x, -axes.north.y});
    const Vec2 at = place(0, 1.2) + 0.85 * em * direction;
    canvas.drawText(letter, rounded(at.x), rounded(at.y + 0.40 * em), TextAlign::Centre, kInk);
    canvas.addHalo(0.4 * em, kPaper, kHaloStrength);
    return canvas;
}

class Stickers final : public Annotations {
public:
    explicit Stickers(const Camera& camera) : camera_(camera), em_(emOf(camera)) {}

    double em() const { return em_; }

    void addLowerLeft(Canvas canvas) {
        const int top = camera_.height - canvas.height() - rounded(0.5 * em_);
        stickers_.push_back({std::move(canvas), rounded(0.5 * em_), top});
    }
    /// Stacked upwards, flush right.
    void addLowerRight(Canvas canvas) {
        const int left = camera_.width - canvas.width() - rounded(0.5 * em_);
        const int top = camera_.height - canvas.height() - rounded(0.5 * em_) - stacked_;
        stacked_ += canvas.height();
        stickers_.push_back({std::move(canvas), left, top});
    }

    void drawOn(int firstRow, int rows, std::span<uint8_t> rgba) const override {
        for (const Sticker& s : stickers_) {
            s.canvas.composeOn(s.left, s.top, camera_.width, firstRow, rows, rgba);
        }
    }

private:
    Camera camera_;
    double em_ = 0;
    int stacked_ = 0;
    std::vector<Sticker> stickers_;
};

}  // namespace

Result<std::unique_ptr<Annotations>> Annotations::make(const RenderOptions& options,
                                                       Shading shading, const TerrainInfo& info,
                                                       const RayFrame& rays,
                                                       const AnnotationContext& context) {
    if (!options.legend && !options.scaleBar && !options.northArrow) {
        return std::unique_ptr<Annotations>();
    }
    Result<Typeface> face = Typeface::open();
    if (!face) return face.error();
    const Camera& camera = rays.camera();
    auto stickers = std::make_unique<Stickers>(camera);
    if (options.legend) {
        const HeightRamp* ramp = context.shader ? context.shader->ramp() : nullptr;
        const std::optional<LegendScale> scale = legendScale(shading, info, rays, ramp);
        if (scale) {
            stickers->addLowerLeft(drawLegend(*scale, *face, stickers->em()));
        } else {
            log::note("--legend: the colours of this shading stand for no number; none is drawn");
        }
    }
    if (options.scaleBar) {
        const std::optional<GroundScale> scale = groundScale(rays, context.cut);
        if (scale) {
            stickers->addLowerRight(drawScaleBar(*scale, *face, stickers->em(), camera.width));
        } else {
            log::note("--scale-bar: the picture's centre shows no ground; none is drawn");
        }
    }
    if (options.northArrow) {
        stickers->addLowerRight(drawNorthArrow(camera, *face, stickers->em()));
    }
    return std::unique_ptr<Annotations>(std::move(stickers));
}

}  // namespace terray
