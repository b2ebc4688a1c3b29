// SPDX-License-Identifier: Apache-2.0
// Setting up a picture: view -> camera -> rays -> sun -> cut -> shader.
#include "engine/frame.h"

#include <algorithm>
#include <cmath>

#include "base/log.h"
#include "base/stopwatch.h"
#include "engine/check.h"
#include "engine/places.h"
#include "engine/sunlight.h"

namespace terray {
namespace {

/// c of the bent rays: (1 - k) / 2R, or 0.
Result<double> bendOf(const Terrain::State& state, const GeoFrame& frame, const View& view,
                      const RenderOptions& options) {
    if (options.curvature.value_or(false) && !frame.hasCrs())
        return makeError(
            ErrorCode::Usage,
            "--curvature on: without a CRS the size of the globe is not known; name it "
            "with --assign-crs EPSG:n");
    if (view.projection == Projection::Ortho || !options.curvature.value_or(frame.hasCrs()))
        return 0.0;
    const double radius = frame.curvatureRadius(state.worldCentre());
    return radius > 0 ? (1 - options.refraction) / (2 * radius) : 0.0;
}

/// Corners of the blocks of the coarsest mip that hold something, at their lowest and highest.
std::vector<WorldPoint> outlineOf(const ResidentTerrain& terrain, double exaggeration) {
    const TerrainInfo& info = terrain.info();
    const int mip = terrain.mipCount() - 1;
    const auto blocks = terrain.blocks(terrain.slotOf({mip, 0, 0}));
    const double side = static_cast<double>(int64_t{kBlockCells} << mip);
    std::vector<WorldPoint> outline;
    for (size_t k = 0; k < blocks.size(); ++k) {
        if (blocks[k].minZ > blocks[k].maxZ) continue;
        for (int corner = 0; corner < 4; ++corner) {
            const double i = (static_cast<double>(k % kTileBlocks) + (corner & 1)) * side;
            const double j = (static_cast<double>(k / kTileBlocks) + (corner >> 1)) * side;
            const Vec2 place = info.worldFromLattice.worldFromLattice(
                {std::min(i, static_cast<double>(info.scheme.columns - 1)),
                 std::min(j, static_cast<double>(info.scheme.rows - 1))});
            outline.push_back(
                {place.x, place.y, static_cast<double>(blocks[k].minZ) * exaggeration});
            outline.push_back(
                {place.x, place.y, static_cast<double>(blocks[k].maxZ) * exaggeration});
        }
    }
    return outline;
}

Result<SceneBox> sceneBox(const Terrain::State& state, const GeoFrame& frame, double exaggeration,
                          double bend) {
    const TerrainInfo& info = state.resident->info();
    const Vec2 low = state.worldMin(), high = state.worldMax();
    SceneBox box{{low.x, low.y, static_cast<double>(info.minZ) * exaggeration},
                 {high.x, high.y, static_cast<double>(info.maxZ) * exaggeration},
                 0,
                 bend * exaggeration,
                 outlineOf(*state.resident, exaggeration)};
    if (frame.hasCrs()) {
        auto convergence = frame.meridianConvergence(state.worldCentre());
        if (!convergence) return convergence.error();
        box.gridNorthFromTrueNorth = *convergence;
    }
    return box;
}

/// Square pixels widen an extent that has not the picture's shape.
void noteWiderExtent(const View& resolved, const Camera& camera) {
    if (!resolved.extent) return;
    const Vec2 inside{resolved.extent->xMax - resolved.extent->xMin,
                      resolved.extent->yMax - resolved.extent->yMin};
    const Vec2 added = (camera.orthoSize - inside) / camera.metresPerPixel();
    if (!camera.georeferenced || std::max(added.x, added.y) < 1) return;
    log::note(
        "pixels are square: {:.0f} columns and {:.0f} rows of the {}x{} picture lie beyond "
        "--extent (--size {:.0f}x{:.0f} fits it)",
        added.x, added.y, camera.width, camera.height, camera.width - added.x,
        camera.height - added.y);
}

CutOptions cutOptions(const RenderOptions& options, double bend, const Sun& sun) {
    CutOptions cut;
    cut.tolerancePx = options.tolerancePx;
    cut.exaggeration = options.exaggeration;
    cut.bend = bend;
    cut.sampleShare = shadeSampleShare(options.samples);
    cut.surface = options.surface == Surface::Constant ? kSurfaceConstant : kSurfaceBilinear;
    if (options.shadows && !sun.belowHorizon) cut.sun = SunBound{sun.towards};
    return cut;
}

Result<void> addDevice(const Terrain::State& state, Frame& frame) {
    auto device = state.caster.prepare(frame.options, frame.cut.cut(), frame.deviceFigures);
    if (!device) return device.error();
    frame.caster = &state.caster;
    frame.onDevice = *device;
    if (frame.onDevice != nullptr) frame.device = "vulkan: " + frame.onDevice->deviceName();
    return {};
}

/// Seconds from now on that tiles and blocks are fetched for.
constexpr double kLookAhead = 0.75;

/// Where the camera will be, if the next picture does not wait.
std::optional<Camera> cameraSoon(const Terrain::State& state, const Camera& camera,
                                 const RenderOptions& options) {
    if (options.waitForTiles) return std::nullopt;
    state.motion.see(camera, std::chrono::steady_clock::now());
    return state.motion.after(kLookAhead);
}

Result<void> addShading(const Terrain::State& state, const Sun& sun, Frame& frame) {
    ShadeSettings settings;
    settings.options = frame.options;
    settings.sun = sun;
    settings.crsWkt = state.resident->info().crsWkt;
    const DrapedPhoto photo = state.drapedPhoto();
    settings.shading = frame.options.shading.value_or(photo ? Shading::Photo : Shading::Ramp);
    settings.sunSweeps = state.sunSweeps;
    auto shader = Shader::make(*state.resident, frame.cut.cut(), frame.rays, photo, settings,
                               &state.shadeCache);
    if (!shader) return shader.error();
    frame.shader = std::move(*shader);
    if (settings.shading == Shading::Photo && photo.inBlocks != nullptr)
        frame.photo = std::make_unique<FramePhoto>(state, frame.options);
    const AnnotationContext context{frame.shader.get(), &frame.cut.cut()};
    auto annotations = Annotations::make(frame.options, settings.shading, state.resident->info(),
                                         frame.rays, context);
    if (!annotations) return annotations.error();
    frame.annotations = std::move(*annotations);
    return {};
}

}  // namespace

std::optional<GeoReference> Frame::georeference(const TerrainInfo& info) const {
    const Camera& c = camera();
    if (!c.georeferenced) return std::nullopt;
    const double unit = info.metresPerCrsUnit;
    GeoReference geo;
    geo.crsWkt = info.crsWkt;
    geo.originX = (c.eye.x - 0.5 * c.orthoSize.x) / unit;
    geo.originY = (c.eye.y + 0.5 * c.orthoSize.y) / unit;
    geo.pixelX = c.orthoSize.x / c.width / unit;
    geo.pixelY = -c.orthoSize.y / c.height / unit;
    return geo;
}

Result<PlacedView> placeView(const Terrain::State& state, const View& view,
                             const RenderOptions& options) {
    TERRAY_TRY(checkView(view));
    TERRAY_TRY(checkOptions(view, options));
    auto places = PlaceResolver::make(state, view.lonLat, options.surface);
    if (!places) return places.error();
    auto bend = bendOf(state, places->frame(), view, options);
    if (!bend) return bend.error();
    auto resolved = resolveView(state, *places, view, options.exaggeration);
    if (!resolved) return resolved.error();
    auto box = sceneBox(state, places->frame(), options.exaggeration, *bend);
    if (!box) return box.error();
    auto camera = makeCamera(*resolved, *box);
    if (!camera) return camera.error();
    return PlacedView{std::move(*places), *resolved, *bend, *camera};
}

Result<std::unique_ptr<Frame>> makeFrame(const Terrain::State& state, const View& view,
                                         const RenderOptions& options) {
    const Stopwatch watch;
    auto placed = placeView(state, view, options);
    if (!placed) return placed.error();
    const auto& [places, resolved, bend, camera] = *placed;
    noteWiderExtent(resolved, camera);

    const Vec2 seen =
        resolved.lookAt ? Vec2{resolved.lookAt->x, resolved.lookAt->y} : state.worldCentre();
    auto sun = computeSun(state, places.frame(), camera, seen, options);
    if (!sun) return sun.error();
    auto frame = std::make_unique<Frame>(camera, state.resident->info().worldFromLattice,
                                         options.exaggeration, bend);
    frame->options = options;
    frame->options.shadows = options.shadows && !sun->belowHorizon;
    CutOptions cut = cutOptions(options, bend, *sun);
    const std::optional<Camera> soon = cameraSoon(state, camera, options);
    auto tiles = bringTiles(*state.resident, camera, soon, options, state.reduction, cut);
    if (!tiles) return tiles.error();
    frame->tiles = tiles->figures;
    frame->tolerancePx = cut.tolerancePx;
    frame->cut = selectCut(*state.resident, camera, cut, tiles->wanted);
    auto technique = makeTechnique(options.technique);
    if (!technique) return technique.error();
    frame->technique = std::move(*technique);
    TERRAY_TRY(addDevice(state, *frame));
    TERRAY_TRY(addShading(state, *sun, *frame));
    if (frame->photo) frame->photo->scout(*frame->shader, frame->rays, soon);
    frame->setupMs = watch.elapsedMs();
    return frame;
}

}  // namespace terray
