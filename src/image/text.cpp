// SPDX-License-Identifier: Apache-2.0
// Lines of text over FreeType: UTF-8, kerned, anti-aliased, glyphs placed to 1/64 pixel.
#include "image/text.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>

namespace terray {
namespace {

constexpr const char* kDebianTypeface = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr uint32_t kReplacement = 0xFFFD;
constexpr int kMargin = 1;  // pixels around the line: glyphs overhang their advance

int continuationBytes(unsigned char lead) {
    if (lead < 0x80) return 0;
    if (lead >= 0xC2 && lead < 0xE0) return 1;
    if (lead >= 0xE0 && lead < 0xF0) return 2;
    if (lead >= 0xF0 && lead < 0xF5) return 3;
    return -1;
}

/// Code points of UTF-8 text; malformed bytes become the replacement character.
std::vector<uint32_t> codePoints(const std::string& utf8) {
    std::vector<uint32_t> points;
    for (size_t k = 0; k < utf8.size();) {
        const auto lead = static_cast<unsigned char>(utf8[k++]);
        const int more = continuationBytes(lead);
        uint32_t point = more <= 0 ? lead : lead & (0x3Fu >> more);
        bool good = more >= 0;
        for (int m = 0; good && m < more; ++m) {
            good = k < utf8.size() && (static_cast<unsigned char>(utf8[k]) & 0xC0) == 0x80;
            if (good) point = point << 6 | (static_cast<unsigned char>(utf8[k++]) & 0x3Fu);
        }
        points.push_back(good ? point : kReplacement);
    }
    return points;
}

int ceil64(FT_Pos value) { return static_cast<int>((value + 63) >> 6); }

}  // namespace

struct Typeface::State {
    FT_Library library = nullptr;
    FT_Face face = nullptr;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (face) FT_Done_Face(face);
        if (library) FT_Done_FreeType(library);
    }

    /// A glyph of the line: its index, and where its origin stands, 1/64 pixel.
    struct Placed {
        FT_UInt glyph = 0;
        FT_Pos x = 0;
    };

    /// Places the glyphs and returns the line's advance.
    FT_Pos place(const std::string& utf8, std::vector<Placed>& placed) const {
        FT_Pos pen = 0;
        FT_UInt previous = 0;
        for (const uint32_t point : codePoints(utf8)) {
            const FT_UInt glyph = FT_Get_Char_Index(face, point);
            FT_Vector kern{0, 0};
            if (previous != 0 && glyph != 0) {
                FT_Get_Kerning(face, previous, glyph, FT_KERNING_UNFITTED, &kern);
            }
            pen += kern.x;
            placed.push_back({glyph, pen});
            if (FT_Load_Glyph(face, glyph, kLoad) == 0) pen += face->glyph->linearHoriAdvance >> 10;
            previous = glyph;
        }
        return pen;
    }

    void draw(const Placed& placed, TextBitmap& bitmap) const {
        if (FT_Load_Glyph(face, placed.glyph, kLoad) != 0) return;
        FT_GlyphSlot slot = face->glyph;
        FT_Outline_Translate(&slot->outline, placed.x & 63, 0);
        if (FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL) != 0) return;
        const int left = kMargin + static_cast<int>(placed.x >> 6) + slot->bitmap_left;
        const int top = bitmap.baseline - slot->bitmap_top;
        for (int row = 0; row < static_cast<int>(slot->bitmap.rows); ++row) {
            const int y = top + row;
            if (y < 0 || y >= bitmap.height) continue;
            const uint8_t* source = slot->bitmap.buffer + row * slot->bitmap.pitch;
            for (int column = 0; column < static_cast<int>(slot->bitmap.width); ++column) {
                const int x = left + column;
                if (x < 0 || x >= bitmap.width) continue;
                float& cover = bitmap.coverage[static_cast<size_t>(y * bitmap.width + x)];
                cover = std::min(1.0f, cover + static_cast<float>(source[column]) / 255.0f);
            }
        }
    }

    static constexpr FT_Int32 kLoad = FT_LOAD_NO_BITMAP | FT_LOAD_TARGET_LIGHT;
};

Typeface::Typeface(std::unique_ptr<State> state) : state_(std::move(state)) {}
Typeface::Typeface(Typeface&&) noexcept = default;
Typeface::~Typeface() = default;

Result<Typeface> Typeface::open() {
    const char* chosen = std::getenv("TERRAY_FONT");
    const std::string path = chosen && *chosen ? chosen : kDebianTypeface;
    auto state = std::make_unique<State>();
    if (FT_Init_FreeType(&state->library) != 0) {
        return makeError(ErrorCode::Resource, "FreeType does not start; check its installation");
    }
    if (FT_New_Face(state->library, path.c_str(), 0, &state->face) != 0 ||
        !FT_IS_SCALABLE(state->face)) {
        return makeError(
            ErrorCode::Resource,
            "'{}' is no typeface that can be used; install fonts-dejavu-core, or name a "
            "TrueType file by the environment variable TERRAY_FONT",
            path);
    }
    return Typeface(std::move(state));
}

TextBitmap Typeface::render(const std::string& utf8, double pixelHeight) const {
    const auto size =
        static_cast<FT_F26Dot6>(std::lround(std::clamp(pixelHeight, 4.0, 2000.0) * 64));
    FT_Set_Char_Size(state_->face, 0, size, 72, 72);
    std::vector<State::Placed> placed;
    const FT_Pos advance = state_->place(utf8, placed);
    const FT_Size_Metrics& metrics = state_->face->size->metrics;
    TextBitmap bitmap;
    bitmap.width = ceil64(advance) + 2 * kMargin;
    bitmap.baseline = ceil64(metrics.ascender) + kMargin;
    bitmap.height = bitmap.baseline + ceil64(-metrics.descender) + kMargin;
    bitmap.coverage.assign(static_cast<size_t>(bitmap.width) * static_cast<size_t>(bitmap.height),
                           0.0f);
    for (const State::Placed& glyph : placed) state_->draw(glyph, bitmap);
    return bitmap;
}

}  // namespace terray
