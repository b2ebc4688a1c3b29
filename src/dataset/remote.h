// SPDX-License-Identifier: Apache-2.0
// Names of data on the network: what users write, what GDAL opens, what may be shown.
#pragma once

#include <string>

namespace terray {

/// What GDAL opens for a name: URLs (http, https, s3, gs) become its names for them (/vsicurl/,
/// /vsis3/, /vsigs/); all others are left as they are.
std::string gdalName(const std::string& source);

/// The URL of what is read over HTTP, given as one or as /vsicurl/URL; empty for all others.
std::string httpUrl(const std::string& source);

/// True if reading waits for a network.
bool isRemote(const std::string& source);

/// A file of a folder; what follows '?' in a URL (keys of a cloud) stays at the end.
std::string fileIn(const std::string& folder, const std::string& name);

/// The name without passwords: URLs lose user and query. For messages, figures, and files.
std::string shownName(const std::string& source);

}  // namespace terray
