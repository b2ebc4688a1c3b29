// SPDX-License-Identifier: Apache-2.0
// How the camera moves from picture to picture, and where it will be.
#pragma once

#include <chrono>
#include <optional>

#include "view/camera.h"

namespace terray {

/// confined.
class Motion {
public:
    using Time = std::chrono::steady_clock::time_point;
    void see(const Camera& camera, Time now);
    /// The last camera, moved and turned on for so long as it did before it; nullopt if it stood
    /// still, jumped, or was seen too long ago to tell.
    std::optional<Camera> after(double seconds) const;

private:
    std::optional<Camera> last_, before_;
    Time lastAt_, beforeAt_;
};

}  // namespace terray
