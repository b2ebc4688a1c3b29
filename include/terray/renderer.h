// SPDX-License-Identifier: Apache-2.0
// Making pictures: into memory or into files of any size.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "terray/export.h"
#include "terray/options.h"
#include "terray/result.h"
#include "terray/stats.h"
#include "terray/terrain.h"
#include "terray/view.h"

namespace terray {

/// Renders into memory: 8-bit sRGB with straight alpha, row by row from the top.
/// rgba.size() == width * height * 4.
TERRAY_API Result<RenderStats> render(const Terrain& terrain, const View& view,
                                      const RenderOptions& options, std::span<uint8_t> rgba);

/// Renders into files, in bands: memory does not grow with the picture. Files appear complete or
/// not at all. Notes what was assumed on stderr.
TERRAY_API Result<RenderStats> renderToFiles(const Terrain& terrain, const View& view,
                                             const RenderOptions& options,
                                             const OutputOptions& outputs);

/// Finds out early, before a terrain is opened, what renderToFiles() would refuse: option values
/// out of range, unknown names, formats that cannot hold the picture, places that cannot be
/// written.
TERRAY_API Result<void> checkRender(const View& view, const RenderOptions& options,
                                    const OutputOptions& outputs);

/// Names with one line each: `terray techniques`, `terray shadings`, built-in ramps, `terray
/// devices` (for RenderOptions::device).
struct NamedLine {
    std::string name, line;
};
TERRAY_API std::vector<NamedLine> techniques();
TERRAY_API std::vector<NamedLine> shadings();
TERRAY_API std::vector<NamedLine> ramps();
TERRAY_API std::vector<NamedLine> devices();

}  // namespace terray
