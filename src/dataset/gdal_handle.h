// SPDX-License-Identifier: Apache-2.0
// Owning handle of a GDAL dataset, and GDAL's last words for our own error sentences.
#pragma once

#include <gdal_priv.h>

#include <memory>
#include <string>

#include "dataset/gdal_setup.h"

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

}  // namespace terray
