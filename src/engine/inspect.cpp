// SPDX-License-Identifier: Apache-2.0
// `terray info`: what a source says, and what Terray makes of it.
#include "base/stopwatch.h"
#include "engine/describe.h"
#include "engine/memory_rule.h"
#include "engine/open_store.h"
#include "raster/dem.h"
#include "stream/resident.h"
#include "terray/terrain.h"

namespace terray {

void describeLattice(const TerrainInfo& info, SourceInfo& facts) {
    facts.workingColumns = info.scheme.columns;
    facts.workingRows = info.scheme.rows;
    facts.workingCellX = info.worldFromLattice.columnLength();
    facts.workingCellY = info.worldFromLattice.rowLength();
    facts.mips = info.scheme.mipCount();
    facts.postFormat = info.format == PostFormat::Int16 ? "16 bit" : "float";
    facts.residentBytes = ResidentTerrain::requiredBytes(info);
}

Result<SourceInfo> inspect(const std::string& source, const OpenOptions& options, bool scan) {
    initialiseGdal(gdalCacheBytes(options.memoryBytes, physicalMemoryBytes()));
    if (isStore(source)) {
        const auto store = openStore(source, options);
        if (!store) return store.error();
        SourceInfo facts = describeStore(**store);
        describeLattice((*store)->info(), facts);
        return facts;
    }
    auto dem = openDem(source, options);
    if (!dem) return dem.error();
    SourceInfo facts = std::move(dem->facts);
    describeLattice(dem->source->info(), facts);
    if (scan) TERRAY_TRY(scanDem(source, options, facts));
    return facts;
}

}  // namespace terray
