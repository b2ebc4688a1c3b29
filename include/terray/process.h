// SPDX-License-Identifier: Apache-2.0
// What a program decides once for the whole process: words on stderr, and Ctrl-C.
#pragma once

#include <string>

#include "terray/export.h"

namespace terray {

/// Quiet: no notes and no progress bars on stderr, only warnings. Default: notes and, on a
/// terminal, progress bars.
TERRAY_API void setQuiet(bool quiet);

/// Writes "note: ..." or "warning: ..." on stderr, as Terray itself does; quiet hides notes.
TERRAY_API void writeNote(const std::string& text);
TERRAY_API void writeWarning(const std::string& text);

/// Makes SIGINT and SIGTERM end long work with ErrorCode::Interrupted, leaving no files behind; a
/// second one ends the process at once with exit code 130.
TERRAY_API void handleInterrupts();

}  // namespace terray
