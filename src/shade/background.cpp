// SPDX-License-Identifier: Apache-2.0
// Reads --background.
#include "shade/background.h"

#include <charconv>

namespace terray {

Result<Background> parseBackground(const std::string& text) {
    if (text == "sky" || text.empty()) return Background{};
    if (text == "transparent") return Background{Background::Kind::Transparent, {}};
    unsigned code = 0;
    const char* const end = text.data() + text.size();
    if (text.size() == 7 && text[0] == '#') {
        const auto parsed = std::from_chars(text.data() + 1, end, code, 16);
        if (parsed.ec == std::errc() && parsed.ptr == end) {
            const auto channel = [&](int shift) {
                return static_cast<float>((code >> shift) & 0xFFu);
            };
            return Background{Background::Kind::Colour,
                              rules::sceneFromCodes(channel(16), channel(8), channel(0))};
        }
    }
    return makeError(
        ErrorCode::Usage,
        "--background '{}' is not known; use sky, transparent or a colour like #f4f1ea", text);
}

}  // namespace terray
