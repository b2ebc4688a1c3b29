// SPDX-License-Identifier: Apache-2.0
// Ctrl-C as a flag that long work polls, so that temporary files are removed on the way out.
#pragma once

namespace terray {

/// Makes SIGINT and SIGTERM set the flag; a second one ends the process at once with 130.
void installInterruptHandler();
bool isInterrupted();
/// For tests and embedders: sets or clears the flag.
void setInterrupted(bool value);

}  // namespace terray
