// SPDX-License-Identifier: Apache-2.0
// Facts about a source as aligned text and as JSON; advice on exaggeration.
#pragma once

#include <optional>
#include <string>

#include "terray/terrain.h"

namespace terray::cli {

std::string infoText(const SourceInfo& info);
std::string infoJson(const SourceInfo& info);

/// Says on stderr what was assumed: notes, and a warning where the CRS is missing.
void sayAssumptions(const SourceInfo& info);

/// A handy factor (2, 3, 5, 10, ...) where the relief is below 2 % of the terrain's width.
std::optional<double> suggestedExaggeration(const SourceInfo& info);
/// Height range over width, percent.
double reliefPercent(const SourceInfo& info);

/// "1.5 GiB".
std::string bytesText(uint64_t bytes);

}  // namespace terray::cli
