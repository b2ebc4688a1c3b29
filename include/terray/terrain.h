// SPDX-License-Identifier: Apache-2.0
// Opening a terrain, and what is known of it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "terray/export.h"
#include "terray/options.h"
#include "terray/result.h"

namespace terray {

/// Something that the data do not say, and what was taken for it.
struct Assumption {
    std::string text;        ///< one sentence, naming the option that says otherwise
    bool isWarning = false;  ///< places or heights are wrong, not only less exact, if it is wrong
};

/// Facts about a source (`terray info`): what the file says, and what Terray makes of it.
struct SourceInfo {
    std::string source, driver;
    int64_t columns = 0, rows = 0;  ///< samples of the file
    int bands = 0;
    std::string sampleType;                  ///< "Int16", "Float32", ...
    std::string crsName, crsWkt;             ///< of the file; empty if none
    std::vector<double> geoTransform;        ///< six numbers as GDAL; of pixel corners
    double pixelWidth = 0, pixelHeight = 0;  ///< file's units
    std::string horizontalUnit;              ///< "degree", "metre", "US survey foot", ...
    bool pixelIsPoint = false;
    std::string nodataRule;  ///< "value -32768", "NaN", "mask band", "alpha band", "none"
    std::string heightUnit;  ///< "m", "ft", "us-ft"
    double scale = 1, offset = 0;
    bool hasRange = false;  ///< the samples have been scanned
    /// Metres, of the samples as decoded (exact scan); min > max: no sample has a height.
    double minHeight = 0, maxHeight = 0;
    int64_t holes = 0;  ///< samples without a height
    // working lattice
    bool warped = false;
    std::string workingCrsName;
    int64_t workingColumns = 0, workingRows = 0;
    double workingCellX = 0, workingCellY = 0;  ///< metres
    int mips = 0;
    std::string postFormat;      ///< "16 bit" or "float"
    uint64_t residentBytes = 0;  ///< memory to render it
    std::vector<Assumption> assumptions;
    std::string photo;  ///< one line about the photo, if any
};

/// Reads a source's header and, with `scan`, its samples' range.
TERRAY_API Result<SourceInfo> inspect(const std::string& source, const OpenOptions& options,
                                      bool scan = true);

/// An opened terrain, resident in memory, ready to be seen and asked. Movable. const-shared.
class TERRAY_API Terrain {
public:
    /// Errors: Input (unreadable, refused, too large for the memory budget), Usage (bad option
    /// values).
    static Result<Terrain> open(const std::string& source, const OpenOptions& options = {});
    ~Terrain();
    Terrain(Terrain&&) noexcept;
    Terrain& operator=(Terrain&&) noexcept;

    const SourceInfo& info() const;

    struct State;
    const State& state() const { return *state_; }

private:
    explicit Terrain(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace terray
