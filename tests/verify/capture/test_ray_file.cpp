#include <cmath>
#include <cstring>

#include "reference/truth/tracers.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/capture/ray_file.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

std::string words(std::initializer_list<std::uint32_t> values) {
    std::string out;
    for (const std::uint32_t value : values) {
        out.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    return out;
}

RayFile two_rays() {
    return {{{Vec3(0.0f, 1.0f, 3.0f), 0.0f, Vec3(0.0f, 0.0f, -1.0f), kInfinity},
             {Vec3(0.5f, 1.0f, 3.0f), 0.25f, Vec3(0.0f, 0.0f, -1.0f), 7.0f}},
            true};
}

TEST_CASE("ray file: rays are read as written, in the layout of the format", "[verify][rays]") {
    const TemporaryFolder folder;
    write_rays(folder / "a.ray", two_rays());
    const std::string bytes = slurp(folder / "a.ray");
    CHECK(bytes.size() == 12 + 2 * 32);
    CHECK(bytes.substr(0, 12) == "RAY1" + words({2, 1}));
    float t_max = 0.0f;
    std::memcpy(&t_max, bytes.data() + 12 + 32 + 28, 4);
    CHECK(t_max == 7.0f);
    const RayFile back = read_rays(folder / "a.ray");
    CHECK(back.any_hit);
    REQUIRE(back.rays.size() == 2);
    CHECK(std::memcmp(back.rays.data(), two_rays().rays.data(), 64) == 0);
}

TEST_CASE("ray file: a broken file is named with what was expected", "[verify][rays][errors]") {
    const TemporaryFolder folder;
    const auto file = folder / "a.ray";
    const auto error = [&] { return error_of([&] { read_rays(file); }); };
    CHECK_THAT(error(), ContainsSubstring("a.ray") && ContainsSubstring("cannot be read"));
    write_rays(file, two_rays());
    const std::string good = slurp(file);
    spill(file, good.substr(0, good.size() - 1));
    CHECK_THAT(error(), ContainsSubstring("expected 2 rays of 32 bytes = 64 bytes, found 63"));
    spill(file, good + "x");
    CHECK_THAT(error(), ContainsSubstring("found 65"));
    spill(file, good.substr(0, 6));
    CHECK_THAT(error(), ContainsSubstring("ends before its number of rays"));
    spill(file, "RA");
    CHECK_THAT(error(), ContainsSubstring("begins with 'RAY1'"));
    spill(file, "REF1" + good.substr(4));
    CHECK_THAT(error(), ContainsSubstring("found another kind of file"));
    spill(file, "RAY1" + words({0, 2}));
    CHECK_THAT(error(), ContainsSubstring("the any-hit flag: expected 0 or 1, found 2"));
    spill(file, "RAY1" + words({0xffffffffu, 0}));
    CHECK_THAT(error(), ContainsSubstring("expected 4294967295 rays"));
}

TEST_CASE("ray file: a ray that cannot be traced is named", "[verify][rays][errors]") {
    const TemporaryFolder folder;
    const auto error = [&](auto change) {
        RayFile rays = two_rays();
        change(rays.rays[1]);
        write_rays(folder / "a.ray", rays);
        return error_of([&] { read_rays(folder / "a.ray"); });
    };
    const float nan = std::nanf("");
    CHECK_THAT(error([&](Ray& r) { r.origin.x = nan; }),
               ContainsSubstring("a.ray: ray 1") && ContainsSubstring("origin is not finite"));
    CHECK_THAT(error([&](Ray& r) { r.direction.z = kInfinity; }), ContainsSubstring("direction"));
    CHECK_THAT(error([&](Ray& r) { r.direction = Vec3(0.0f); }),
               ContainsSubstring("direction is zero"));
    for (const float longest : {1e19f, 1.1e12f}) {
        CHECK_THAT(error([&](Ray& r) { r.direction = Vec3(0.1f, longest, -1.0f); }),
                   ContainsSubstring("a.ray: ray 1") && ContainsSubstring("direction is too long"));
    }
    for (const float longest : {1e-19f, 0.9e-12f, 1e-40f}) {
        CHECK_THAT(error([&](Ray& r) { r.direction = Vec3(0.0f, -longest, longest); }),
                   ContainsSubstring("direction is too short"));
    }
    CHECK_THAT(error([&](Ray& r) { r.origin.y = -1e30f; }),
               ContainsSubstring("origin is beyond 1e12"));
    CHECK_THAT(error([&](Ray& r) { r.t_min = -1.0f; }), ContainsSubstring("t_min is negative"));
    CHECK_THAT(error([&](Ray& r) { r.t_max = nan; }), ContainsSubstring("t_max is NaN"));
    CHECK(error([](Ray& r) { r.t_max = -1.0f; }) == "(no error)");  // a dead ray
}

TEST_CASE("ray file: rays at the limits of what is read hit what ordinary ones do, with Embree too",
          "[verify][rays]") {
    const Scene scene = scenes::load_scene("spheres");
    const EmbreeTracer embree(scene);
    std::vector<Hit> ordinary;
    for (const float scale : {1.0f, 1e-12f, 1e-6f, 1e6f, 1e12f}) {
        const TemporaryFolder folder;
        RayFile file;
        for (int i = 0; i < 200; ++i) {
            const float x = 0.0025f * static_cast<float>(i) - 0.25f;
            Vec3 direction =
                scene.camera.forward + scene.camera.up * (0.3f * x) + scene.camera.right * x;
            direction = direction * (1.0f / max_abs(direction));
            file.rays.push_back({scene.camera.position, 0.0f, direction * scale, kInfinity});
        }
        write_rays(folder / "a.ray", file);
        const RayFile read = read_rays(folder / "a.ray");
        std::vector<Hit> ours(read.rays.size());
        std::vector<Hit> theirs(read.rays.size());
        brute_force_closest(scene, read.rays, ours);
        embree.closest(read.rays, theirs);
        if (ordinary.empty()) ordinary = ours;
        for (std::size_t i = 0; i < ours.size(); ++i) {
            INFO("scale " << scale << ", ray " << i);
            REQUIRE(is_hit(ours[i]));
            CHECK(ours[i].primitive == ordinary[i].primitive);
            CHECK(theirs[i].primitive == ordinary[i].primitive);
            CHECK(ours[i].t * scale == Approx(ordinary[i].t).epsilon(1e-4));
            CHECK(theirs[i].t * scale == Approx(ordinary[i].t).epsilon(1e-4));
        }
    }
}

TEST_CASE("ray file: reference hits, one a ray", "[verify][rays][errors]") {
    const TemporaryFolder folder;
    const auto file = folder / "a.ref";
    spill(file, "REF1" + words({2, 0x3f800000u, 7, 0x7f800000u, 0xffffffffu}));
    const auto hits = read_reference(file, 2);
    CHECK(hits[0].t == 1.0f);
    CHECK(hits[0].primitive == 7);
    CHECK(hits[1].t == kInfinity);
    CHECK(hits[1].primitive == kNone);
    CHECK_THAT(error_of([&] { read_reference(file, 3); }),
               ContainsSubstring("expected 3 hits, one a ray, found 2"));
    spill(file, "REF1" + words({2, 0, 0}));
    CHECK_THAT(error_of([&] { read_reference(file, 2); }), ContainsSubstring("cut short"));

    write_hits(folder / "a.hit", hits);
    CHECK(slurp(folder / "a.hit") == words({0x3f800000u, 7, 0x7f800000u, 0xffffffffu}));
    CHECK(read_hits(folder / "a.hit").size() == 2);
    spill(folder / "a.hit", "12345");
    CHECK_THAT(error_of([&] { read_hits(folder / "a.hit"); }), ContainsSubstring("found 5 bytes"));
    CHECK_THAT(error_of([&] { write_hits(folder / "no" / "a.hit", hits); }),
               ContainsSubstring("cannot be written"));
}

TEST_CASE("ray file: any-hit answers have t 0 and primitive 1 or 0", "[verify][rays]") {
    CHECK(hit_record({2.0f, 9, 0.1f, 0.2f}, true).primitive == 1);
    CHECK(hit_record({2.0f, 9, 0.1f, 0.2f}, true).t == 0.0f);
    CHECK(hit_record(no_hit(), true).primitive == 0);
    CHECK(hit_record({2.0f, 9, 0.1f, 0.2f}, false).primitive == 9);
    CHECK(hit_record(no_hit(), false).t == kInfinity);
}

TEST_CASE("ray file: a scene of triangles is read and validated", "[verify][rays][errors]") {
    const TemporaryFolder folder;
    const auto file = folder / "one.scn";
    const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::string vertices(reinterpret_cast<const char*>(corners), sizeof corners);
    spill(file, "SCN1" + words({3, 1}) + vertices + words({0, 1, 2}));
    const Scene scene = read_scene_file(file);
    CHECK(scene.name == "one.scn");
    CHECK(scene.triangles.size() == 1);
    CHECK(scene.vertices[1].x == 1.0f);
    CHECK(scene.materials.size() == 1);
    spill(file, "SCN1" + words({3, 1}) + vertices + words({0, 1, 3}));
    CHECK_THAT(error_of([&] { read_scene_file(file); }), ContainsSubstring("one.scn"));
    spill(file, "SCN1" + words({3, 1}) + vertices + words({0, 1}));
    CHECK_THAT(error_of([&] { read_scene_file(file); }),
               ContainsSubstring("expected 1 triangles of 12 bytes = 12 bytes, found 8"));
    spill(file, "SCN1" + words({4, 1}) + vertices);
    CHECK_THAT(error_of([&] { read_scene_file(file); }), ContainsSubstring("expected 4 vertices"));
}

}  // namespace
