// SPDX-License-Identifier: Apache-2.0
// The plan as text, and the state of source files.
#include "bake/plan.h"

#include <gdal.h>

#include <nlohmann/json.hpp>

#include "dataset/gdal_handle.h"
#include "store/format.h"
#include "store/hashes.h"

namespace terray {

std::string BakePlan::text() const {
    StoreManifest m = manifest;
    m.info.minZ = m.info.maxZ = 0;  // found out while baking
    nlohmann::ordered_json json;
    json["manifest"] = manifestText(m);
    json["code_step"] = codec.codeStep();
    json["gdal"] = GDALVersionInfo("RELEASE_NAME");
    return json.dump(1) + "\n";
}

}  // namespace terray
