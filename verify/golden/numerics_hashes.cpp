/// A hash of what the shared numerics compute on a table of arguments, and of what the contract's
/// records are before anything is said.
///
/// Emulator, CUDA text and Embree's renderer call the same functions, so that they agree on a fault
/// in one. Scenes rarely meet a tie, a zero or an infinity; the table does.
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <type_traits>
#include <vector>

#include "gpu/parity/parity_functions.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"
#include "reference/numerics/closest_in_subtree.h"
#include "reference/numerics/pixel_sums.h"
#include "reference/numerics/surface.h"
#include "verify/golden/hash_book.h"

namespace scotty::verify {

namespace {

using namespace reference;

/// Words in a row: of floats their bits, and one NaN for all.
class Words {
 public:
    template <class T>
    void add(const T& value) {
        if constexpr (std::is_same_v<T, Vec3>) {
            add(value.x), add(value.y), add(value.z);
        } else if constexpr (std::is_same_v<T, float>) {
            words_.push_back(gpu::parity_bits(value));
        } else if constexpr (std::is_same_v<T, double>) {
            add(static_cast<float>(value));
        } else if constexpr (std::is_enum_v<T>) {
            add(static_cast<std::underlying_type_t<T>>(value));
        } else {
            words_.push_back(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value)));
            words_.push_back(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32));
        }
    }
    template <class T, class... More>
    void add(const T& first, const More&... more) {
        add(first);
        (add(more), ...);
    }
    void add(const Ray& ray) { add(ray.origin, ray.t_min, ray.direction, ray.t_max); }
    void add(const Hit& hit) { add(hit.t, hit.primitive, hit.u, hit.v); }

    std::uint64_t hash() const {
        return hash_of_text(
            {reinterpret_cast<const char*>(words_.data()), words_.size() * sizeof(std::uint32_t)});
    }

 private:
    std::vector<std::uint32_t> words_;
};

constexpr float kInf = kInfinity;
/// Signs, ties, the smallest, the largest, and numbers between that have no power of two.
constexpr std::array kNumbers{0.0f,   -0.0f, 1.0f,   -1.0f,  0.3f,  -0.7f,  2.0f,  3.0e-20f,
                              1e-45f, 1e12f, -5e30f, 0.999f, 16.0f, 255.5f, 1e-7f, -1e-7f};

/// Vectors of such numbers; many have two components alike, or all three.
std::vector<Vec3> vectors() {
    std::vector<Vec3> all;
    std::mt19937 random(1);
    const auto number = [&] { return kNumbers[random() % kNumbers.size()]; };
    for (int i = 0; i < 160; ++i) {
        Vec3 v(number(), number(), number());
        if (i % 5 == 0) v.y = v.x;
        if (i % 5 == 1) v.z = -v.y;
        if (i % 5 == 2) v.x = v.z;
        all.push_back(v);
    }
    for (const float x : {-1.0f, 0.0f, 1.0f}) {
        for (const float y : {-1.0f, 0.0f, 1.0f}) {
            for (const float z : {-1.0f, 0.0f, 1.0f}) all.emplace_back(x, y, z);
        }
    }
    return all;
}

/// What the test of device against host computes too (gpu/parity/).
void add_parity_cases(Words& words) {
    std::mt19937 random(2);
    for (std::uint32_t which = 0; which < static_cast<std::uint32_t>(gpu::ParityCase::count);
         ++which) {
        for (int i = 0; i < 400; ++i) {
            gpu::ParityOperands operands{};
            for (float& x : operands.x) {
                const auto bits = static_cast<std::uint32_t>(random());
                x = bits % 4 == 0 ? kNumbers[(bits >> 2) % kNumbers.size()]
                                  : static_cast<float>(static_cast<std::int32_t>(bits)) * 0x1p-30f;
            }
            const gpu::ParityWords found =
                parity_case(static_cast<gpu::ParityCase>(which), operands);
            for (const std::uint32_t word : found.word) words.add(word);
        }
    }
}

void add_geometry(Words& words) {
    const std::vector<Vec3> all = vectors();
    for (std::size_t i = 0; i + 3 < all.size(); ++i) {
        const Vec3& a = all[i];
        const Vec3& b = all[i + 1];
        const Vec3& c = all[i + 2];
        words.add(max_abs(a), max_component(a), length(a), is_zero(a), min_number(a, b),
                  max_number(a, b), safe_inverse(a), abs_of(a));
        words.add(box_pad(a, min_of(b, c), max_of(b, c)));
        const RaySlabs slabs = ray_slabs(a, safe_inverse(b), 0.25f);
        words.add(slabs.inverse, slabs.near_offset, slabs.far_offset);
        const BoxInterval clipped = clip({a.x, a.y}, b.x, b.y);
        words.add(clipped.entry, clipped.exit, overlaps(clipped), overlaps({a.x, a.x}));
        for (int kz = 0; kz < 3; ++kz) words.add(swap_axes(a, kz), component(a, kz), next_axis(kz));
        if (is_zero(a)) continue;
        const RayShear shear = ray_shear(a);
        words.add(shear.kz, shear.sx, shear.sy, shear.sz);
    }
    for (const float u : kNumbers) {
        for (const float v : kNumbers) {
            for (const float w : {1.0f, 0.0f, -0.0f, -1.0f, 1e-45f, -1e-45f}) {
                const EdgeFunctions e{u, v, w};
                words.add(outside(e), may_be_zero(e), signs_differ(e));
            }
            words.add(closer(u, 3, v, 2), closer(u, 2, v, 3), closer(u, 2, v, 2),
                      clamp_to(u, -0.5f, v));
        }
    }
    // Triangles that a ray meets inside, on edges, on corners and not at all, from either side.
    for (const Vec3& to : all) {
        for (const Vec3& origin : {Vec3(0.0f, 0.0f, 5.0f), Vec3(3.0f, -2.0f, 1.0f)}) {
            const Ray ray{origin, 0.0f, to - origin, kInf};
            if (is_zero(ray.direction)) continue;
            const RayShear shear = ray_shear(ray.direction);
            for (const float size : {1.0f, 0.3f}) {
                Hit hit = no_hit();
                words.add(intersect_triangle(ray, safe_inverse(ray.direction), shear,
                                             Vec3(-size, -1.0f, 0.0f), Vec3(1.0f, -size, 0.0f),
                                             Vec3(0.0f, 1.0f, size), hit));
                words.add(hit);
            }
        }
    }
}

/// Distances within boxes, beside them and on their sides; and crossings on both sides of each
/// limit below which a distance is not cut.
void add_cuts(Words& words) {
    const std::vector<Vec3> all = vectors();
    for (std::size_t i = 0; i + 3 < all.size(); ++i) {
        const Vec3 low = min_number(all[i + 1], all[i + 2]);
        const Vec3 high = max_number(all[i + 1], all[i + 2]);
        for (const float t : {-1.0f, -0.0f, 0.0f, 0.5f, 1e12f, kInf}) {
            const CutDistance cut = cut_distance(t, all[i], safe_inverse(all[i + 3]), low, high);
            words.add(cut.t, cut.inside);
        }
    }
    const auto around = [](float limit) {
        return std::array{std::nextafter(limit, 0.0f), limit, std::nextafter(limit, kInf)};
    };
    const ShearedTriangle unit{1.0f, 0.0f, -0.5f, 1.0f, -0.5f, -1.0f};  // products 3, size 1
    const auto ask = [&](float determinant, float t, const Vec3& origin, float depth) {
        for (const float sign : {1.0f, -1.0f}) {
            const Crossing crossing{{}, sign * determinant, t};
            words.add(cut_changes_nothing(crossing, unit, origin * sign, depth * sign));
        }
    };
    for (const float reach : {1.0f, 0x1p30f}) {
        for (const Vec3& origin : {Vec3(reach, 0.0f, 0.0f), Vec3(0.0f, reach, 0.0f),
                                   Vec3(0.0f, 0.0f, reach), Vec3(0.0f)}) {
            const float depth = is_zero(origin) ? reach : 0.0f;
            for (const float d : around(0.375f / reach)) ask(d, 1.0f, origin, depth);
            for (const float t : around(0x1p-30f)) ask(1.0f, t, origin, depth);
            for (const float t : around(0x1p30f * reach)) ask(1.0f, t, origin, depth);
        }
    }
    for (const float reach : around(0x1p60f)) ask(1.0f, 1.0f, Vec3(reach, 1.0f, 1.0f), 0.0f);
    for (const float scale :
         {1.0f, 0x1p-38f, 0x1p-45f}) {  // of triangles: the smallest determinants
        for (const float d : around(0x1p-80f)) {
            const ShearedTriangle small{scale,         0.0f,           -0.5f * scale,
                                        scale * 1.25f, -0.75f * scale, -scale};
            words.add(cut_changes_nothing({{}, d, 1.0f}, small, Vec3(0x1p10f), 1.0f));
        }
    }
}

/// A walk below a node: what it finds, and how much it looks at on its way.
template <int Width>
void add_walks(Words& words, const Scene& scene, const std::vector<Ray>& rays) {
    std::mt19937 random(5);
    for (int i = 0; i < 100; ++i) {
        std::uint32_t keys[Width];
        for (std::uint32_t& key : keys) {
            const auto bits = static_cast<std::uint32_t>(random());
            key = bits % 4 == 0 ? kNone : (bits >> 2) % 8;  // many alike
        }
        sort_visits(keys);
        for (const std::uint32_t key : keys) words.add(key);
    }
    BvhParameters parameters;
    parameters.width = Width;
    parameters.max_leaf_size = 2;
    parameters.threads = 1;
    for (const std::uint32_t levels : {1u, 2u}) {
        parameters.queue_levels = levels;
        const WideBvh bvh = build_wide_bvh(scene, parameters);
        words.add(fingerprint(bvh));
        const WideBvhView<Width> view = view_of<Width>(bvh);
        for (const Ray& ray : rays) {
            for (const float limit : {kInf, 1.5f}) {
                for (const bool any : {false, true}) {
                    const SubtreeSearch found = closest_in_subtree(view, 0, ray, limit, any);
                    words.add(found.best.t, found.best.primitive, found.nodes, found.children,
                              found.triangles);
                }
            }
        }
    }
}

void add_all_walks(Words& words) {
    std::mt19937 random(6);
    const auto unit = [&] {
        return 2.0f * to_unit_interval(static_cast<std::uint32_t>(random())) - 1.0f;
    };
    const auto point = [&] { return Vec3(unit(), unit(), unit()); };
    Scene scene;
    for (std::uint32_t i = 0; i < 150; ++i) {
        const Vec3 at = point();
        for (int k = 0; k < 3; ++k) scene.vertices.push_back(at + point() * 0.3f);
        scene.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    std::vector<Ray> rays;
    for (int i = 0; i < 60; ++i) {
        const Vec3 from = point() * 2.0f;
        Vec3 to = point() * 0.5f - from;
        if (i % 6 == 0) to.x = 0.0f;
        if (i % 6 == 1) to.y = -0.0f;
        rays.push_back({from, i % 5 == 0 ? -0.0f : 0.01f, to, i % 4 == 0 ? 1.0f : kInf});
    }
    const float away = 1.0e26f;  // so far that slabs overflow
    for (const float sign : {-1.0f, 1.0f}) {
        rays.push_back({Vec3(sign * away), 0.0f, Vec3(-sign * 1.0e-15f), kInf});
    }
    for (const Ray& ray : rays) words.add(first_entry(ray));
    add_walks<2>(words, scene, rays);
    add_walks<4>(words, scene, rays);
    add_walks<8>(words, scene, rays);
    add_walks<16>(words, scene, rays);
}

Scene lit_scene() {
    Scene scene;
    scene.vertices = {Vec3(-1.0f, -1.0f, 0.0f), Vec3(1.0f, -1.0f, 0.25f), Vec3(0.0f, 1.0f, 3.0f)};
    scene.normals = {Vec3(0.0f, 0.0f, 1.0f), Vec3(0.6f, 0.0f, 0.8f), Vec3(0.0f, -0.6f, 0.8f)};
    scene.triangles = {{0, 1, 2}};
    scene.material_of = {0};
    scene.materials.resize(1);
    for (const LightKind kind : {LightKind::parallelogram, LightKind::triangle, LightKind::point,
                                 LightKind::spot, LightKind::directional, LightKind::hemisphere}) {
        Light light;
        light.kind = kind;
        light.position = Vec3(0.3f, 0.4f, 4.0f);
        light.normal = Vec3(0.0f, 0.0f, -1.0f);
        light.radiance = Vec3(1.0f, 0.5f, 0.25f);
        light.edge_x = Vec3(0.5f, 0.0f, 0.0f);
        light.edge_y = Vec3(0.0f, -0.7f, 0.0f);
        light.area = 0.35f;
        if (kind == LightKind::spot) set_spot_cone(light, {0.99f, 0.7f});
        scene.lights.push_back(light);
    }
    return scene;
}

/// Materials on both sides of what tells them apart.
std::vector<Material> materials() {
    std::vector<Material> all;
    for (std::uint32_t kind = 0; kind < 4; ++kind) {
        for (const float ior : {0.0f, 0.02f, kSharpRoughness, 0.3f, 1.0f, 1.5f}) {
            Material material;
            material.kind = static_cast<MaterialKind>(kind);
            material.ior = ior;
            material.reflectance = Vec3(0.9f, 0.5f, 0.1f);
            material.transmittance = Vec3(0.2f, 0.6f, 0.8f);
            material.emission = Vec3(3.0f, 2.0f, 1.0f);
            material.emission_is_sampled = kind % 2;
            all.push_back(material);
        }
    }
    return all;
}

void add_shading(Words& words) {
    Scene scene = lit_scene();
    PathParameters parameters;
    for (const Material& material : materials()) {
        words.add(is_smooth(material), is_sharp(material));
        scene.materials[0] = material;
        const SceneView view = view_of(scene);
        std::mt19937 random(3);
        const auto unit = [&] { return to_unit_interval(static_cast<std::uint32_t>(random())); };
        for (int i = 0; i < 60; ++i) {
            const Vec3 from(2.0f * unit() - 1.0f, 2.0f * unit() - 1.0f, i % 2 == 0 ? 6.0f : -6.0f);
            Hit hit{1.0f, 0, unit() * 0.5f, unit() * 0.5f};
            if (i % 7 == 3) hit = no_hit();
            const Ray ray{from, 0.0f, normalize_or(from * -1.0f, from), kInf};
            const Vec3 throughput(unit(), unit(), i % 11 == 0 ? 0.0f : unit());
            const Random4 numbers{unit(), unit(), unit(), unit()};
            parameters.roulette = static_cast<std::uint32_t>(i) % 3;
            parameters.light_samples = static_cast<std::uint32_t>(i) % 4;
            const auto bounce = static_cast<std::uint32_t>(i) % 4;
            for (const std::uint32_t flags : {0u, 1u, 2u, 3u}) {
                const Scattered next =
                    scatter(view, parameters, bounce, ray, hit, throughput, flags, numbers);
                words.add(next.ray);
                words.add(next.throughput, next.emitted, next.flags);
                words.add(counts_emission(bounce, flags, i % 2 == 0, parameters));
            }
            words.add(survival(parameters, bounce, throughput));
            parameters.light_samples = 2;
            const DirectLight direct =
                sample_direct_light(view, parameters, ray, hit, throughput, numbers);
            words.add(direct.shadow);
            words.add(direct.potential, distant_radiance(view, ray.direction));
            if (!is_hit(hit)) continue;
            const Surface surface = surface_at(view, ray, hit);
            words.add(surface.position, surface.geometric_normal, surface.shading_normal,
                      surface.front, surface.offset, surface.material);
            words.add(leave_surface(surface, ray.direction, 2.0f));
            for (const Light& light : scene.lights) {
                const LightSample sample = sample_light(light, surface, numbers.a, numbers.b);
                words.add(sample.direction, sample.distance, sample.irradiance);
            }
        }
    }
    for (const float cosine : {-1.0f, 0.0f, 0.5f, 0.6f, 0.75f, 0.9f, 1.0f}) {
        words.add(spot_falloff({0.9f, 0.5f}, cosine), spot_falloff({0.5f, 0.5f}, cosine));
    }
    Camera camera;
    for (const float half_width : {0.0f, 0.4f}) {
        camera.tan_half_width = half_width;
        words.add(vertical_tangent(camera, 9.0f, 7.0f));
    }
}

void add_sums(Words& words) {
    PixelSums sums;
    for (std::uint32_t i = 0; i < 5; ++i) {
        add_sample(sums, i,
                   Vec3(0.1f * static_cast<float>(i), 1.0f, 3.0f / (1.0f + static_cast<float>(i))));
        PixelSums mean = sums;
        finish(mean, i + 1);
        words.add(mean.image, mean.variance);
    }
}

/// Records before anything is said, whose readers rely on what they are then.
void add_defaults(Words& words) {
    const StageView stage;
    words.add(stage.kind, stage.launch, stage.batch, stage.bounce, stage.light, stage.level,
              stage.blocks, stage.threads);
    const BufferView buffer;
    words.add(buffer.type, buffer.bytes, buffer.data == nullptr);
    const LaunchRecord launch;
    words.add(launch.kind, launch.batch, launch.bounce, launch.light, launch.level, launch.blocks);
    const StagePlace place;
    words.add(place.batch, place.several_batches, place.bounce, place.light, place.level);
    const BvhParameters tree;
    words.add(tree.width, tree.max_leaf_size, tree.threads, tree.queue_levels);
    words.add(WideBvh().width);
    const SceneView scene;
    words.add(scene.triangle_count, scene.light_count, scene.environment, scene.hemisphere);
    const Bounds bounds;
    words.add(bounds.low, bounds.high);
    words.add(fingerprint(Scene()));
    words.add(fingerprint(lit_scene()));
    words.add(no_hit());
    words.add(dead_ray());
    words.add(is_dead(dead_ray()), is_dead(Ray{Vec3(0.0f), 1.0f, Vec3(1.0f), 1.0f}));
}

}  // namespace

std::uint64_t hash_of_numerics() {
    Words words;
    add_parity_cases(words);
    add_geometry(words);
    add_cuts(words);
    add_all_walks(words);
    add_shading(words);
    add_sums(words);
    add_defaults(words);
    return words.hash();
}

}  // namespace scotty::verify
