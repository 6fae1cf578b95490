/// Rays from files: our hits against another tracer's; and the commands of captures as a user runs
/// them.
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/capture/ray_file.h"
#include "verify/oracles/ray_compare.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

/// Two parallel triangles at z = 0 and z = -1 that face +z.
Scene two_triangles() {
    Scene scene;
    scene.name = "two triangles";
    for (const float z : {0.0f, -1.0f}) {
        const auto first = static_cast<std::uint32_t>(scene.vertices.size());
        scene.vertices.insert(scene.vertices.end(),
                              {Vec3(-1, -1, z), Vec3(1, -1, z), Vec3(0, 1, z)});
        scene.triangles.push_back({first, first + 1, first + 2});
        scene.material_of.push_back(0);
    }
    scene.materials.emplace_back();
    validate_and_repair(scene);
    return scene;
}

RayFile rays_down(bool any_hit = false) {
    const Vec3 down(0.0f, 0.0f, -1.0f);
    return {{{Vec3(0.0f, 0.0f, 1.0f), 0.0f, down, kInfinity},
             {Vec3(0.1f, 0.0f, 1.0f), 0.0f, down, kInfinity},
             {Vec3(5.0f, 0.0f, 1.0f), 0.0f, down, kInfinity}},
            any_hit};
}

const std::vector<HitCandidate> kRight{{1.0f, 0}, {1.0f, 0}, {kInfinity, kNone}};

TEST_CASE("trace: equal hits agree", "[verify][trace]") {
    const HitComparison c = compare_hits(two_triangles(), rays_down(), kRight, kRight);
    CHECK(c.passed());
    CHECK(c.rays == 3);
    CHECK(c.agree == 3);
    CHECK(c.mismatches.empty());
    CHECK_THAT(to_text(c), ContainsSubstring("passed: 3 rays; 3 agree"));
}

TEST_CASE("trace: a hit of ours that is wrong fails and is named with its ray", "[verify][trace]") {
    std::vector<HitCandidate> ours = kRight;
    SECTION("the farther triangle") { ours[1] = {2.0f, 1}; }
    SECTION("nothing") { ours[1] = {kInfinity, kNone}; }
    SECTION("the right triangle at a wrong distance") { ours[1].t = 1.01f; }
    const HitComparison c = compare_hits(two_triangles(), rays_down(), ours, kRight);
    CHECK_FALSE(c.passed());
    CHECK(c.ours_wrong == 1);
    CHECK(c.agree == 2);
    REQUIRE(c.mismatches.size() == 1);
    CHECK(c.mismatches[0].ray == 1);
    CHECK_THAT(to_text(c), ContainsSubstring("FAILED") && ContainsSubstring("ray 1: ours") &&
                               ContainsSubstring("ours wrong"));
}

TEST_CASE("trace: a reference that is wrong is said to be, and does not fail us",
          "[verify][trace]") {
    std::vector<HitCandidate> theirs = kRight;
    theirs[0] = {2.0f, 1};
    const HitComparison c = compare_hits(two_triangles(), rays_down(), kRight, theirs);
    CHECK(c.passed());
    CHECK(c.theirs_wrong == 1);
    CHECK_THAT(to_text(c), ContainsSubstring("theirs wrong"));
}

TEST_CASE("trace: of any-hit rays the answers are compared", "[verify][trace]") {
    const std::vector<HitCandidate> right{{0.0f, 1}, {0.0f, 1}, {0.0f, 0}};
    CHECK(compare_hits(two_triangles(), rays_down(true), right, right).agree == 3);
    std::vector<HitCandidate> ours = right;
    ours[2].primitive = 1;
    const HitComparison c = compare_hits(two_triangles(), rays_down(true), ours, right);
    CHECK(c.ours_wrong == 1);
    CHECK_THAT(to_text(c), ContainsSubstring("ray 2: ours occluded, theirs free"));
}

struct Result {
    int exit_code = -1;
    std::string out, err;
};

/// `scotty` lies beside this test program.
Result scotty_command(const TemporaryFolder& folder, const std::string& arguments) {
    const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "scotty";
    REQUIRE(std::filesystem::exists(program));
    const std::string command = "cd '" + folder.path().string() + "' && '" + program.string() +
                                "' " + arguments + " >out 2>err";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(folder / "out"),
            slurp(folder / "err")};
}

TEST_CASE("command: trace reads rays, writes hits and compares them", "[verify][trace][cli]") {
    const TemporaryFolder folder;
    RayFile rays;
    for (int i = 0; i < 200; ++i) {
        const float x = -0.9f + 0.009f * static_cast<float>(i);
        rays.rays.push_back({Vec3(x, 1.0f, 3.0f), 0.0f, Vec3(0.0f, -0.1f, -1.0f), kInfinity});
    }
    const bool any = GENERATE(false, true);
    rays.any_hit = any;
    write_rays(folder / "a.ray", rays);
    const Result embree =
        scotty_command(folder, "trace --scene spheres --rays a.ray -o embree.hit --backend embree");
    CHECK(embree.exit_code == 0);
    const auto expected = read_hits(folder / "embree.hit");
    REQUIRE(expected.size() == 200);
    const std::uint32_t count = 200;
    spill(folder / "a.ref", "REF1" + std::string(reinterpret_cast<const char*>(&count), 4) +
                                slurp(folder / "embree.hit"));
    const Result ours = scotty_command(
        folder, "trace --scene spheres --rays a.ray -o ours.hit --compare a.ref --width 4");
    CHECK(ours.exit_code == 0);
    CHECK_THAT(ours.out, ContainsSubstring("passed: 200 rays"));
    CHECK(read_hits(folder / "ours.hit").size() == 200);

    std::string wrong = slurp(folder / "a.ref");
    for (std::size_t i = 0; i < 200; ++i) {
        const HitCandidate nothing = any ? HitCandidate{0.0f, 0} : HitCandidate{kInfinity, kNone};
        std::memcpy(wrong.data() + 8 + 8 * i, &nothing, 8);
    }
    spill(folder / "a.ref", wrong);
    const Result theirs =
        scotty_command(folder, "trace --scene spheres --rays a.ray --compare a.ref");
    CHECK(theirs.exit_code == 0);
    CHECK_THAT(theirs.out, ContainsSubstring("theirs wrong"));

    spill(folder / "a.ray", slurp(folder / "a.ray").substr(0, 100));
    const Result broken = scotty_command(folder, "trace --scene spheres --rays a.ray");
    CHECK(broken.exit_code == 2);
    CHECK_THAT(broken.err, ContainsSubstring("a.ray") && ContainsSubstring("cut short"));
}

TEST_CASE("command: capture, diff and replay have their exit codes", "[verify][capture][cli]") {
    const TemporaryFolder folder;
    const std::string small = " --size 9x5 --spp 1 --bounces 1 --light-samples 1 --threads 1";
    CHECK(scotty_command(folder, "capture spheres -o a" + small).exit_code == 0);
    CHECK(scotty_command(folder, "capture spheres -o b --hit-capacity 3" + small).exit_code == 0);

    const Result same = scotty_command(folder, "diff a b");
    CHECK(same.exit_code == 0);
    CHECK_THAT(same.out, ContainsSubstring("passed:") && ContainsSubstring("merge_intersections"));
    CHECK(scotty_command(folder, "diff a").exit_code == 0);
    CHECK(scotty_command(folder, "diff a --isolated --backend emulator").exit_code == 0);
    const Result json = scotty_command(folder, "diff a b --json");
    CHECK(nlohmann::json::parse(json.out)["passed"] == true);
    CHECK(scotty_command(folder, "replay a --stage bounce0/level0/intersect_root").exit_code == 0);

    const Result none = scotty_command(folder, "diff a b --stages nothing");
    CHECK(none.exit_code == 2);
    CHECK_THAT(none.err, ContainsSubstring("no stage was compared"));
    CHECK(scotty_command(folder, "diff a b --isolated").exit_code == 2);
    CHECK(scotty_command(folder, "diff a c").exit_code == 2);
    CHECK(scotty_command(folder, "replay a --stage nothing").exit_code == 2);
    CHECK(scotty_command(folder, "capture spheres -o c --stages nothing" + small).exit_code == 2);
    CHECK_FALSE(std::filesystem::exists(folder / "c"));

    make_capture(folder / "good", small_parameters());
    make_capture(folder / "bad", small_parameters(), [](StageCopies& stages) {
        ++stages.at("bounce0/scene_rays").output<std::uint32_t>("depth")[3];
    });
    const Result differs = scotty_command(folder, "diff good bad");
    CHECK(differs.exit_code == 1);
    CHECK_THAT(differs.out, ContainsSubstring("first divergence: launch") &&
                                ContainsSubstring("ray 3") &&
                                ContainsSubstring("scotty replay good --stage bounce0/scene_rays"));
    const Result replay = scotty_command(folder, "replay bad --stage bounce0/scene_rays --json");
    CHECK(replay.exit_code == 1);
    CHECK(nlohmann::json::parse(replay.out)["first_divergence"]["buffer"] == "depth");
}

TEST_CASE("command: capture --input-only writes what a run needs and runs nothing",
          "[verify][capture][cli]") {
    const TemporaryFolder folder;
    CHECK(scotty_command(folder, "capture cornell -o i --input-only --size 9x5").exit_code == 0);
    CHECK(Capture::open(folder / "i").stages().empty());
    CHECK(read_pipeline_input(folder / "i").parameters.image_width == 9);
    CHECK(scotty_command(folder, "capture cornell -o i --input-only --size 8x5").exit_code == 0);
    CHECK(read_pipeline_input(folder / "i").parameters.image_width == 8);
}

}  // namespace
