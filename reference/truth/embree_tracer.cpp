#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstring>

#include "reference/base/assert.h"
#include "reference/base/embree_api.h"
#include "reference/truth/tracers.h"

namespace scotty::reference {

struct EmbreeTracer::State {
    EmbreeOwner<RTCDevice> device;
    EmbreeOwner<RTCScene> scene;
};

namespace {

constexpr std::size_t kEmbreeGrain = 512;

template <typename T>
T* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
    return static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count));
}

/// Copies into buffers of Embree's own, which end in the padding that its wide loads need.
EmbreeOwner<RTCGeometry> make_geometry(RTCDevice device, const Scene& scene) {
    EmbreeOwner<RTCGeometry> geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
    check_embree(device, "rtcNewGeometry");
    auto* vertices = new_buffer<Vec3>(geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3,
                                      scene.vertices.size());
    auto* indices = new_buffer<std::array<std::uint32_t, 3>>(
        geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, scene.triangles.size());
    check_embree(device, "rtcSetNewGeometryBuffer");
    std::memcpy(vertices, scene.vertices.data(), scene.vertices.size() * sizeof(Vec3));
    std::memcpy(indices, scene.triangles.data(), scene.triangles.size() * sizeof(*indices));
    rtcCommitGeometry(geometry.get());
    return geometry;
}

bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// False for rays that hit nothing by definition and that Embree need not be asked about: an empty
/// interval (dead rays have one), no direction, not a number.
bool can_hit(const Ray& ray) {
    return ray.t_min < ray.t_max && is_finite(ray.origin) && is_finite(ray.direction) &&
           !is_zero(ray.direction);
}

/// Embree's interval is open at the near end and closed at the far one; ours is the opposite.
RTCRay to_embree(const Ray& ray) {
    RTCRay out{};
    out.org_x = ray.origin.x;
    out.org_y = ray.origin.y;
    out.org_z = ray.origin.z;
    out.tnear = ray.t_min > 0.0f ? std::nextafter(ray.t_min, 0.0f) : 0.0f;
    out.dir_x = ray.direction.x;
    out.dir_y = ray.direction.y;
    out.dir_z = ray.direction.z;
    out.tfar = std::isinf(ray.t_max) ? ray.t_max : std::nextafter(ray.t_max, 0.0f);
    out.mask = 0xffffffffu;
    return out;
}

}  // namespace

EmbreeTracer::EmbreeTracer(const Scene& scene) : state_(std::make_unique<State>()) {
    state_->device = make_embree_device();
    RTCDevice device = state_->device.get();
    state_->scene.reset(rtcNewScene(device));
    check_embree(device, "rtcNewScene");
    rtcSetSceneFlags(state_->scene.get(), RTC_SCENE_FLAG_ROBUST);
    if (!scene.triangles.empty()) {
        const EmbreeOwner<RTCGeometry> geometry = make_geometry(device, scene);
        rtcAttachGeometry(state_->scene.get(), geometry.get());
    }
    rtcCommitScene(state_->scene.get());
    check_embree(device, "rtcCommitScene");
}

EmbreeTracer::~EmbreeTracer() = default;
EmbreeTracer::EmbreeTracer(EmbreeTracer&&) noexcept = default;
EmbreeTracer& EmbreeTracer::operator=(EmbreeTracer&&) noexcept = default;

Hit EmbreeTracer::closest(const Ray& ray) const {
    if (!can_hit(ray)) return no_hit();
    float near = -1.0f;
    while (true) {
        RTCRayHit query{};
        query.ray = to_embree(ray);
        if (near >= 0.0f) query.ray.tnear = near;
        near = query.ray.tnear;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.primID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree_intersect(state_->scene.get(), query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return no_hit();
        // Embree compares before it divides, so the t that it returns may be just outside. Beyond
        // t_max there is nothing nearer; before t_min we look again from a little farther on.
        if (!(query.ray.tfar < ray.t_max)) return no_hit();
        if (query.ray.tfar >= ray.t_min) {
            return {query.ray.tfar, query.hit.primID, query.hit.u, query.hit.v};
        }
        near = std::nextafter(near, kInfinity);
    }
}

bool EmbreeTracer::occluded(const Ray& ray) const {
    if (!can_hit(ray)) return false;
    RTCRay query = to_embree(ray);
    embree_occluded(state_->scene.get(), query);
    return query.tfar < 0.0f;
}

void EmbreeTracer::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
    SCOTTY_ASSERT(rays.size(), ==, hits.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), kEmbreeGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i < range.end(); ++i) {
                              hits[i] = closest(rays[i]);
                          }
                      });
}

void EmbreeTracer::occluded(std::span<const Ray> rays, std::span<std::uint8_t> results) const {
    SCOTTY_ASSERT(rays.size(), ==, results.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), kEmbreeGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i < range.end(); ++i) {
                              results[i] = occluded(rays[i]) ? 1 : 0;
                          }
                      });
}

std::string EmbreeTracer::version() { return RTC_VERSION_STRING; }

}  // namespace scotty::reference
