// SPDX-License-Identifier: Apache-2.0
// All options of the product, with the defaults of the command line (docs: `terray render --help`).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace terray {

enum class HeightUnit { Metre, Foot, UsSurveyFoot };
enum class HeightEncoding { None, TerrainRgb, Terrarium };

/// Fixed when a terrain is opened: what the data do not say, the user says.
struct OpenOptions {
    std::string assignCrs;   ///< "EPSG:n" or WKT; empty: as the file says
    std::string workingCrs;  ///< --crs; empty: chosen by rule, stated in the output
    std::optional<HeightUnit> heightUnit;
    std::optional<double> nodata;
    int band = 1;
    HeightEncoding encoding = HeightEncoding::None;
    std::string photo;            ///< raster to drape; empty: none
    std::vector<int> photoBands;  ///< 1 or 3 band numbers; empty: by colour interpretation
    std::optional<std::array<double, 2>> photoStretch;  ///< percentiles, e.g. 2, 98
    bool storedPhoto = true;   ///< load the photo of a store, if it has one and none is given
    uint64_t memoryBytes = 0;  ///< 0: the smaller of 2 GiB and half of the RAM
    int threads = 0;           ///< 0: all cores
};

enum class Surface { Bilinear, Constant };
enum class Shading {
    Photo,
    Ramp,
    Hillshade,
    Normal,
    Slope,
    Height,
    Depth,
    Distance,
    Mip,
    Steps,
    Shadow,
    Grid,
    Light
};

/// Free each frame.
struct RenderOptions {
    std::string technique = "ray_cast";
    std::string device = "auto";  ///< auto (the CPU), cpu, vulkan, vulkan:N, vulkan:NAME
    int samples = 4;              ///< rays a pixel: 1, 2, 4, 8, 16
    Surface surface = Surface::Bilinear;
    double tolerancePx = 2.0 / 3.0;  ///< 0: always finest
    std::optional<bool> curvature;   ///< default: on when there is a CRS
    double refraction = 0.13;
    double exaggeration = 1;

    std::optional<Shading> shading;  ///< default: photo if there is one, else ramp
    std::string ramp;  ///< built-in name or a GDAL colour text file; empty: chosen by range
    std::optional<std::array<double, 2>> sunAzElDeg;  ///< azimuth from true north, elevation
    std::string time;                                 ///< ISO 8601; overrides the default sun
    bool shadows = true;
    std::optional<double> hazeKm;    ///< visual range; default by scene, 0 = none
    std::string background = "sky";  ///< sky, transparent, or #rrggbb
    double contoursM = 0;            ///< interval in metres, 0 = none
    bool legend = false, scaleBar = false, northArrow = false, base = false;
    double reliefOnPhotoPercent = 50;

    /// Of a store whose tiles come on demand. False: coarser ones stand in for those on their way.
    bool waitForTiles = true;
    bool allowMissing = false;  ///< a coarser one stands in for a tile that cannot be read
};

/// What the arbitrary outputs hold; float, one value (position, normal: three) a pixel, NaN for a
/// miss.
enum class Aov { Distance, Depth, Position, Normal, Height, Mip, Steps, Shadow, Error };

struct AovOutput {
    Aov aov = Aov::Distance;
    std::string path;  ///< .tif or .exr
};

struct OutputOptions {
    std::string path = "terray.png";  ///< .png .jpg .exr .tif; empty: no picture
    std::vector<AovOutput> aovs;
    int jpegQuality = 92;
};

}  // namespace terray
