// SPDX-License-Identifier: Apache-2.0
// Values of options checked before any work: one sentence naming the option.
#pragma once

#include "base/result.h"
#include "terray/options.h"
#include "terray/view.h"

namespace terray {

Result<void> checkView(const View& view);
Result<void> checkOptions(const View& view, const RenderOptions& options);
/// Formats, duplicate paths, and what a format cannot hold; nothing is written.
Result<void> checkOutputNames(const RenderOptions& options, const OutputOptions& outputs);

}  // namespace terray
