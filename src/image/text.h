// SPDX-License-Identifier: Apache-2.0
// Words in pictures: one clean typeface (DejaVu Sans, found on the system), anti-aliased, with a
// halo.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"

namespace terray {

/// Coverage of a rendered line of text, 0..1, row-major.
struct TextBitmap {
    int width = 0, height = 0;
    int baseline = 0;  ///< rows from the top to the baseline
    std::vector<float> coverage;
};

/// confined.
class Typeface {
public:
    /// Error (Resource) if no typeface is installed; names the package.
    static Result<Typeface> open();
    Typeface(Typeface&&) noexcept;
    ~Typeface();
    TextBitmap render(const std::string& utf8, double pixelHeight) const;

private:
    struct State;
    explicit Typeface(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace terray
