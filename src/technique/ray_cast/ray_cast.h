// SPDX-License-Identifier: Apache-2.0
// ray_cast: every pixel's ray straight through the cut by the packet tracer. The default technique.
#pragma once

#include <memory>

#include "technique/technique.h"

namespace terray {

std::unique_ptr<Technique> makeRayCast();

}  // namespace terray
