// SPDX-License-Identifier: Apache-2.0
// Owning handle of a GDAL dataset, and GDAL's last words for our own error sentences.
#pragma once

#include <gdal_priv.h>

#include <memory>
#include <string>

namespace terray {

struct DatasetCloser {
    void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using DatasetHandle = std::unique_ptr<GDALDataset, DatasetCloser>;

/// Registers drivers and catches errors with the default cache unless initialiseGdal() was called.
void ensureGdal();

/// Forgets what GDAL said so far; call before the GDAL call whose failure is to be reported.
void clearGdalMessage();
/// GDAL's last error or warning since then, as one line; empty if it said nothing.
std::string gdalMessage();

/// Memory that one terrain may take: --memory, or the smaller of 2 GiB and half of the RAM.
uint64_t memoryBudget(uint64_t memoryBytes);

}  // namespace terray
