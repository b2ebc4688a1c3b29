// SPDX-License-Identifier: Apache-2.0
// The explicit table of techniques.
#include "technique/ray_cast/ray_cast.h"
#include "technique/ray_cast/ray_cast_vk.h"
#include "technique/technique.h"

namespace terray {

std::span<const TechniqueEntry> techniqueTable() {
    static const TechniqueEntry kTable[] = {
        {"ray_cast",
         "every pixel's ray through the maximum mipmaps of the tile cut, exact (default)",
         makeRayCast, openRayCast},
    };
    return kTable;
}

namespace {

Result<const TechniqueEntry*> entryOf(const std::string& name) {
    std::string known;
    for (const TechniqueEntry& entry : techniqueTable()) {
        if (entry.name == name) return &entry;
        known += (known.empty() ? "" : ", ") + entry.name;
    }
    return makeError(ErrorCode::Usage, "--technique {}: there is no such technique; known: {}",
                     name, known);
}

}  // namespace

Result<std::unique_ptr<Technique>> makeTechnique(const std::string& name) {
    const auto entry = entryOf(name);
    if (!entry) return entry.error();
    return (*entry)->make();
}

Result<std::unique_ptr<DeviceTechnique>> openTechnique(const std::string& name,
                                                       const DeviceRequest& request) {
    const auto entry = entryOf(name);
    if (!entry) return entry.error();
    return (*entry)->openOnDevice(request);
}

}  // namespace terray
