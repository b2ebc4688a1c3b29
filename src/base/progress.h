// SPDX-License-Identifier: Apache-2.0
// A progress bar with ETA on stderr: shown only on a terminal, and only for work above one second.
#pragma once

#include <atomic>
#include <chrono>
#include <string>

namespace terray {

/// Counts steps of one piece of work. Synchronised: advance() may be called from any thread. Work
/// inside other work (a frame of a film) draws nothing of its own.
class Progress {
public:
    Progress(std::string title, double total);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void advance(double steps = 1.0);
    /// Off for --quiet. Default: on.
    static void setEnabled(bool enabled);

private:
    void draw(double done, double elapsedSeconds);

    std::string title_;
    double total_;
    bool inner_;  ///< another one is at work
    std::atomic<double> done_{0.0};
    std::chrono::steady_clock::time_point start_;
    std::atomic<long long> lastDrawMs_{1000};  // first drawn after one second
    std::atomic<bool> drawn_{false};
};

}  // namespace terray
