// SPDX-License-Identifier: Apache-2.0
// Groups of options that commands share. Each adds its flags to a command and holds what they gave.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "terray/options.h"
#include "terray/terrain.h"
#include "terray/view.h"

namespace terray::cli {

/// Adds an option whose text goes to `take`; `value` is its value's name in the help. Given twice,
/// the last one counts.
CLI::Option* addText(CLI::App& command, const std::string& group, const std::string& name,
                     const std::string& value, const std::string& help,
                     std::function<void(const std::string&)> take);
CLI::Option* addSwitch(CLI::App& command, const std::string& group, const std::string& name,
                       const std::string& help, bool& target);

/// SOURCE, what the data do not say, and the machine's share: --quiet, --threads, --memory.
struct SourceOptions {
    std::string source;
    OpenOptions open;
    bool quiet = false;

    void addTo(CLI::App& command);
    void addPhotoTo(CLI::App& command);
    /// All but SOURCE itself. `memory` says the default budget.
    void addReadingTo(CLI::App& command, const std::string& memory);
};

/// Camera flags over a camera file.
struct ViewOptions {
    std::string file;
    std::optional<std::pair<int, int>> size;
    std::optional<Projection> projection;
    std::optional<Place> eye, lookAt;
    std::optional<double> headingDeg, pitchDeg, rollDeg, fovDeg;
    std::optional<Extent> extent;
    bool lonLat = false;

    void addTo(CLI::App& command);
    /// Reads the camera file, lays the flags over it and refuses flags that contradict each other.
    View resolve() const;
};

/// Look, surface, technique.
struct LookOptions {
    RenderOptions render;
    std::string needsPhoto;  ///< the option given that is worth nothing without a photo

    void addTo(CLI::App& command);
    /// Fails if an option needs a photo and the opened terrain has none.
    void checkPhoto(const SourceInfo& info) const;
};

/// What is written, and where.
struct OutputFlags {
    OutputOptions outputs;
    bool pathGiven = false;
    std::string statsPath;  ///< empty: none

    void addTo(CLI::App& command);
};

}  // namespace terray::cli
