// SPDX-License-Identifier: Apache-2.0
// What a store's manifest says, in the words of `terray info`.
#include "engine/open_store.h"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "store/format.h"

namespace terray {
namespace {

/// The first option that a store has already an answer to; null if there is none.
const char* optionOfDems(const OpenOptions& options) {
    if (!options.assignCrs.empty()) return "--assign-crs";
    if (!options.workingCrs.empty()) return "--crs";
    if (options.heightUnit) return "--height-unit";
    if (options.nodata) return "--nodata";
    if (options.band != 1) return "--band";
    if (options.encoding != HeightEncoding::None) return "--encoding";
    return nullptr;
}

}  // namespace

Result<std::unique_ptr<Store>> openStore(const std::string& source, const OpenOptions& options) {
    if (const char* option = optionOfDems(options)) {
        return makeError(ErrorCode::Usage,
                         "{}: '{}' is a store, which knows that already; give it to `terray bake`",
                         option, source);
    }
    const uint64_t budget = options.memoryBytes != 0
                                ? options.memoryBytes
                                : std::min<uint64_t>(uint64_t{2} << 30, physicalMemoryBytes() / 2);
    return Store::open(source, budget);
}

SourceInfo describeStore(const Store& store) {
    const StoreManifest& manifest = store.manifest();
    const TerrainInfo& info = manifest.info;
    SourceInfo facts;
    facts.source = store.path();
    facts.driver = "Terray store";
    facts.columns = info.scheme.columns;
    facts.rows = info.scheme.rows;
    facts.bands = 1;
    const bool codes = info.format == PostFormat::Int16;
    facts.sampleType = codes ? "UInt16" : "Float32";
    facts.crsName = manifest.crsName;
    facts.crsWkt = info.crsWkt;
    const GeoTransform transform = geoTransformOf(info, 0, 0, 0);
    facts.geoTransform.assign(transform.values, transform.values + 6);
    facts.pixelWidth = info.worldFromLattice.columnLength() / info.metresPerCrsUnit;
    facts.pixelHeight = info.worldFromLattice.rowLength() / info.metresPerCrsUnit;
    facts.horizontalUnit = "metre";
    if (info.metresPerCrsUnit != 1) {
        facts.horizontalUnit = fmt::format("{:g} m", info.metresPerCrsUnit);
    }
    facts.nodataRule = "NaN";
    if (codes) facts.nodataRule = fmt::format("value {}", kHolePost);
    facts.heightUnit = std::string(1, 'm');
    facts.hasRange = true;
    facts.holes = static_cast<int64_t>(manifest.holes);
    const bool isEmpty = manifest.holes >= static_cast<uint64_t>(facts.columns * facts.rows);
    facts.minHeight = isEmpty ? HUGE_VAL : static_cast<double>(info.minZ);
    facts.maxHeight = isEmpty ? -HUGE_VAL : static_cast<double>(info.maxZ);
    facts.workingCrsName = manifest.crsName;
    if (manifest.photo) facts.photo = manifest.photo->description;
    for (const std::string& note : manifest.notes) facts.assumptions.push_back({note});
    if (manifest.maxError > 0) {
        facts.assumptions.push_back({fmt::format(
            "heights are stored to within {:g} m of the sources'", manifest.maxError)});
    }
    return facts;
}

}  // namespace terray
