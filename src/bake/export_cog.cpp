// SPDX-License-Identifier: Apache-2.0
// Export through GDAL's COG driver, from a temporary GeoTIFF that holds the store's own mips as its
// overviews.
#include "bake/export_cog.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "base/interrupt.h"
#include "base/progress.h"
#include "dataset/gdal_handle.h"
#include "store/format.h"

namespace terray {
namespace {

constexpr int kBlock = kBlockPosts;

Error writeError(const std::string& path) {
    return makeError(ErrorCode::Failed, "'{}' cannot be written: {}", path, gdalMessage());
}

/// Posts a side so that halving (rounded up) gives the nested counts of all mips.
int paddedSide(int64_t posts, int mips) {
    const int64_t step = int64_t{1} << (mips - 1);
    return static_cast<int>((posts - 1 + step - 1) / step * step + 1);
}

struct Removal {
    std::string path;
    ~Removal() { VSIUnlink(path.c_str()); }
};

class CogExport {
public:
    CogExport(const Store& store, std::string path)
        : store_(store), info_(store.info()), path_(std::move(path)) {}

    Result<void> run() {
        clearGdalMessage();
        const Removal temporary{path_ + ".baking.tif"}, partial{path_ + ".partial.tif"};
        DatasetHandle dataset(create(temporary.path));
        if (!dataset || !describe(*dataset)) return writeError(temporary.path);
        TERRAY_TRY(fill(*dataset, temporary.path));
        GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
        if (driver == nullptr) {
            return makeError(ErrorCode::Resource, "this GDAL has no COG driver");
        }
        DatasetHandle cog(driver->CreateCopy(partial.path.c_str(), dataset.get(), FALSE,
                                             cogOptions().List(), stopIfInterrupted, nullptr));
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        if (!cog) return writeError(path_);
        cog.reset();
        if (VSIRename(partial.path.c_str(), path_.c_str()) != 0) return writeError(path_);
        return {};
    }

private:
    static int CPL_STDCALL stopIfInterrupted(double, const char*, void*) {
        return isInterrupted() ? FALSE : TRUE;
    }

    GDALDataset* create(const std::string& path) const {
        CPLStringList options;
        for (const char* option : {"TILED=YES", "BLOCKXSIZE=512", "BLOCKYSIZE=512", "COMPRESS=ZSTD",
                                   "ZSTD_LEVEL=1", "BIGTIFF=IF_SAFER"}) {
            options.AddString(option);
        }
        const int mips = info_.scheme.mipCount();
        return GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            path.c_str(), paddedSide(info_.scheme.columns, mips),
            paddedSide(info_.scheme.rows, mips), 1,
            info_.format == PostFormat::Int16 ? GDT_UInt16 : GDT_Float32, options.List());
    }

    bool describe(GDALDataset& dataset) const {
        GeoTransform transform = geoTransformOf(info_, 0, 0, 0);
        if (dataset.SetGeoTransform(transform.values) != CE_None) return false;
        OGRSpatialReference crs;
        if (!info_.crsWkt.empty()) {
            if (crs.importFromWkt(info_.crsWkt.c_str()) != OGRERR_NONE) return false;
            crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
            if (dataset.SetSpatialRef(&crs) != CE_None) return false;
        }
        GDALRasterBand& band = *dataset.GetRasterBand(1);
        band.SetUnitType("m");
        const bool codes = info_.format == PostFormat::Int16;
        if (codes) {
            band.SetScale(static_cast<double>(info_.zStep));
            band.SetOffset(static_cast<double>(info_.z0));
        }
        band.SetNoDataValue(codes ? static_cast<double>(kHolePost)
                                  : std::numeric_limits<double>::quiet_NaN());
        std::vector<int> factors;
        for (int mip = 1; mip < info_.scheme.mipCount(); ++mip) factors.push_back(1 << mip);
        return factors.empty() ||
               dataset.BuildOverviews("NONE", static_cast<int>(factors.size()), factors.data(), 0,
                                      nullptr, nullptr, nullptr) == CE_None;
    }

    Result<void> fill(GDALDataset& dataset, const std::string& name) {
        double tiles = 0;
        for (int mip = 0; mip < info_.scheme.mipCount(); ++mip) {
            tiles += static_cast<double>(info_.scheme.tileCount(mip));
        }
        Progress progress("Exporting", tiles);
        auto reader = store_.makeReader();
        if (!reader) return reader.error();
        for (int mip = 0; mip < info_.scheme.mipCount(); ++mip) {
            GDALRasterBand* band = dataset.GetRasterBand(1);
            if (mip > 0) band = band->GetOverview(mip - 1);
            if (band == nullptr) return writeError(name);
            const Result<void> done = info_.format == PostFormat::Int16
                                          ? fillMip<uint16_t>(**reader, *band, mip, progress)
                                          : fillMip<float>(**reader, *band, mip, progress);
            if (!done) return done.error();
        }
        return {};
    }

    static Result<void> read(TileReader& reader, TileId id, float* posts) {
        return reader.read(id, posts, kTilePosts);
    }
    static Result<void> read(TileReader& reader, TileId id, uint16_t* codes) {
        return reader.readCodes(id, codes, kTilePosts);
    }
    static float hole(const float*) { return std::numeric_limits<float>::quiet_NaN(); }
    static uint16_t hole(const uint16_t*) { return kHolePost; }

    /// Holes beyond the mip's last column and last row.
    template <class Post>
    Result<void> fillPadding(GDALRasterBand& band, int mip, GDALDataType type) {
        const int width = band.GetXSize(), height = band.GetYSize();
        const int columns = static_cast<int>(info_.scheme.columnsAt(mip));
        const int rows = static_cast<int>(info_.scheme.rowsAt(mip));
        std::vector<Post> line(static_cast<size_t>(width));
        std::fill(line.begin(), line.end(), hole(line.data()));
        for (int row = 0; row < height; ++row) {
            const int first = row < rows ? columns : 0;
            if (first == width) continue;
            if (band.RasterIO(GF_Write, first, row, width - first, 1, line.data(), width - first, 1,
                              type, 0, 0, nullptr) != CE_None) {
                return writeError(path_);
            }
        }
        return {};
    }

    template <class Post>
    Result<void> fillMip(TileReader& reader, GDALRasterBand& band, int mip, Progress& progress) {
        const GDALDataType type = info_.format == PostFormat::Int16 ? GDT_UInt16 : GDT_Float32;
        std::vector<Post> tile(size_t{kTilePosts} * kTilePosts);
        TERRAY_TRY(fillPadding<Post>(band, mip, type));
        for (int y = 0; y < info_.scheme.tilesY(mip); ++y) {
            for (int x = 0; x < info_.scheme.tilesX(mip); ++x) {
                if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
                const TileId id{mip, x, y};
                TERRAY_TRY(read(reader, id, tile.data()));
                // the 513th row and column are the neighbours' first, but at the far ends
                const bool lastX = x + 1 == info_.scheme.tilesX(mip);
                const bool lastY = y + 1 == info_.scheme.tilesY(mip);
                const int width = info_.scheme.cellsX(id) + (lastX ? 1 : 0);
                const int height = info_.scheme.cellsY(id) + (lastY ? 1 : 0);
                if (band.RasterIO(GF_Write, x * kBlock, y * kBlock, width, height, tile.data(),
                                  width, height, type, sizeof(Post),
                                  static_cast<GSpacing>(sizeof(Post)) * kTilePosts,
                                  nullptr) != CE_None) {
                    return writeError(path_);
                }
                progress.advance();
            }
        }
        return {};
    }

    CPLStringList cogOptions() const {
        CPLStringList options;
        for (const char* option : {"BLOCKSIZE=512", "OVERVIEWS=FORCE_USE_EXISTING",
                                   "NUM_THREADS=ALL_CPUS", "BIGTIFF=IF_SAFER"}) {
            options.AddString(option);
        }
        const double bound = store_.manifest().maxError;
        if (info_.format == PostFormat::Float32 && bound > 0) {
            options.AddString("COMPRESS=LERC_ZSTD");
            options.SetNameValue("MAX_Z_ERROR", fmt::format("{}", 0.5 * bound).c_str());
        } else {
            options.AddString("COMPRESS=ZSTD");
            options.AddString("PREDICTOR=YES");
        }
        return options;
    }

    const Store& store_;
    const TerrainInfo& info_;
    std::string path_;
};

}  // namespace

Result<void> exportCog(const Store& store, const std::string& path) {
    ensureGdal();
    return CogExport(store, path).run();
}

}  // namespace terray
