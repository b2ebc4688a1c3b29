// SPDX-License-Identifier: Apache-2.0
// Legend, scale bar and north arrow, drawn over the finished picture.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/result.h"
#include "shade/shade.h"

namespace terray {

/// What annotations ask of the frame; borrowed while they are made.
struct AnnotationContext {
    const Shader* shader = nullptr;   ///< its ramp is the legend of tinted pictures
    const TerrainCut* cut = nullptr;  ///< traced for the distance that a scale bar holds at
};

/// Draws on bands of the 8-bit picture (4 bytes a pixel, straight alpha). const-shared.
class Annotations {
public:
    /// Null pointer if no annotation is asked for. What a picture cannot have (a legend of a photo,
    /// a scale bar where the centre shows no ground) is left out with a note. Error: Resource (no
    /// typeface).
    static Result<std::unique_ptr<Annotations>> make(const RenderOptions& options, Shading shading,
                                                     const TerrainInfo& info, const RayFrame& rays,
                                                     const AnnotationContext& context = {});
    virtual ~Annotations() = default;
    /// Rows [firstRow, firstRow + rows) of a picture of the camera's size.
    virtual void drawOn(int firstRow, int rows, std::span<uint8_t> rgba) const = 0;
};

}  // namespace terray
