#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <variant>
#include <vector>
#include "tests/properties.h"

#include "reference/contract/wide_bvh.h"
#include "reference/numerics/intersect_box.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/reference/hard_cases.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

/// A box around `inner`: the same, one that shares faces, a larger one or a huge one.
Box enclosing(Random& random, const Box& inner) {
    const Vec3 size = inner.high - inner.low;
    const float grow = random() % 4 == 0 ? 1000.0f : 1.0f;
    const Vec3 below = inner.low - grow * (size * uniform(random, 0, 1));
    const Vec3 above = inner.high + grow * (size * uniform(random, 0, 1));
    Box box = united(inner, {below, above});
    for (int axis = 0; axis < 3; ++axis) {
        if (random() % 3 == 0) box.low[axis] = inner.low[axis];
        if (random() % 3 == 0) box.high[axis] = inner.high[axis];
    }
    return box;
}

RaySlabs slabs_of(const Ray& ray, const Box& node) {
    return ray_slabs(ray.origin, safe_inverse(ray.direction),
                     box_pad(ray.origin, node.low, node.high));
}

bool hit_line(const Ray& ray, const Triangle& t, Hit& hit) {
    return intersect_triangle_line(ray.origin, safe_inverse(ray.direction),
                                   ray_shear(ray.direction), t.v0, t.v1, t.v2, hit);
}

}  // namespace

TEST_CASE("box: entry and exit are monotone in the box and in the node that pads it, exactly",
          "[reference][box]") {
    Random random(1);
    int checked = 0;
    for (int i = 0; i < 200000; ++i) {
        const Triangle triangle = hard_triangle(random);
        const Ray ray = hard_ray(random, triangle);
        const Box inner = triangle.box();
        const Box outer = enclosing(random, inner);
        const Box inner_node = enclosing(random, inner);
        const Box outer_node = united(outer, enclosing(random, inner_node));
        const BoxInterval small = intersect_box(slabs_of(ray, inner_node), inner.low, inner.high);
        const BoxInterval large = intersect_box(slabs_of(ray, outer_node), outer.low, outer.high);
        if (!(large.entry <= small.entry && large.exit >= small.exit)) FAIL_CHECK("case " << i);
        ++checked;
    }
    CHECK(checked == 200000);
}

TEST_CASE("box: a triangle's hit lies within every box around it, exactly", "[reference][box]") {
    Random random(2);
    int hits = 0;
    for (int i = 0; i < 400000; ++i) {
        const Triangle triangle = hard_triangle(random);
        Ray ray = hard_ray(random, triangle);
        Hit hit = no_hit();
        if (!hit_line(ray, triangle, hit)) continue;
        ++hits;
        const Box child = enclosing(random, triangle.box());
        const Box node = enclosing(random, child);
        const BoxInterval line = intersect_box(slabs_of(ray, node), child.low, child.high);
        if (!(line.entry <= hit.t && hit.t <= line.exit)) FAIL_CHECK("case " << i);
        if (!(hit.t >= 0.0f)) continue;
        ray.t_min = random() % 2 == 0 ? 0.0f : hit.t;
        ray.t_max = random() % 2 == 0 ? kInfinity : std::nextafter(hit.t, kInfinity);
        if (!(hit.t < ray.t_max)) continue;
        const BoxInterval cut = clip(line, ray.t_min, ray.t_max);
        if (!(overlaps(cut) && cut.entry <= hit.t)) FAIL_CHECK("case " << i << ", cut");
    }
    CHECK(hits > 50000);
}

TEST_CASE("box: no box around a triangle is missed by a ray that double precision sees hit it",
          "[reference][box]") {
    // The conservative half: rays from outside at points well inside well-shaped triangles.
    Random random(3);
    for (int i = 0; i < 100000; ++i) {
        const float scale = random_scale(random);
        const Triangle triangle{scale * uniform3(random, -1, 1), scale * uniform3(random, -1, 1),
                                scale * uniform3(random, -1, 1)};
        const Box box = triangle.box();
        const Vec3 target = (triangle.v0 + triangle.v1 + triangle.v2) / 3.0f;
        const Vec3 direction = unit_vector(random);
        const Ray ray{target - (5.0f * scale) * direction, 0.0f, direction, kInfinity};
        if (!overlaps(
                clip(intersect_box(slabs_of(ray, box), box.low, box.high), ray.t_min, ray.t_max))) {
            FAIL_CHECK("case " << i);
        }
    }
}

TEST_CASE("box: a ray in a face of the box is inside, whatever the sign of its zeros",
          "[reference][box]") {
    const Box box{{1, 2, 3}, {4, 5, 6}};
    for (int axis = 0; axis < 3; ++axis) {
        for (const float face : {box.low[(axis + 1) % 3], box.high[(axis + 1) % 3]}) {
            for (const float zero : {0.0f, -0.0f}) {
                for (const float sign : {1.0f, -1.0f}) {
                    Vec3 direction(zero);
                    direction[axis] = sign;
                    Vec3 origin = 0.5f * (box.low + box.high) - 10.0f * direction;
                    origin[(axis + 1) % 3] = face;
                    const Ray ray{origin, 0.0f, direction, kInfinity};
                    const BoxInterval interval =
                        clip(intersect_box(slabs_of(ray, box), box.low, box.high), 0.0f, kInfinity);
                    CHECK(overlaps(interval));
                    CHECK(interval.entry == Approx(8.5f));
                    CHECK(interval.exit == Approx(11.5f));
                    // And just beyond the face (by more than the pad), it is outside.
                    Ray beside = ray;
                    beside.origin[(axis + 1) % 3] = face < 3.4f + static_cast<float>((axis + 1) % 3)
                                                        ? face - 1.0e-3f
                                                        : face + 1.0e-3f;
                    CHECK_FALSE(overlaps(clip(
                        intersect_box(slabs_of(beside, box), box.low, box.high), 0.0f, kInfinity)));
                }
            }
        }
    }
}

TEST_CASE("box: flat boxes are hit, missing children never are", "[reference][box]") {
    const Box flat{{0, 0, 2}, {1, 1, 2}};
    const Box missing{Vec3(kInfinity), Vec3(-kInfinity)};
    Random random(4);
    const Ray ray{Vec3(0.5f, 0.5f, 0), 0.0f, Vec3(0, 0, 1), kInfinity};
    CHECK(overlaps(clip(intersect_box(slabs_of(ray, flat), flat.low, flat.high), 0.0f, kInfinity)));
    for (int i = 0; i < 10000; ++i) {
        const Triangle triangle = hard_triangle(random);
        const Ray hard = hard_ray(random, triangle);
        if (max_abs(hard.origin) > kMaxCoordinate) continue;  // farther out than scenes may be
        const RaySlabs slabs = slabs_of(hard, triangle.box());
        CHECK_FALSE(
            overlaps(clip(intersect_box(slabs, missing.low, missing.high), 0.0f, kInfinity)));
    }
}

TEST_CASE("box: what is not a number never overlaps", "[reference][box]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_FALSE(overlaps({nan, 1.0f}));
    CHECK_FALSE(overlaps({0.0f, nan}));
    CHECK_FALSE(overlaps({nan, nan}));
}

TEST_CASE("triangle: signs of edge functions are those of whole-number arithmetic",
          "[reference][triangle]") {
    scotty::tests::check_property(
        "sheared vertices are whole numbers times a power of two", [](std::uint32_t seed) {
            Random random(seed);
            const int bits = 1 + static_cast<int>(random() % 24);
            // The smallest are denormal; products of the largest are not finite three at a time.
            const int exponent = static_cast<int>(random() % 170) - 149;
            std::array<std::int64_t, 6> n;
            for (std::int64_t& value : n) {
                value =
                    static_cast<std::int64_t>(random() % (2u << bits)) - (std::int64_t{1} << bits);
            }
            if (random() % 3 == 0) n[2] = n[0];
            if (random() % 3 == 0) n[3] = n[1];
            if (random() % 4 == 0) n[4] = -n[0], n[5] = -n[1];
            std::array<float, 6> f;
            for (int i = 0; i < 6; ++i) f[i] = std::ldexp(static_cast<float>(n[i]), exponent);
            const ShearedTriangle sheared{f[0], f[1], f[2], f[3], f[4], f[5]};
            const auto sign = [](std::int64_t value) { return (value > 0) - (value < 0); };
            const std::array<int, 3> signs{sign(n[4] * n[3] - n[5] * n[2]),
                                           sign(n[0] * n[5] - n[1] * n[4]),
                                           sign(n[2] * n[1] - n[3] * n[0])};
            const bool inside = !(std::count(signs.begin(), signs.end(), 1) > 0 &&
                                  std::count(signs.begin(), signs.end(), -1) > 0);
            EdgeFunctions e{};
            const bool found = signed_edges(sheared, e);
            if (inside) RC_ASSERT(found);  // no crossing is ever lost
            // An area below the smallest float counts as zero.
            if (2 * exponent >= -149) {
                RC_ASSERT(found == inside);
                if (found) {
                    RC_ASSERT(signs ==
                              (std::array<int, 3>{(e.u > 0) - (e.u < 0), (e.v > 0) - (e.v < 0),
                                                  (e.w > 0) - (e.w < 0)}));
                }
            }
        });
}

TEST_CASE("triangle: nothing that is not a number is a hit", "[reference][triangle]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Triangle good{{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}};
    const Ray ray{Vec3(0.0f), 0.0f, Vec3(0, 0, 1), kInfinity};
    const auto hits = [](const Ray& r, const Triangle& t) {
        Hit hit = no_hit();
        return intersect_triangle(r, safe_inverse(r.direction), ray_shear(r.direction), t.v0, t.v1,
                                  t.v2, hit);
    };
    REQUIRE(hits(ray, good));
    for (int axis = 0; axis < 3; ++axis) {
        Ray bad = ray;
        bad.origin[axis] = nan;
        CHECK_FALSE(hits(bad, good));
        bad = ray;
        bad.direction[axis] = nan;
        CHECK_FALSE(hits(bad, good));
        Triangle bad_triangle = good;
        bad_triangle.v1[axis] = nan;
        CHECK_FALSE(hits(ray, bad_triangle));
    }
    Ray bad = ray;
    bad.t_min = nan;
    CHECK_FALSE(hits(bad, good));
    bad = ray;
    bad.t_max = nan;
    CHECK_FALSE(hits(bad, good));
    bad = ray;
    bad.direction = Vec3(0.0f);
    CHECK_FALSE(hits(bad, good));
}

TEST_CASE("triangle: a hit holds t_min and does not hold t_max", "[reference][triangle]") {
    scotty::tests::check_property("half-open interval", [] {
        Random random(*rc::gen::arbitrary<std::uint32_t>());
        const Triangle t{uniform3(random, -1, 1), uniform3(random, -1, 1), uniform3(random, -1, 1)};
        const Vec3 origin = uniform3(random, -3, 3);
        Ray ray{origin, 0.0f, (t.v0 + t.v1 + t.v2) / 3.0f - origin, kInfinity};
        Hit hit = no_hit();
        RC_PRE(hit_line(ray, t, hit));
        const auto hits = [&](float t_min, float t_max) {
            ray.t_min = t_min;
            ray.t_max = t_max;
            Hit out = no_hit();
            return intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                                      t.v0, t.v1, t.v2, out);
        };
        RC_ASSERT(hits(0.0f, kInfinity));
        RC_ASSERT(hits(hit.t, kInfinity));
        RC_ASSERT(!hits(0.0f, hit.t));
        RC_ASSERT(!hits(std::nextafter(hit.t, kInfinity), kInfinity));
    });
}

TEST_CASE("triangle: distance and barycentrics say where the hit is", "[reference][triangle]") {
    scotty::tests::check_property("o + t d = (1 - u - v) v0 + u v1 + v v2, at every scale", [] {
        Random random(*rc::gen::arbitrary<std::uint32_t>());
        const float scale = *rc::gen::element(0.01f, 1.0f, 100.0f, 1.0e6f);
        const Triangle t{scale * Vec3(-1, -1, uniform(random, -0.5f, 0.5f)),
                         scale * Vec3(1, -1, uniform(random, -0.5f, 0.5f)),
                         scale * Vec3(0, 1, uniform(random, -0.5f, 0.5f))};
        const Vec3 origin = scale * uniform3(random, -3, 3);
        const Vec3 target = (t.v0 + t.v1 + t.v2) / 3.0f + scale * uniform3(random, -0.05f, 0.05f);
        const Ray ray{origin, 0.0f, normalize_or(target - origin, Vec3(0, 0, 1)), kInfinity};
        RC_PRE(abs_of(ray.direction.z) > 0.5f);
        Hit hit = no_hit();
        RC_ASSERT(hit_line(ray, t, hit));
        const Vec3 along = ray.origin + hit.t * ray.direction;
        const Vec3 inside = (1.0f - hit.u - hit.v) * t.v0 + hit.u * t.v1 + hit.v * t.v2;
        RC_ASSERT(max_abs(along - inside) < 3.0e-5f * scale);
    });
}

TEST_CASE("triangle: scaling a scene by a power of two scales t and nothing else",
          "[reference][triangle]") {
    Random random(5);
    for (int i = 0; i < 10000; ++i) {
        const Triangle t{uniform3(random, -1, 1), uniform3(random, -1, 1), uniform3(random, -1, 1)};
        const Ray ray{uniform3(random, -2, 2), 0.0f, unit_vector(random), kInfinity};
        const float scale = i % 2 == 0 ? 0.0078125f : 128.0f;
        const Triangle scaled{scale * t.v0, scale * t.v1, scale * t.v2};
        Ray scaled_ray = ray;
        scaled_ray.origin *= scale;
        Hit hit = no_hit();
        Hit scaled_hit = no_hit();
        const bool is = hit_line(ray, t, hit);
        REQUIRE(is == hit_line(scaled_ray, scaled, scaled_hit));
        if (!is) continue;
        CHECK(scaled_hit.t == scale * hit.t);
        CHECK(scaled_hit.u == hit.u);
        CHECK(scaled_hit.v == hit.v);
    }
}

namespace {

/// Rays from inside a closed, convex mesh, exactly at its vertices and edges: all must hit.
void check_no_leaks(const Scene& scene, const Vec3& centre, float radius, std::uint32_t seed) {
    Random random(seed);
    std::vector<Ray> rays;
    for (const auto& triangle : scene.triangles) {
        const Vec3& a = scene.vertices[triangle[0]];
        const Vec3& b = scene.vertices[triangle[1]];
        for (const Vec3& target : {a, 0.5f * (a + b), a + uniform(random, 0, 1) * (b - a)}) {
            for (int k = 0; k < 4; ++k) {
                Vec3 origin = centre;
                if (k != 0) origin += uniform3(random, -0.4f, 0.4f) * radius;
                Vec3 direction = target - origin;
                if (k % 2 == 0) direction = normalize_or(direction, Vec3(0, 0, 1));
                rays.push_back({origin, 0.0f, direction, kInfinity});
            }
        }
    }
    std::vector<Hit> hits(rays.size());
    brute_force_closest(scene, rays, hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (!is_hit(hits[i])) FAIL_CHECK(scene.name << ": ray " << i << " leaks");
    }
}

}  // namespace

TEST_CASE("triangle: closed meshes do not leak at their vertices and edges",
          "[reference][triangle]") {
    for (const float radius : {0.01f, 1.0f, 100.0f, 1.0e8f}) {
        for (int subdivisions = 0; subdivisions < 4; ++subdivisions) {
            check_no_leaks(icosphere(subdivisions, radius), Vec3(0.0f), radius, 6);
        }
    }
    const Vec3 far(1000, -500, 250);
    check_no_leaks(icosphere(3, 1.0f, far), far, 1.0f, 7);
}

TEST_CASE("triangle: a mesh of integer coordinates does not leak along axes and diagonals",
          "[reference][triangle]") {
    // A cube of 6 x 2 n^2 triangles around the origin: every ray meets edges and vertices exactly.
    Scene cube;
    cube.name = "cube";
    constexpr int kN = 4;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            for (int y = -kN; y < kN; ++y) {
                for (int x = -kN; x < kN; ++x) {
                    const auto corner = [&](int dx, int dy) {
                        Vec3 v;
                        v[axis] = side * kN;
                        v[(axis + 1) % 3] = static_cast<float>(x + dx);
                        v[(axis + 2) % 3] = static_cast<float>(y + dy);
                        return v;
                    };
                    add_triangle(cube, corner(0, 0), corner(1, 0), corner(1, 1));
                    add_triangle(cube, corner(0, 0), corner(1, 1), corner(0, 1));
                }
            }
        }
    }
    std::vector<Ray> rays;
    for (int x = -kN; x <= kN; ++x) {
        for (int y = -kN; y <= kN; ++y) {
            for (int z = -kN; z <= kN; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                const Vec3 direction(static_cast<float>(x), static_cast<float>(y),
                                     static_cast<float>(z));
                rays.push_back({Vec3(0.0f), 0.0f, direction, kInfinity});
                rays.push_back({Vec3(1, 0, -1), 0.0f, -direction, kInfinity});
            }
        }
    }
    std::vector<Hit> hits(rays.size());
    brute_force_closest(cube, rays, hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (!is_hit(hits[i])) FAIL_CHECK("ray " << i << " leaks");
    }
}

namespace {

/// Depth-first traversal, as short as can be: what every pipeline must agree with.
template <int Width>
void visit(const WideBvhView<Width>& bvh, std::uint32_t id, const Ray& ray, const Vec3& inverse,
           const RayShear& shear, Hit& best) {
    const std::uint32_t index = ref_index(bvh.node_refs[id]);
    if (is_leaf(bvh.node_refs[id])) {
        for (std::uint32_t k = 0; k < bvh.leaves[index].count; ++k) {
            const LeafTriangle& t = bvh.triangles[bvh.leaves[index].first + k];
            Hit hit = no_hit();
            if (intersect_triangle(ray, inverse, shear, t.v0, t.v1, t.v2, hit) &&
                closer(hit.t, t.primitive, best.t, best.primitive)) {
                best = {hit.t, t.primitive, hit.u, hit.v};
            }
        }
        return;
    }
    const WideNode<Width>& node = bvh.inner[index];
    const Box own{{node.low[0], node.low[1], node.low[2]},
                  {node.high[0], node.high[1], node.high[2]}};
    const RaySlabs slabs = ray_slabs(ray.origin, inverse, box_pad(ray.origin, own.low, own.high));
    for (int i = 0; i < Width; ++i) {
        if (node.child[i] == kNone) continue;
        const BoxInterval interval =
            clip(intersect_box(slabs, {node.low_x[i], node.low_y[i], node.low_z[i]},
                               {node.high_x[i], node.high_y[i], node.high_z[i]}),
                 ray.t_min, ray.t_max);
        // Culled by the best so far: a later entry cannot hold a nearer hit, nor an equal one.
        if (overlaps(interval) && interval.entry <= best.t) {
            visit(bvh, node.child[i], ray, inverse, shear, best);
        }
    }
}

template <int Width>
void check_traversal(const Scene& scene, const std::vector<Ray>& rays) {
    BvhParameters parameters;
    parameters.width = Width;
    parameters.max_leaf_size = 3;
    const WideBvh bvh = build_wide_bvh(scene, parameters);
    const WideBvhView<Width> view = view_of<Width>(bvh);
    std::vector<Hit> expected(rays.size());
    brute_force_closest(scene, rays, expected);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        Hit hit = no_hit();
        visit(view, 0, rays[i], safe_inverse(rays[i].direction), ray_shear(rays[i].direction), hit);
        if (std::memcmp(&hit, &expected[i], sizeof hit) != 0) {
            FAIL_CHECK(scene.name << ", width " << Width << ", ray " << i << ": t " << hit.t
                                  << " primitive " << hit.primitive << ", brute force t "
                                  << expected[i].t << " primitive " << expected[i].primitive);
        }
    }
}

}  // namespace

TEST_CASE("traversal: gives brute force's bits, also where triangles and rays are degenerate",
          "[reference][traversal]") {
    Random random(8);
    for (std::uint32_t kind = 0; kind < kHardScenes; ++kind) {
        const Scene hard = hard_scene(static_cast<HardScene>(kind), 400, random);
        const std::vector<Ray> rays = hard_rays(hard, 3000, random);
        check_traversal<2>(hard, rays);
        check_traversal<4>(hard, rays);
        check_traversal<8>(hard, rays);
        check_traversal<16>(hard, rays);
    }

    const Scene sphere = icosphere(3);
    std::vector<Ray> rays = random_rays(4000, 1.5f, 9);
    for (std::size_t i = 0; i < rays.size(); i += 2) {
        rays[i].direction = sphere.vertices[i % sphere.vertices.size()] - rays[i].origin;
    }
    check_traversal<8>(sphere, rays);
    check_traversal<16>(soup(500, 0.5f, 10), rays);
}

TEST_CASE("triangle: where the cut to the box is said to change nothing, it changes nothing",
          "[reference][triangle]") {
    Random random(11);
    int said = 0;
    int crossed = 0;
    int ordinary_crossed = 0;
    int ordinary_said = 0;
    for (int i = 0; i < 400000; ++i) {
        const bool ordinary = i % 2 == 0;
        Triangle t = hard_triangle(random);
        Ray ray = hard_ray(random, t);
        if (ordinary) {
            const Vec3 centre = uniform3(random, -1.0f, 1.0f);
            t = {centre + uniform3(random, -0.3f, 0.3f), centre + uniform3(random, -0.3f, 0.3f),
                 centre};
            ray = {uniform3(random, -2.0f, 2.0f), 0.0f, Vec3(0.0f), kInfinity};
            ray.direction = normalize_or((t.v0 + t.v1 + t.v2) / 3.0f - ray.origin, Vec3(1.0f));
        }
        if (i % 4 >= 2) {  // all magnitudes
            const float scale = std::ldexp(1.0f, static_cast<int>(random() % 76) - 38);
            t = {t.v0 * scale, t.v1 * scale, t.v2 * scale};
            ray.origin *= scale;
            ray.direction *= std::ldexp(1.0f, static_cast<int>(random() % 160) - 80);
        }
        const RayShear shear_of_ray = ray_shear(ray.direction);
        const Vec3 a = swap_axes(t.v0 - ray.origin, shear_of_ray.kz);
        const Vec3 b = swap_axes(t.v1 - ray.origin, shear_of_ray.kz);
        const Vec3 c = swap_axes(t.v2 - ray.origin, shear_of_ray.kz);
        Crossing crossing;
        if (!crosses(shear_of_ray, a, b, c, crossing)) continue;
        ++crossed;
        ordinary_crossed += ordinary && i % 4 < 2;
        const Vec3 origin = swap_axes(ray.origin, shear_of_ray.kz);
        if (!cut_changes_nothing(crossing, shear(shear_of_ray, a, b, c), origin, a.z)) continue;
        ++said;
        ordinary_said += ordinary && i % 4 < 2;
        const CutDistance cut = cut_distance(crossing.t, ray.origin, safe_inverse(ray.direction),
                                             min_number(min_number(t.v0, t.v1), t.v2),
                                             max_number(max_number(t.v0, t.v1), t.v2));
        CAPTURE(i, crossing.t, cut.t);
        CHECK(cut.inside);
        CHECK(bits_of(cut.t) == bits_of(crossing.t));
    }
    CHECK(crossed > 50000);
    CHECK(said > 20000);
    CHECK(ordinary_said > ordinary_crossed * 95 / 100);
}
