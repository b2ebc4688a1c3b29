// SPDX-License-Identifier: Apache-2.0
// Draws the progress line; whoever advances past the next redraw time draws it.
#include "base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace terray {
namespace {

std::atomic<bool> gEnabled{true};
std::atomic<int> gAlive{0};
constexpr long long kRedrawMs = 100;

bool isTerminal() {
    static const bool terminal = isatty(STDERR_FILENO) == 1;
    return terminal;
}

}  // namespace

Progress::Progress(std::string title, double total)
    : title_(std::move(title)),
      total_(std::max(total, 1.0)),
      inner_(gAlive.fetch_add(1) > 0),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
    gAlive.fetch_sub(1);
    if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::setEnabled(bool enabled) { gEnabled = enabled; }

void Progress::advance(double steps) {
    const double done = done_.fetch_add(steps) + steps;
    if (inner_ || !gEnabled || !isTerminal()) return;
    const auto elapsed = std::chrono::steady_clock::now() - start_;
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(elapsed).count();
    long long last = lastDrawMs_.load();
    if (ms < last || !lastDrawMs_.compare_exchange_strong(last, ms + kRedrawMs)) return;
    draw(done, static_cast<double>(ms) * 1e-3);
}

void Progress::draw(double done, double elapsedSeconds) {
    const double share = std::clamp(done / total_, 0.0, 1.0);
    const double eta = share > 0.0 ? elapsedSeconds * (1.0 - share) / share : 0.0;
    constexpr int kWidth = 30;
    const int full = static_cast<int>(share * kWidth);
    const std::string bar(static_cast<size_t>(full), '#');
    const std::string line = fmt::format("\r\033[K{} [{:<{}}] {:3.0f} %  {:.0f} s left", title_,
                                         bar, kWidth, share * 100.0, eta);
    std::fputs(line.c_str(), stderr);
    std::fflush(stderr);
    drawn_ = true;
}

}  // namespace terray
