// SPDX-License-Identifier: Apache-2.0
// Sun sweeps kept from tile to tile and from frame to frame, made when first asked for.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "kernel/sweep/sun.h"

namespace terray {

/// Keeps the sweeps that were asked for last, as many as fit, but always one. synchronised.
class SunSweepCache {
public:
    explicit SunSweepCache(uint64_t mostBytes) : mostBytes_(mostBytes) {}

    /// The sweep of a cut for a sun; null where SunSweep::make gives none. Made once, by all
    /// threads that wait for it together.
    std::shared_ptr<const SunSweep> get(const TerrainCut& cut, const SunDirection& sun);

private:
    struct Entry;
    std::shared_ptr<Entry> entryFor(const TerrainCut& cut, const SunDirection& sun);

    uint64_t mostBytes_;
    std::mutex mutex_;
    std::list<std::shared_ptr<Entry>> entries_;  ///< the last used first
};

}  // namespace terray
