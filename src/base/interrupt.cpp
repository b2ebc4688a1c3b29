// SPDX-License-Identifier: Apache-2.0
// Signal handling behind isInterrupted().
#include "base/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace terray {
namespace {

std::atomic<bool> gInterrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the handler needs a lock-free flag");

void onSignal(int) {
    if (gInterrupted.exchange(true)) _exit(130);
}

}  // namespace

void installInterruptHandler() {
    struct sigaction action {};
    action.sa_handler = onSignal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

bool isInterrupted() { return gInterrupted.load(std::memory_order_relaxed); }
void setInterrupted(bool value) { gInterrupted.store(value); }

}  // namespace terray
