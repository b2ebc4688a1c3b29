// SPDX-License-Identifier: Apache-2.0
// Samples of a source as posts, and whether it is still the same file.
#include "store/in_place.h"

#include <cpl_vsi.h>

#include <cmath>
#include <limits>
#include <memory>

#include "dataset/gdal_handle.h"
#include "dataset/remote.h"
#include "store/bytes.h"
#include "store/hashes.h"

namespace terray {
namespace {

constexpr size_t kHeaderBytes = 65536;
constexpr float kNoHeight = 1e30f;  ///< numbers beyond are fill values, as in the raster room

}  // namespace

Result<StoreSource> stateOf(const std::string& name) {
    ensureGdal();
    StoreSource state;
    state.name = shownName(name);
    const std::string path = gdalName(name);
    VSIStatBufL stat;
    if (VSIStatL(path.c_str(), &stat) != 0) return state;
    state.bytes = static_cast<uint64_t>(stat.st_size);
    state.modified = static_cast<int64_t>(stat.st_mtime);
    const std::unique_ptr<VSILFILE, int (*)(VSILFILE*)> file(VSIFOpenL(path.c_str(), "rb"),
                                                             VSIFCloseL);
    if (!file) return state;  // a folder
    Bytes header(kHeaderBytes);
    header.resize(VSIFReadL(header.data(), 1, header.size(), file.get()));
    state.headerHash = hashOf(header);
    return state;
}

std::string InPlaceSource::pathFrom(const std::string& folder) const {
    if (path.starts_with('/')) return path;
    return folder + (folder.ends_with('/') ? "" : "/") + path;
}

void InPlaceSource::toCodes(std::span<uint16_t> samples) const {
    constexpr int64_t kTop = kHolePost - 1;
    const bool isSigned = type == "Int16";
    for (uint16_t& word : samples) {
        const int64_t raw = isSigned ? static_cast<int16_t>(word) : int64_t{word};
        const int64_t code = (raw - base) * (int64_t{1} << shift);
        const bool isHole = nodata && static_cast<double>(raw) == *nodata;
        word = isHole || code < 0 || code > kTop ? kHolePost : static_cast<uint16_t>(code);
    }
}

void InPlaceSource::toPosts(std::span<float> samples) const {
    const double given = nodata.value_or(HUGE_VAL);
    const float mark =
        std::abs(given) < static_cast<double>(kNoHeight) ? static_cast<float>(given) : kNoHeight;
    for (float& value : samples) {
        const bool isHole = value == mark || !(std::abs(value) < kNoHeight);
        if (isHole) value = std::numeric_limits<float>::quiet_NaN();
    }
}

Result<void> checkInPlace(const InPlaceSource& source, const StoreSource& then,
                          const std::string& folder) {
    const std::string path = source.pathFrom(folder);
    auto now = stateOf(path);
    if (!now) return now.error();
    now->name = then.name;
    if (*now == then) return {};
    return makeError(ErrorCode::Input,
                     "'{}' uses '{}' in place, which {} since; bring that file back, or bake again",
                     folder, path, now->bytes == 0 ? "is not there any more" : "has changed");
}

}  // namespace terray
