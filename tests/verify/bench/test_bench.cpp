#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "tests/verify/command_tools.h"
#include "verify/bench/bench.h"
#include "verify/bench/bench_check.h"
#include "verify/bench/bench_simt.h"
#include "verify/commands/options.h"

namespace {

namespace fs = std::filesystem;
using namespace scotty;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("bench: both tracers get the living rays of every traversal", "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters = scotty::test::small_picture(16, 8, 1, 1, 2);
    settings.repeats = 2;
    settings.warm_ups = 0;
    const verify::BenchReport report =
        bench_backend(scenes::load_scene("cornell"), settings, "emulator");
    const std::vector<verify::BenchRays>& kinds = report.rays.kinds;
    REQUIRE(kinds.size() == 3);
    CHECK(kinds[0].kind == "primary");
    CHECK(kinds[0].rays == 16u * 8);
    CHECK(kinds[1].kind == "shadow");
    CHECK(kinds[2].kind == "bounce 1");
    std::uint64_t rays = 0;
    double ours = 0.0;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        rays += kinds[i].rays;
        ours += kinds[i].ours.median;
        CHECK(kinds[i].embree.least > 0.0);
        CHECK(kinds[i].kind == report.renders.rays[i].kind);
        CHECK(kinds[i].rays == report.renders.rays[i].rays);
        CHECK(kinds[i].rays == report.occupancy.kinds[i].rays);
    }
    CHECK(report.rays.all.rays == rays);
    CHECK(report.rays.all.ours.median == ours);
    CHECK(report.renders.device_bytes > 16u * 8 * 32);
    const nlohmann::json json = to_json(report);
    CHECK(json["ratio_to_embree"].get<double>() == report.rays.all.ratio());
    for (const char* key :
         {"rays", "all_rays", "render_seconds", "render_spread", "embree_render_seconds",
          "device_bytes", "stages", "kernels", "levels", "traversals", "stage_paths",
          "kernel_seconds", "occupancy", "warm_ups", "repeats", "batch_rays"}) {
        CHECK(json.contains(key));
    }
    CHECK(json["rays"][0].contains("emulator_rays_per_second"));
    CHECK(json["rays"][0]["emulator_spread"]["median"] == json["rays"][0]["emulator_seconds"]);
    CHECK(json["render_repeats"].size() == 2);
    CHECK_THAT(table(report),
               ContainsSubstring("emulator M/s") && ContainsSubstring("traversals of") &&
                   ContainsSubstring("bounce0/light0/") && ContainsSubstring("of warp"));
}

TEST_CASE("bench: Embree alone needs no back end beside it", "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters = scotty::test::small_picture(16, 8, 1, 2, 2);
    settings.warm_ups = 0;
    settings.repeats = 1;
    const verify::EmbreeBenchReport report = bench_embree(scenes::load_scene("cornell"), settings);
    CHECK(report.rays.kinds.size() == 4);
    CHECK(report.render.median > 0.0);
    const nlohmann::json json = to_json(report);
    CHECK(json["rays"][0]["embree_rays_per_second"].get<double>() > 0.0);
    CHECK_FALSE(json.contains("ratio_to_embree"));
    CHECK_FALSE(json["rays"][0].contains("ratio"));
    CHECK_THAT(table(report), ContainsSubstring("Embree M/s") && !ContainsSubstring("ratio"));
}

/// A program of that text in a folder of peers.
void put_peer(const fs::path& folder, const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << "#!/bin/sh\n" << text;
    fs::permissions(folder / name, fs::perms::owner_exec, fs::perm_options::add);
}

/// Traces with Embree, as a peer does.
std::string tracing_peer() {
    const auto scotty = fs::read_symlink("/proc/self/exe").parent_path() / "scotty";
    return "'" + scotty.string() +
           "' trace --backend embree --scene \"$1\" --rays \"$2\" -o \"$3\" 2>/dev/null || exit "
           "4\n";
}

const verify::Peer& peer_named(const verify::TracedRays& rays, const std::string& name) {
    for (const verify::Peer& peer : rays.peers) {
        if (peer.name == name) return peer;
    }
    throw std::runtime_error("no peer " + name);
}

TEST_CASE("bench: peers trace the same rays, and their hits are adjudicated", "[verify][bench]") {
    const verify::test::TemporaryFolder folder;
    const fs::path peers = folder.file("peers");
    fs::create_directories(peers);
    const std::string rounds = "for i in $(seq $5); do echo seconds 0.25; done\n";
    put_peer(peers, "right", tracing_peer() + "echo hello\n" + rounds);
    put_peer(peers, "wrong",
             tracing_peer() + "head -c 8 /dev/zero | dd of=\"$3\" conv=notrunc\n" + rounds);
    put_peer(peers, "short", tracing_peer() + "truncate -s 8 \"$3\"\n" + rounds);
    put_peer(peers, "crash", "echo no device >&2\nexit 3\n");
    put_peer(peers, "mute", tracing_peer() + "echo seconds nan; echo seconds 1 2\n");
    std::ofstream(peers / "notes.txt") << "not a program";

    verify::BenchSettings settings;
    settings.parameters = scotty::test::small_picture(16, 8, 1, 1, 2);
    settings.repeats = 2;
    settings.warm_ups = 0;
    settings.peers = peers;
    const verify::TracedRays rays = bench_embree(scenes::load_scene("cornell"), settings).rays;
    REQUIRE(rays.peers.size() == 5);
    REQUIRE(rays.kinds.size() == 3);

    const verify::Peer& right = peer_named(rays, "right");
    REQUIRE(right.kinds.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(right.kinds[i].kind == rays.kinds[i].kind);
        CHECK(right.kinds[i].rays == rays.kinds[i].rays);
        CHECK(right.kinds[i].failure.empty());
        CHECK(right.kinds[i].seconds.median == 0.25);
        CHECK(right.kinds[i].wrong == 0);
    }
    CHECK(right.all().seconds.median == 0.75);
    CHECK(right.all().rays == rays.all.rays);
    CHECK(peer_named(rays, "wrong").kinds[0].wrong == 1);
    CHECK(peer_named(rays, "wrong").all().wrong >= 2);
    CHECK_THAT(peer_named(rays, "short").kinds[0].failure,
               ContainsSubstring("1 hits for 128 rays"));
    CHECK(peer_named(rays, "crash").kinds[0].failure == "exit code 3; its last line: no device");
    CHECK_THAT(peer_named(rays, "crash").all().failure, ContainsSubstring("primary: exit code 3"));
    CHECK_THAT(peer_named(rays, "mute").kinds[0].failure,
               ContainsSubstring("0 lines \"seconds X\", expected 2"));

    CHECK_THAT(table(rays), ContainsSubstring("ours/peer") && ContainsSubstring("no device"));
    const nlohmann::json json = to_json(rays)["peers"];
    REQUIRE(json.size() == 5);
    CHECK(json[0]["name"] == "crash");
    CHECK(json[0]["rays"][0]["failure"] == "exit code 3; its last line: no device");
    CHECK(json[2]["name"] == "right");
    CHECK(json[2]["all_rays"]["seconds"] == 0.75);
    CHECK(json[2]["all_rays"]["ratio"].get<double>() == 0.75 / rays.all.embree.median);
}

TEST_CASE("bench: a folder of peers is looked at before the work starts", "[verify][bench]") {
    const verify::test::TemporaryFolder folder;
    using verify::test::run_scotty;
    const auto empty = run_scotty("bench embree cornell --peers '" + (folder / ".").string() + "'");
    CHECK(empty.exit_code == 2);
    CHECK_THAT(empty.err,
               ContainsSubstring("no executable file") && ContainsSubstring("PEER SCENE.scn"));
    const auto simt = run_scotty("bench simt --peers '" + (folder / ".").string() + "'");
    CHECK(simt.exit_code == 2);
    CHECK_THAT(simt.err, ContainsSubstring("only with emulator, cuda and embree"));
}

TEST_CASE("bench: launches add up by stage, kernel, level, kind of rays and name",
          "[verify][bench]") {
    using reference::kNotApplicable;
    using reference::LaunchRecord;
    using reference::StageKind;
    reference::PipelineParameters p;
    p.queue_levels = 2;
    p.filter = reference::Filter::median;
    const reference::WideBvh bvh = build_wide_bvh(scenes::load_scene("coil"), bvh_parameters(p, 1));
    const std::vector<LaunchRecord> launches{
        {StageKind::primary_rays, 0, kNotApplicable, kNotApplicable, kNotApplicable, 1, 8, 1.0},
        {StageKind::intersect_root, 0, 0, kNotApplicable, 0, 2, 8, 2.0},
        {StageKind::intersect, 0, 0, kNotApplicable, 1, 3, 6, 4.0},
        {StageKind::intersect_root, 1, 0, kNotApplicable, 0, 2, 8, 8.0},
        {StageKind::intersect, 0, 1, 0, 1, 1, 2, 16.0},
        {StageKind::filter, 0, kNotApplicable, kNotApplicable, kNotApplicable, 1, 8, 32.0}};
    const verify::BenchParts parts = verify::parts_of(launches, bvh, p);
    CHECK(parts.seconds == 63.0);
    const auto seconds = [](const std::vector<verify::BenchPart>& rows) {
        std::vector<std::pair<std::string, double>> out;
        for (const verify::BenchPart& row : rows) out.emplace_back(row.name, row.seconds);
        return out;
    };
    using Rows = std::vector<std::pair<std::string, double>>;
    CHECK(seconds(parts.stages) ==
          Rows{{"filter", 32}, {"intersect", 20}, {"intersect_root", 10}, {"primary_rays", 1}});
    CHECK(seconds(parts.kernels) == Rows{{"filter_median", 32},
                                         {"intersect_subtrees", 20},
                                         {"intersect_root", 10},
                                         {"primary_rays", 1}});
    CHECK(seconds(parts.levels) == Rows{{"level 0", 10}, {"level 1", 20}});
    CHECK(seconds(parts.rays) == Rows{{"primary", 14}, {"shadow", 16}, {"shading", 33}});
    CHECK(seconds(parts.paths) == Rows{{"filter", 32},
                                       {"bounce1/light0/intersect", 16},
                                       {"bounce0/intersect_root", 10},
                                       {"bounce0/intersect", 4},
                                       {"primary_rays", 1}});
    CHECK(parts.levels[0].launches == 2);
    CHECK(parts.levels[0].blocks == 4);
    CHECK(parts.levels[1].items == 8);
}

TEST_CASE("bench: cuda without a device is something missing, exit code 3",
          "[verify][bench][cli]") {
    if (verify::machine_description().cuda) {
        WARN("not run: there is a CUDA device");
        return;
    }
    const verify::test::Result result = verify::test::scotty_here("bench cuda cornell");
    CHECK(result.exit_code == 3);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, ContainsSubstring("cuda: "));
}

TEST_CASE("bench: every one says machine, warm-ups, repeats and spread", "[verify][bench][cli]") {
    const std::string small =
        " cornell --size 8x8 --spp 1 --bounces 0 --threads 1 --repeats 2 --warm-ups 0";
    for (const std::string what : {"emulator", "simt", "embree"}) {
        const verify::test::Result result =
            verify::test::scotty_here("bench " + what + small + " --json -");
        INFO(what << result.err);
        REQUIRE(result.exit_code == 0);
        const nlohmann::json json = nlohmann::json::parse(result.out);
        CHECK(json["machine"]["cores"].get<int>() >= 1);
        CHECK(json["warm_ups"] == 0);
        CHECK(json["repeats"] == 2);
        CHECK(json["threads"] == 1);
        CHECK(json["rays"][0]["embree_spread"]["least"] <= json["rays"][0]["embree_seconds"]);
        CHECK(json.contains("occupancy") == (what != "embree"));
    }
    const verify::test::Result text = verify::test::scotty_here("bench embree" + small);
    CHECK_THAT(text.out, ContainsSubstring("median of 2 after 0 to warm up") &&
                             ContainsSubstring("machine: "));
    const verify::test::Result help = verify::test::scotty_here("bench --help");
    CHECK_THAT(help.out,
               ContainsSubstring("bench cuda coil") && ContainsSubstring("bench embree coil"));
    const verify::test::Result never =
        verify::test::scotty_here("bench embree cornell --repeats 0");
    CHECK(never.exit_code == 2);
    CHECK_THAT(never.err, ContainsSubstring("--repeats"));
}

TEST_CASE("bench: the CUDA text on the CPU is timed beside the emulator, stage by stage",
          "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters = scotty::test::small_picture(16, 8, 1, 2, 2);
    settings.repeats = 2;
    const verify::SimtBenchReport report = bench_simt(scenes::load_scene("cornell"), settings);
    CHECK(report.render.emulator_seconds > 0.0);
    CHECK(report.render.simt_seconds > 0.0);
    CHECK(report.stages.size() == 10);
    double parts = 0.0;
    for (const verify::SimtBenchPart& part : report.stages) {
        CHECK(part.simt_seconds > 0.0);
        parts += part.simt_seconds;
    }
    CHECK(parts <= report.render.simt_seconds);
    CHECK(to_json(report)["ratio_to_emulator"].get<double>() == report.render.ratio());
    CHECK_THAT(table(report),
               ContainsSubstring("whole render") && ContainsSubstring("intersect_root"));
}

TEST_CASE("bench: checking that costs more than its limit fails", "[verify][bench]") {
    verify::BenchSettings settings;
    settings.parameters = scotty::test::small_picture(16, 8, 1, 2, 2);
    settings.repeats = 1;
    const reference::Scene scene = scenes::load_scene("cornell");
    const auto with = [&](const std::string& emulator, const std::string& simt) {
        return bench_check(scene, settings,
                           R"(echo '{"emulator":[)" + emulator + R"(],"simt":[)" + simt + "]}'");
    };
    CHECK(with("1e-9", "1e-9").passed());
    CHECK_FALSE(with("1e-9", "1e9").passed());
    const verify::CheckBenchReport slow = with("1e9", "1e-9");
    CHECK_FALSE(slow.passed());
    REQUIRE(slow.parts.size() == 2);
    CHECK_FALSE(slow.parts[0].within());
    CHECK(slow.parts[1].within());
    CHECK(to_json(slow)["passed"] == false);
    CHECK_THAT(table(slow), ContainsSubstring("OVER THE LIMIT"));
    CHECK_THROWS_WITH(bench_check(scene, settings, "true"),
                      ContainsSubstring("no figures from true"));
}

TEST_CASE("bench: the command fails with the limit, exit code 1", "[verify][bench][cli]") {
    const verify::test::TemporaryFolder folder;
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    fs::copy_file(here / "scotty", folder / "scotty");
    // What scotty-checked would print, had it taken that long.
    std::ofstream(folder / "scotty-checked")
        << "#!/bin/sh\necho '{\"emulator\":[1e-9],\"simt\":[1e9]}'\n";
    fs::permissions(folder / "scotty-checked", fs::perms::owner_all);
    const verify::test::Result result = verify::test::run(
        folder / "scotty", "bench check cornell --size 16x8 --repeats 1 --json -");
    INFO(result.err);
    CHECK(result.exit_code == 1);
    CHECK(nlohmann::json::parse(result.out)["passed"] == false);
}

TEST_CASE("bench: check has figures from the program that checks", "[verify][bench][cli]") {
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    if (!fs::exists(here / "scotty-checked")) {
        WARN("not run: scotty-checked is not built");
        return;
    }
    const verify::test::Result result = verify::test::run(
        here / "scotty",
        "bench check cornell --size 8x6 --repeats 1 --samples-per-pass 1 --json -");
    INFO(result.err);
    CHECK(result.exit_code <= 1);  // so small a picture may be over the limit
    CHECK(nlohmann::json::parse(result.out).contains("passed"));
}

TEST_CASE("options: what is printed to be run again is taken by the command that it names",
          "[verify][options][cli]") {
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    for (const char* command : {"bench", "capture", "diff", "verify"}) {
        const std::string help =
            verify::test::run(here / "scotty", std::string(command) + " --help").out;
        for (const reference::ParameterInfo& info : reference::kParameters) {
            using Group = reference::ParameterGroup;
            if (info.group == Group::filter || info.group == Group::arithmetic) continue;
            CAPTURE(command, info.name);
            CHECK_THAT(help, ContainsSubstring(std::string(info.option) + " "));
        }
    }
}

TEST_CASE("options: a size is two numbers around an x", "[verify][options]") {
    reference::PipelineParameters p;
    verify::parse_size("640x480", p);
    CHECK(p.image_width == 640);
    CHECK(p.image_height == 480);
    for (const char* text :
         {"640", "640x", "x480", "640x480x3", "6 40x480", "-1x5", "99999999999x1"}) {
        CHECK_THROWS_WITH(verify::parse_size(text, p), ContainsSubstring("--size"));
    }
}

TEST_CASE("options: a list is values between commas", "[verify][options]") {
    CHECK(verify::split_list("--width", "2,4,16") == std::vector<std::string>{"2", "4", "16"});
    CHECK(verify::split_list("--width", "8").size() == 1);
    for (const char* text : {"", ",", "2,", ",4"}) {
        CHECK_THROWS_WITH(verify::split_list("--width", text), ContainsSubstring("--width"));
    }
}

}  // namespace
