// SPDX-License-Identifier: Apache-2.0
// A picture and the blocks of its photo: asked for by a small picture before, completed where
// shading finds one missing.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "engine/terrain_state.h"
#include "terray/options.h"

namespace terray {

struct PhotoFigures {
    uint64_t wanted = 0, loaded = 0, evicted = 0;
    uint64_t absent = 0;       ///< wanted, but never there
    uint64_t lateSamples = 0;  ///< hits that show a coarser block in place of an absent one
    uint64_t bytesRead = 0;
};

/// Lives as long as its picture; `tiles` of the state is held. note() is synchronised, the rest
/// confined.
class FramePhoto {
public:
    FramePhoto(const Terrain::State& state, const RenderOptions& options);

    /// Asks for what the picture of these rays wants, and, without waitForTiles, for what that of
    /// `soon` will.
    void scout(const Shader& shader, const RayFrame& rays, const std::optional<Camera>& soon);

    /// What shading an image tile has used.
    void note(const ImageTile& tile, const PhotoUse& use);
    /// Brings what is missing and lets the tiles be made again, a few at a time. Without
    /// waitForTiles, or where there is no room, coarser blocks stay. Error Failed if a block cannot
    /// be read and none may be missing; Interrupted.
    Result<void> finishBand(const std::function<void(std::span<const ImageTile>)>& make);

    /// Of the finished picture; leaves what it wanted to the next one.
    PhotoFigures figures() const;

private:
    struct Unfinished {
        ImageTile tile;
        std::vector<uint32_t> blocks;
    };
    std::vector<uint32_t> blocksIn(const Shader& shader, const RayFrame& rays) const;
    Result<void> bring(std::vector<uint32_t>& blocks) const;

    ResidentPhoto& photo_;
    const Terrain::State& state_;
    bool waits_, allowMissing_;
    StreamFigures before_;
    std::mutex mutex_;
    bool isFinishing_ = false;
    mutable bool hasWarned_ = false;
    std::vector<Unfinished> unfinished_;
    std::vector<uint32_t> wanted_;
    uint64_t lateSamples_ = 0;
};

}  // namespace terray
