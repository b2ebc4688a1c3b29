// SPDX-License-Identifier: Apache-2.0
// ray_cast on a Vulkan device answers with the CPU's hits, and the validation layer is silent.
#include "technique/ray_cast/ray_cast_vk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "device/devices.h"
#include "raster/synthetic.h"
#include "stream/cut.h"
#include "technique/ray_cast/ray_cast.h"

namespace terray {
namespace {

constexpr double kBend = 6.8e-8;

/// Skipped aloud where there is no device.
class RayCastVkTest : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(setenv("TERRAY_VULKAN_VALIDATION", "1", 1), 0);
        const auto devices = listDevices();
        if (!devices) GTEST_SKIP() << devices.error().message;
        faults_ = validationFaults();
    }
    void TearDown() override { EXPECT_EQ(validationFaults(), faults_); }

    static std::unique_ptr<DeviceTechnique> open(const DeviceRequest& request = {}) {
        auto technique = openRayCast(request);
        EXPECT_TRUE(technique) << (technique ? "" : technique.error().message);
        return std::move(*technique);
    }

private:
    uint64_t faults_ = 0;
};

std::unique_ptr<ResidentTerrain> makeDeviceTerrain(bool town, int64_t size = 1300) {
    SyntheticOptions options;
    options.columns = size;
    options.rows = size - 300;
    options.cell = town ? 1 : 10;
    options.format = town ? PostFormat::Float32 : PostFormat::Int16;
    const auto source = town ? makeTown(options) : makeFractal(options);
    BuildStats stats;
    auto terrain = ResidentTerrain::build(*source, uint64_t{1} << 30, stats);
    EXPECT_TRUE(terrain) << (terrain ? "" : terrain.error().message);
    return std::move(*terrain);
}

struct Eye {
    double x = 0.5, y = 0.45;  ///< share of the terrain's sides
    double z = 0.8;            ///< of its greatest height
    double pitchDeg = -15;
    Projection projection = Projection::Perspective;
};

Camera cameraOf(const ResidentTerrain& terrain, const Eye& eye) {
    const TerrainInfo& info = terrain.info();
    const Vec2 size{static_cast<double>(info.scheme.columns),
                    static_cast<double>(info.scheme.rows)};
    const Vec2 place = info.worldFromLattice.worldFromLattice({size.x * eye.x, size.y * eye.y});
    View view;
    view.width = 256;
    view.height = 144;
    view.projection = eye.projection;
    view.eye = Place{place.x, place.y, static_cast<double>(info.maxZ) * eye.z, false};
    if (eye.projection != Projection::Panorama) view.pitchDeg = eye.pitchDeg;
    view.headingDeg = 37;
    if (eye.projection == Projection::Ortho) {
        view.eye.reset();
        view.headingDeg.reset();
        view.pitchDeg.reset();
    }
    const Vec2 low = info.worldFromLattice.worldFromLattice({0, size.y});
    const Vec2 high = info.worldFromLattice.worldFromLattice({size.x, 0});
    const SceneBox box{{low.x, low.y, static_cast<double>(info.minZ)},
                       {high.x, high.y, static_cast<double>(info.maxZ)},
                       0};
    const auto camera = makeCamera(view, box);
    EXPECT_TRUE(camera) << (camera ? "" : camera.error().message);
    return *camera;
}

/// Image tiles of a picture, one of them with sides that no block divides.
std::vector<ImageTile> tilesOf(const Camera& camera) {
    return {{0, 0, 101, camera.height},
            {101, 0, camera.width - 101, 77},
            {101, 77, camera.width - 101, camera.height - 77}};
}

struct Picture {
    std::vector<Hit> hits;
    TraceCounters counters;
    DeviceFigures figures;
};

Result<Picture> castOnDevice(DeviceTechnique& technique, const FrameCut& cut,
                             const RayFrame& rays) {
    Picture picture;
    const auto tiles = tilesOf(rays.camera());
    picture.hits.resize(static_cast<size_t>(rays.camera().width) *
                        static_cast<size_t>(rays.camera().height));
    TERRAY_TRY(technique.prepare(cut.cut(), picture.figures));
    TERRAY_TRY(technique.cast(cut.cut(), rays, tiles, {0.5, 0.25}, picture.hits, picture.counters,
                              picture.figures));
    return picture;
}

Picture castOnCpu(const FrameCut& cut, const RayFrame& rays) {
    Picture picture;
    picture.hits.resize(static_cast<size_t>(rays.camera().width) *
                        static_cast<size_t>(rays.camera().height));
    size_t first = 0;
    for (const ImageTile& tile : tilesOf(rays.camera())) {
        makeRayCast()->castTile(cut.cut(), rays, tile, {0.5, 0.25},
                                std::span(picture.hits).subspan(first, tile.pixelCount()),
                                picture.counters);
        first += tile.pixelCount();
    }
    return picture;
}

void expectEqualHits(const Picture& device, const Picture& cpu) {
    EXPECT_EQ(device.counters.rays, cpu.counters.rays);
    EXPECT_EQ(device.counters.hits, cpu.counters.hits);
    EXPECT_GT(cpu.counters.hits, cpu.counters.rays / 10);
    size_t elsewhere = 0;
    for (size_t k = 0; k < cpu.hits.size(); ++k) {
        const Hit &a = device.hits[k], &b = cpu.hits[k];
        ASSERT_EQ(isHit(a), isHit(b)) << k;
        if (!isHit(b)) continue;
        EXPECT_EQ(a.flags, b.flags) << k;
        const float allowed = std::max(1e-3f, 1e-5f * b.t);
        EXPECT_NEAR(a.t, b.t, allowed) << k;
        elsewhere += a.tile != b.tile || a.cell != b.cell ? 1u : 0u;
    }
    EXPECT_LE(elsewhere, cpu.hits.size() / 10'000);  // on an edge either cell is right
    // Most is decided on the device; edges of walls less often.
    EXPECT_LT(device.counters.redone, device.counters.rays / 10);
}

void expectCpuHits(DeviceTechnique& technique, const ResidentTerrain& terrain, const FrameCut& cut,
                   const Eye& eye) {
    const double bend = eye.projection == Projection::Ortho ? 0 : kBend;
    const RayFrame rays(cameraOf(terrain, eye), terrain.info().worldFromLattice, 1.0, bend);
    const auto device = castOnDevice(technique, cut, rays);
    ASSERT_TRUE(device) << device.error().message;
    expectEqualHits(*device, castOnCpu(cut, rays));
}

TEST_F(RayCastVkTest, EqualsTheCpuOnTheFractal) {
    const auto terrain = makeDeviceTerrain(false);
    const auto technique = open();
    const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
    for (const Eye& eye :
         {Eye{}, Eye{0.1, 0.9, 3, -40}, Eye{.pitchDeg = -90},
          Eye{.projection = Projection::Panorama}, Eye{.projection = Projection::Ortho}})
        expectCpuHits(*technique, *terrain, cut, eye);
}

TEST_F(RayCastVkTest, EqualsTheCpuOnTheTown) {
    const auto terrain = makeDeviceTerrain(true);
    const auto technique = open();
    const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
    for (const Eye& eye : {Eye{}, Eye{0.1, 0.9, 3, -40}})
        expectCpuHits(*technique, *terrain, cut, eye);
}

TEST_F(RayCastVkTest, EqualsTheCpuWhereMipsMeet) {
    const auto terrain = makeDeviceTerrain(false, 2900);
    const auto technique = open();
    const Eye eye{0.2, 0.2, 1.1, -15};
    CutOptions options;
    options.tolerancePx = 3;
    options.bend = kBend;
    const FrameCut cut = selectCut(*terrain, cameraOf(*terrain, eye), options);
    ASSERT_NE(cut.cut().unlikeMips, 0u);
    expectCpuHits(*technique, *terrain, cut, eye);
}

TEST_F(RayCastVkTest, EqualsTheCpuOnConstantCells) {
    const auto terrain = makeDeviceTerrain(false);
    const auto technique = open();
    expectCpuHits(*technique, *terrain, finestCut(*terrain, kSurfaceConstant), {});
}

TEST_F(RayCastVkTest, TilesStayAndOnlyNewOnesAreUploaded) {
    const auto terrain = makeDeviceTerrain(false);
    const auto technique = open();
    const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
    DeviceFigures first, second;
    ASSERT_TRUE(technique->prepare(cut.cut(), first));
    ASSERT_TRUE(technique->prepare(cut.cut(), second));
    EXPECT_GT(first.uploadedBytes, size_t{6} * kSlotPosts * 2);
    EXPECT_LT(second.uploadedBytes, 10'000u);  // tables
}

/// The tiles of mip 0 in one half of a terrain.
FrameCut halfCut(const ResidentTerrain& terrain, int first, int last) {
    std::vector<TileId> tiles;
    for (int y = 0; y < 2; ++y)
        for (int x = first; x <= last; ++x) tiles.push_back({0, x, y});
    return cutOf(terrain, kSurfaceBilinear, tiles);
}

TEST_F(RayCastVkTest, TilesGiveWayWithinTheBudget) {
    const auto terrain = makeDeviceTerrain(false, 12'000 / 4);
    ASSERT_GE(terrain->info().scheme.columns, 512 * 5);
    // Room for rays, staging and one chunk of 18 tiles; 24 are there.
    const auto technique = open({.which = "", .budgetBytes = uint64_t{96} << 20});
    const FrameCut cuts[] = {cutOf(*terrain, kSurfaceBilinear, {}), halfCut(*terrain, 0, 2),
                             halfCut(*terrain, 3, 4)};
    for (int round = 0; round < 2; ++round)
        for (const FrameCut& cut : cuts) {
            DeviceFigures figures;
            ASSERT_TRUE(technique->prepare(cut.cut(), figures));
        }
    expectCpuHits(*technique, *terrain, cuts[1], {0.25, 0.2, 1.5, -60});
}

TEST_F(RayCastVkTest, TooManyTilesAreAnErrorWithARemedy) {
    const auto terrain = makeDeviceTerrain(false, 2900);
    const auto technique = open({.which = "", .budgetBytes = uint64_t{64} << 20});
    DeviceFigures figures;
    const auto prepared = technique->prepare(finestCut(*terrain, kSurfaceBilinear).cut(), figures);
    ASSERT_FALSE(prepared);
    EXPECT_EQ(prepared.error().code, ErrorCode::Resource);
    EXPECT_NE(prepared.error().message.find("--tolerance"), std::string::npos);
    EXPECT_FALSE(technique->isLost());
    // It goes on with what fits.
    expectCpuHits(*technique, *terrain, halfCut(*terrain, 0, 1), {0.15, 0.2, 1.5, -60});
}

TEST_F(RayCastVkTest, LittleMemoryMakesSmallerBatches) {
    const auto terrain = makeDeviceTerrain(false, 700);
    const auto technique = open({.which = "", .budgetBytes = uint64_t{34} << 20});
    expectCpuHits(*technique, *terrain, finestCut(*terrain, kSurfaceBilinear), {});
}

TEST_F(RayCastVkTest, ALostDeviceIsAnError) {
    const auto terrain = makeDeviceTerrain(false, 700);
    const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
    const RayFrame rays(cameraOf(*terrain, {}), terrain->info().worldFromLattice, 1.0, kBend);
    for (const int submits : {0, 1}) {
        const auto technique = open({.which = "", .submitsUntilLost = submits});
        const auto picture = castOnDevice(*technique, cut, rays);
        ASSERT_FALSE(picture);
        EXPECT_TRUE(technique->isLost());
    }
}

}  // namespace
}  // namespace terray
