/// --check, --schedules and --interleave as a user types them.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/verify/command_tools.h"

namespace {

using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

/// False, and said so, where there is no scotty-checked: a sanitizer has the calls.
bool can_check() {
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    if (fs::exists(here / "scotty-checked")) return true;
    WARN("not run: there is no scotty-checked (sanitizer presets build none)");
    return false;
}

constexpr const char* kTiny =
    " --size 9x7 --spp 1 --bounces 1 --light-samples 1 --width 8 --rays-per-block 32 "
    "--queue-levels 0 --queues nodes"
    " --early-out immediate --hit-mode buffer --block-order linear --shadow-query any";

TEST_CASE("check: both tiers are watched, the deliberate races counted by line",
          "[verify][check]") {
    if (!can_check()) return;
    for (const std::string backend : {"emulator", "simt"}) {
        const Result result =
            run_scotty("verify cornell" + std::string(kTiny) + " --schedule linear --no-oracles" +
                       " --schedules 2 --check --json - --backend " + backend);
        INFO(result.err);
        REQUIRE(result.exit_code == 0);
        const auto report = nlohmann::json::parse(result.out);
        CHECK(report["checked"] == true);
        CHECK(report["scenes"][0]["configurations"][1]["schedules"] == 2);
        std::string lines;
        for (const auto& read : report["relaxed_reads"]) {
            CHECK(read["met"] > 0);
            lines += read["line"].get<std::string>() + " ";
        }
        CHECK_THAT(lines, ContainsSubstring(backend == "simt" ? "gpu/kernels/intersect.h"
                                                              : "emulation/kernels/intersect.h"));
    }
}

TEST_CASE("check: every order of a captured stage, and one order from a file", "[verify][check]") {
    if (!can_check()) return;
    const TemporaryFolder folder;
    const std::string capture = "'" + folder.file("c") + "'";
    REQUIRE(run_scotty("capture cornell -o " + capture +
                       " --size 8x8 --spp 1 --bounces 0 --width 2 --rays-per-block 32")
                .exit_code == 0);
    const std::string stage =
        "replay " + capture + " --stage bounce0/level0/intersect_root --backend simt ";
    const Result all = run_scotty(stage + "--interleave --json");
    INFO(all.err);
    REQUIRE(all.exit_code == 0);
    const auto report = nlohmann::json::parse(all.out);
    CHECK(report["passed"] == true);
    CHECK(report["complete"] == true);
    CHECK(report["blocks"] == 2);
    CHECK(report["schedules"] > 1);

    std::ofstream(folder.file("order")) << "# scotty interleaving, version 1\n"
                                           "kernel intersect_root<Width>\nblocks 2\nthreads 32\n"
                                           "switch 0 40 1\n";
    const Result one = run_scotty(stage + "--schedule '" + folder.file("order") + "'");
    INFO(one.err << one.out);
    CHECK(one.exit_code == 0);
    CHECK_THAT(one.out, ContainsSubstring("block 0 stands before access 40, block 1 goes on"));
    const Result given_up = run_scotty(stage + "--interleave --most 1");
    CHECK(given_up.exit_code == 1);
    CHECK_THAT(given_up.out, ContainsSubstring("GIVEN UP"));
}

TEST_CASE("check: a data race found by any command is exit code 1, not an internal error",
          "[verify][check]") {
    if (!can_check()) return;
    const TemporaryFolder folder;
    const std::string planted =
        " --size 24x18 --spp 1 --bounces 0 --light-samples 1 --width 8 --backend simt --check "
        "--plant lost_in_reservation";
    const Result capture = run_scotty("capture spheres -o '" + folder.file("c") + "'" + planted);
    INFO(capture.err);
    CHECK(capture.exit_code == 1);
    CHECK_THAT(capture.err,
               ContainsSubstring("data race on") && ContainsSubstring("stages until the error"));
    CHECK(run_scotty("render spheres -o '" + folder.file("a.png") + "'" + planted).exit_code == 1);
}

TEST_CASE("check: what does not go together is refused", "[verify][check]") {
    const TemporaryFolder folder;
    std::ofstream(folder.file("order")) << "# scotty interleaving, version 1\n";
    const Result verify = scotty_here("verify cornell --check --backend cuda");
    CHECK(verify.exit_code == 2);
    CHECK_THAT(verify.err, ContainsSubstring("emulator or simt"));
    const Result render =
        scotty_here("render cornell -o a.png --schedule '" + folder.file("order") + "'");
    CHECK(render.exit_code == 2);
    CHECK_THAT(render.err, ContainsSubstring("scotty replay runs it"));
    const Result replay = scotty_here("replay nowhere --stage a --backend emulator --interleave");
    CHECK(replay.exit_code == 2);
    CHECK_THAT(replay.err, ContainsSubstring("are of simt, found emulator"));
}

}  // namespace
