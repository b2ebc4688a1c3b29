// SPDX-License-Identifier: Apache-2.0
// The plan as text, and the state of source files.
#include "bake/plan.h"

#include <cpl_vsi.h>
#include <gdal.h>

#include <nlohmann/json.hpp>

#include "dataset/gdal_handle.h"
#include "store/format.h"
#include "store/hashes.h"

namespace terray {

constexpr size_t kHeaderBytes = 65536;

std::string BakePlan::text() const {
    StoreManifest m = manifest;
    m.info.minZ = m.info.maxZ = 0;  // found out while baking
    nlohmann::ordered_json json;
    json["manifest"] = manifestText(m);
    json["code_step"] = codec.codeStep();
    json["gdal"] = GDALVersionInfo("RELEASE_NAME");
    return json.dump(1) + "\n";
}

Result<StoreSource> stateOf(const std::string& name) {
    ensureGdal();
    StoreSource state;
    state.name = name;
    VSIStatBufL stat;
    if (VSIStatL(name.c_str(), &stat) != 0) return state;
    state.bytes = static_cast<uint64_t>(stat.st_size);
    state.modified = static_cast<int64_t>(stat.st_mtime);
    const std::unique_ptr<VSILFILE, int (*)(VSILFILE*)> file(VSIFOpenL(name.c_str(), "rb"),
                                                             VSIFCloseL);
    if (!file) return state;  // a folder
    Bytes header(kHeaderBytes);
    header.resize(VSIFReadL(header.data(), 1, header.size(), file.get()));
    state.headerHash = hashOf(header);
    return state;
}

}  // namespace terray
