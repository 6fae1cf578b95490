/// Every ray against every triangle, eight triangles at a time.
///
/// The wide part computes intersect_triangle()'s edge functions with the same operations in the
/// same order, hence the same bits, and drops the triangles that outside() drops; the few that are
/// left go through intersect_triangle() itself. So the answer is that of the plain double loop,
/// which tests/reference/truth/test_tracers.cpp holds it against.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "reference/base/assert.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/truth/tracers.h"

namespace scotty::reference {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kPacksPerTile =
    48;  ///< 48 x 288 bytes: a tile stays in the first-level cache
constexpr std::size_t kBruteForceGrain = 64;

// The vector extension of GCC and Clang: IEEE operations lane by lane on every target.
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Mask = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

/// Eight triangles, by vertex, then by axis.
struct TrianglePack {
    std::array<std::array<Floats, 3>, 3> vertex;
};

std::vector<TrianglePack> make_packs(const Scene& scene) {
    const std::size_t count = scene.triangles.size();
    std::vector<TrianglePack> packs((count + kLanes - 1) / kLanes);
    for (std::size_t i = 0; i < packs.size() * kLanes; ++i) {
        const auto& index = scene.triangles[std::min(i, count - 1)];
        for (int corner = 0; corner < 3; ++corner) {
            for (int axis = 0; axis < 3; ++axis) {
                packs[i / kLanes].vertex[corner][axis][i % kLanes] =
                    scene.vertices[index[corner]][axis];
            }
        }
    }
    return packs;
}

struct PreparedRay {
    const Ray* ray;
    Vec3 inverse;
    RayShear shear;
    std::size_t id;
};

/// Lanes that outside() does not reject: all bits set.
Mask candidates(const TrianglePack& pack, const Vec3& origin, const RayShear& shear) {
    const int kz = shear.kz;
    const int kx = kz == 0 ? 2 : 0;  // swap_axes()
    const int ky = kz == 1 ? 2 : 1;
    const auto& [v0, v1, v2] = pack.vertex;
    const Floats az = v0[kz] - origin[kz];
    const Floats bz = v1[kz] - origin[kz];
    const Floats cz = v2[kz] - origin[kz];
    const Floats ax = (v0[kx] - origin[kx]) - shear.sx * az;
    const Floats ay = (v0[ky] - origin[ky]) - shear.sy * az;
    const Floats bx = (v1[kx] - origin[kx]) - shear.sx * bz;
    const Floats by = (v1[ky] - origin[ky]) - shear.sy * bz;
    const Floats cx = (v2[kx] - origin[kx]) - shear.sx * cz;
    const Floats cy = (v2[ky] - origin[ky]) - shear.sy * cz;
    const Floats u = cx * by - cy * bx;
    const Floats v = ax * cy - ay * cx;
    const Floats w = bx * ay - by * ax;
    const Mask negative = (u < 0.0f) | (v < 0.0f) | (w < 0.0f);
    const Mask positive = (u > 0.0f) | (v > 0.0f) | (w > 0.0f);
    return ~(negative & positive);
}

bool any(const Mask& mask) {
    std::array<std::uint64_t, kLanes / 2> words;
    std::memcpy(words.data(), &mask, sizeof mask);
    return (words[0] | words[1] | words[2] | words[3]) != 0;
}

void test_exactly(const Scene& scene, std::uint32_t primitive, const PreparedRay& prepared,
                  Hit& best) {
    const auto& index = scene.triangles[primitive];
    Hit hit = no_hit();
    if (!intersect_triangle(*prepared.ray, prepared.inverse, prepared.shear,
                            scene.vertices[index[0]], scene.vertices[index[1]],
                            scene.vertices[index[2]], hit)) {
        return;
    }
    if (closer(hit.t, primitive, best.t, best.primitive)) best = {hit.t, primitive, hit.u, hit.v};
}

void test_tile(const Scene& scene, std::span<const TrianglePack> tile, std::size_t first_triangle,
               const PreparedRay& prepared, Hit& best) {
    for (std::size_t p = 0; p < tile.size(); ++p) {
        const Mask mask = candidates(tile[p], prepared.ray->origin, prepared.shear);
        if (!any(mask)) continue;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const std::size_t triangle = first_triangle + p * kLanes + lane;
            if (mask[lane] == 0 || triangle >= scene.triangles.size()) continue;
            test_exactly(scene, static_cast<std::uint32_t>(triangle), prepared, best);
        }
    }
}

}  // namespace

void brute_force_closest(const Scene& scene, std::span<const Ray> rays, std::span<Hit> hits) {
    SCOTTY_ASSERT(rays.size(), ==, hits.size());
    const std::vector<TrianglePack> packs = make_packs(scene);
    const auto trace = [&](const tbb::blocked_range<std::size_t>& range) {
        std::vector<PreparedRay> prepared;
        prepared.reserve(range.size());
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            hits[i] = no_hit();
            if (!(rays[i].t_min < rays[i].t_max)) continue;  // an empty interval: nothing to hit
            const Vec3& direction = rays[i].direction;
            prepared.push_back({&rays[i], safe_inverse(direction), ray_shear(direction), i});
        }
        // Tile by tile, so that the triangles are read from memory once per task, not once per ray.
        for (std::size_t first = 0; first < packs.size(); first += kPacksPerTile) {
            const std::size_t count = std::min(kPacksPerTile, packs.size() - first);
            const std::span<const TrianglePack> tile(packs.data() + first, count);
            for (const PreparedRay& ray : prepared) {
                test_tile(scene, tile, first * kLanes, ray, hits[ray.id]);
            }
        }
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), kBruteForceGrain), trace,
                      tbb::simple_partitioner());
}

}  // namespace scotty::reference
