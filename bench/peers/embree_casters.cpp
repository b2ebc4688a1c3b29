// SPDX-License-Identifier: Apache-2.0
// Rays for Embree in float, relative to the scene's origin, packet by packet.
#include "peers/embree_casters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/assert.h"
#include "base/simd_clones.h"

namespace terray::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kMaxLanes = 16;

/// Columns and rows of a packet's pixels: 1 x 1, 4 x 2 or 4 x 4.
constexpr int columnsOf(int lanes) { return std::min(lanes, 4); }
constexpr int rowsOf(int lanes) { return lanes / columnsOf(lanes); }

/// A pinhole: the direction at the picture's origin, and its change per pixel; all in metres.
struct Pinhole {
    Vec3 corner{}, alongX{}, alongY{};
    float eye[3] = {};

    Pinhole(const RayFrame& frame, const WorldPoint& origin) {
        TERRAY_ASSERT(frame.camera().projection == Projection::Perspective);
        TERRAY_ASSERT(frame.exaggeration() == 1.0 && frame.bend() == 0.0);
        const Affine2& map = frame.worldFromLattice();
        const auto direction = [&](double px, double py) {
            const Ray ray = frame.pencilRay(px, py).ray;
            const Vec2 level = ray.dx * map.column + ray.dy * map.row;
            return Vec3{level.x, level.y, ray.dz};
        };
        const double width = frame.camera().width, height = frame.camera().height;
        corner = direction(0, 0);
        alongX = (direction(width, 0) - corner) / width;
        alongY = (direction(0, height) - corner) / height;
        const WorldPoint& from = frame.camera().eye;
        eye[0] = static_cast<float>(from.x - origin.x);
        eye[1] = static_cast<float>(from.y - origin.y);
        eye[2] = static_cast<float>(from.z - origin.z);
    }
};

/// Directions of a packet: the one of its first pixel (rounded once, from double), and the change
/// to the others in float.
struct PacketAim {
    float first[3], alongX[3], alongY[3];

    PacketAim(const Pinhole& pinhole, double px, double py) {
        const Vec3 d = pinhole.corner + px * pinhole.alongX + py * pinhole.alongY;
        for (int axis = 0; axis < 3; ++axis) {
            first[axis] = static_cast<float>(d[axis]);
            alongX[axis] = static_cast<float>(pinhole.alongX[axis]);
            alongY[axis] = static_cast<float>(pinhole.alongY[axis]);
        }
    }
};

/// Unit directions of a packet of 4 columns.
TERRAY_SIMD_CLONES
void aimPacket(const PacketAim& aim, int lanes, float* dx, float* dy, float* dz) {
    for (int k = 0; k < lanes; ++k) {
        const auto column = static_cast<float>(k % 4), row = static_cast<float>(k / 4);
        const float x = aim.first[0] + column * aim.alongX[0] + row * aim.alongY[0];
        const float y = aim.first[1] + column * aim.alongX[1] + row * aim.alongY[1];
        const float z = aim.first[2] + column * aim.alongX[2] + row * aim.alongY[2];
        const float s = 1.0f / std::sqrt(x * x + y * y + z * z);
        dx[k] = x * s;
        dy[k] = y * s;
        dz[k] = z * s;
    }
}

/// Where the rays towards the sun start: at a distance along the directions of a packet, lifted by
/// about the rounding of such a place, so that float does not shadow itself.
TERRAY_SIMD_CLONES
void startOnGround(const float* eye, const float* t, int lanes, const float* dx, const float* dy,
                   const float* dz, float* x, float* y, float* z) {
    for (int k = 0; k < lanes; ++k) {
        const float along = t[k] < kInfinity ? t[k] : 0.0f;
        x[k] = eye[0] + along * dx[k];
        y[k] = eye[1] + along * dy[k];
        z[k] = eye[2] + along * dz[k] + (0.002f + 3e-7f * along);
    }
}

template <int kLanes>
struct Packet;
template <>
struct Packet<8> {
    using RayHit = RTCRayHit8;
    static void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context,
                          RayHit& rays) {
        rtcIntersect8(valid, scene, context, &rays);
    }
};
template <>
struct Packet<16> {
    using RayHit = RTCRayHit16;
    static void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context,
                          RayHit& rays) {
        rtcIntersect16(valid, scene, context, &rays);
    }
};

/// What does not change from packet to packet.
template <class Rays>
void fillConstants(Rays& rays, int lanes) {
    for (int k = 0; k < lanes; ++k) {
        rays.tnear[k] = 0.0f;
        rays.time[k] = 0.0f;
        rays.mask[k] = ~0u;
        rays.id[k] = 0;
        rays.flags[k] = 0;
    }
}

/// The lanes of a packet at (left, top) that lie inside the tile: -1 valid, 0 not.
template <int kLanes>
void markLanes(const ImageTile& tile, int left, int top, int* valid) {
    for (int k = 0; k < kLanes; ++k)
        valid[k] = left + k % 4 < tile.width && top + k / 4 < tile.height ? -1 : 0;
}

void readValues(const ImageTile& tile, const Scratch& scratch, std::span<float> values) {
    std::copy_n(scratch.values.begin(), tile.pixelCount(), values.begin());
}

template <int kLanes>
class EmbreePacketCaster final : public Caster {
public:
    EmbreePacketCaster(const EmbreeScene& scene, const RayFrame& frame)
        : scene_(scene.scene()), pinhole_(frame, scene.origin()) {}

    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        typename Packet<kLanes>::RayHit rays;
        fillConstants(rays.ray, kLanes);
        std::fill_n(rays.ray.org_x, kLanes, pinhole_.eye[0]);
        std::fill_n(rays.ray.org_y, kLanes, pinhole_.eye[1]);
        std::fill_n(rays.ray.org_z, kLanes, pinhole_.eye[2]);
        alignas(64) int valid[kLanes];
        for (int y = 0; y < tile.height; y += rowsOf(kLanes))
            for (int x = 0; x < tile.width; x += columnsOf(kLanes)) {
                markLanes<kLanes>(tile, x, y, valid);
                const PacketAim aim(pinhole_, tile.x + x + 0.5, tile.y + y + 0.5);
                aimPacket(aim, kLanes, rays.ray.dir_x, rays.ray.dir_y, rays.ray.dir_z);
                std::fill_n(rays.ray.tfar, kLanes, kInfinity);
                std::fill_n(rays.hit.geomID, kLanes, RTC_INVALID_GEOMETRY_ID);
                std::fill_n(rays.hit.instID[0], kLanes, RTC_INVALID_GEOMETRY_ID);
                Packet<kLanes>::intersect(valid, scene_, &context, rays);
                for (int k = 0; k < kLanes; ++k)
                    if (valid[k] != 0)
                        scratch.values[indexOf(tile, x + k % 4, y + k / 4)] = rays.ray.tfar[k];
            }
        scratch.counters.rays += tile.pixelCount();
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        readValues(tile, scratch, values);
    }

private:
    RTCScene scene_;
    Pinhole pinhole_;
};

class EmbreeSingleCaster final : public Caster {
public:
    EmbreeSingleCaster(const EmbreeScene& scene, const RayFrame& frame)
        : scene_(scene.scene()), pinhole_(frame, scene.origin()) {}

    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        RTCRayHit ray{};
        ray.ray.org_x = pinhole_.eye[0];
        ray.ray.org_y = pinhole_.eye[1];
        ray.ray.org_z = pinhole_.eye[2];
        ray.ray.mask = ~0u;
        for (int y = 0; y < tile.height; ++y)
            for (int x = 0; x < tile.width; ++x) {
                const PacketAim aim(pinhole_, tile.x + x + 0.5, tile.y + y + 0.5);
                const float* d = aim.first;
                const float s = 1.0f / std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
                ray.ray.dir_x = d[0] * s;
                ray.ray.dir_y = d[1] * s;
                ray.ray.dir_z = d[2] * s;
                ray.ray.tfar = kInfinity;
                ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(scene_, &context, &ray);
                scratch.values[indexOf(tile, x, y)] = ray.ray.tfar;
            }
        scratch.counters.rays += tile.pixelCount();
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        readValues(tile, scratch, values);
    }

private:
    RTCScene scene_;
    Pinhole pinhole_;
};

class EmbreeShadowCaster final : public Caster {
public:
    EmbreeShadowCaster(const EmbreeScene& scene, const RayFrame& frame,
                       std::vector<float> distances)
        : scene_(scene.scene()),
          pinhole_(frame, scene.origin()),
          distances_(std::move(distances)),
          width_(frame.camera().width) {}

    void castTile(const ImageTile& tile, Scratch& scratch) const override {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        RTCRay16 rays;
        fillConstants(rays, kMaxLanes);
        const Vec3 sun = towardsSun();
        std::fill_n(rays.dir_x, kMaxLanes, static_cast<float>(sun.x));
        std::fill_n(rays.dir_y, kMaxLanes, static_cast<float>(sun.y));
        std::fill_n(rays.dir_z, kMaxLanes, static_cast<float>(sun.z));
        alignas(64) int valid[kMaxLanes];
        alignas(64) float dx[kMaxLanes], dy[kMaxLanes], dz[kMaxLanes], t[kMaxLanes];
        for (int y = 0; y < tile.height; y += 4)
            for (int x = 0; x < tile.width; x += 4) {
                markLanes<kMaxLanes>(tile, x, y, valid);
                for (int k = 0; k < kMaxLanes; ++k) {
                    t[k] = valid[k] != 0 ? distanceAt(tile.x + x + k % 4, tile.y + y + k / 4)
                                         : kInfinity;
                    valid[k] = t[k] < kInfinity ? -1 : 0;
                    scratch.counters.rays += valid[k] != 0 ? 1 : 0;
                }
                const PacketAim aim(pinhole_, tile.x + x + 0.5, tile.y + y + 0.5);
                aimPacket(aim, kMaxLanes, dx, dy, dz);
                startOnGround(pinhole_.eye, t, kMaxLanes, dx, dy, dz, rays.org_x, rays.org_y,
                              rays.org_z);
                std::fill_n(rays.tfar, kMaxLanes, kInfinity);
                rtcOccluded16(valid, scene_, &context, &rays);
                for (int k = 0; k < kMaxLanes; ++k)
                    if (x + k % 4 < tile.width && y + k / 4 < tile.height)
                        scratch.values[indexOf(tile, x + k % 4, y + k / 4)] =
                            valid[k] != 0 && rays.tfar[k] < 0.0f ? 1.0f : 0.0f;
            }
    }
    void readTile(const ImageTile& tile, const Scratch& scratch,
                  std::span<float> values) const override {
        readValues(tile, scratch, values);
    }

private:
    float distanceAt(int x, int y) const {
        return distances_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
                          static_cast<size_t>(x)];
    }

    RTCScene scene_;
    Pinhole pinhole_;
    std::vector<float> distances_;
    int width_;
};

}  // namespace

std::unique_ptr<Caster> makeEmbreeCaster(const EmbreeScene& scene, const RayFrame& frame,
                                         int lanes) {
    if (lanes == 1) return std::make_unique<EmbreeSingleCaster>(scene, frame);
    if (lanes == 8) return std::make_unique<EmbreePacketCaster<8>>(scene, frame);
    TERRAY_ASSERT(lanes == 16);
    return std::make_unique<EmbreePacketCaster<16>>(scene, frame);
}

std::unique_ptr<Caster> makeEmbreeShadowCaster(const EmbreeScene& scene, const RayFrame& frame,
                                               std::vector<float> distances) {
    return std::make_unique<EmbreeShadowCaster>(scene, frame, std::move(distances));
}

}  // namespace terray::bench
