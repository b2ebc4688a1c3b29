// SPDX-License-Identifier: Apache-2.0
// Process-wide switches, and the version.
#include "terray/process.h"

#include "base/interrupt.h"
#include "base/log.h"
#include "base/progress.h"
#include "terray/version.h"

namespace terray {

const char* version() { return TERRAY_VERSION; }

void setQuiet(bool quiet) {
    log::setVerbosity(quiet ? log::Verbosity::Quiet : log::Verbosity::Normal);
    Progress::setEnabled(!quiet);
}

void writeNote(const std::string& text) { log::writeNote(text); }
void writeWarning(const std::string& text) { log::writeWarning(text); }

void handleInterrupts() { installInterruptHandler(); }

}  // namespace terray
