/// Planted faults: how they are run, when they count as caught, and the registry itself.
#include <algorithm>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/catch.h"
#include "tests/verify/command_tools.h"
#include "verify/base/shard.h"
#include "verify/capture/ray_file.h"
#include "verify/mutants/judge.h"
#include "verify/mutants/plant.h"

using namespace scotty::verify;
using scotty::verify::test::Result;
using scotty::verify::test::run_scotty;
using scotty::verify::test::scotty_here;

namespace {

/// What `scotty verify --json -` says of one failure.
ProcessOutcome failed(const std::string& invariant, const std::string& stage,
                      const std::string& sentence, const std::string& written_by = "") {
    const nlohmann::json report = {{"failures",
                                    {{{"invariant", invariant},
                                      {"stage", stage},
                                      {"launch", 12},
                                      {"node", 4},
                                      {"block", nullptr},
                                      {"ray", 77},
                                      {"sentence", sentence},
                                      {"written_by", written_by}},
                                     {{"invariant", "image-tile"}}}},
                                   {"scenes", {{{"configurations", {{{"stages", 3}}}}}}}};
    ProcessOutcome outcome;
    outcome.exit_code = kExitFailed;
    outcome.output = report.dump();
    return outcome;
}

PlantedFault expecting(ExpectedCatch expect) {
    PlantedFault fault;
    fault.name = "some_fault";
    fault.file = "gpu/kernels/intersect.h";
    fault.expect = std::move(expect);
    return fault;
}

/// False, and said so, where there is no scotty-mutants.
bool can_plant() {
    const auto here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    if (std::filesystem::exists(here / "scotty-mutants")) return true;
    WARN("not run: scotty-mutants is not built");
    return false;
}

/// Faults offered by this program, for as long as this lives.
class Offered {
 public:
    explicit Offered(const std::string& run, const std::string& unapplied = "") {
        const nlohmann::json registry = {
            {"faults",
             {{{"name", "some_fault"},
               {"what", "?"},
               {"file", "emulation/kernels/intersect.h"},
               {"run", run},
               {"unapplied", unapplied},
               {"expect", {{"check", "leaf-hits"}, {"stage", ".*"}}}}}},
            {"hostile", nlohmann::json::array()}};
        offer_planted_faults({registry.dump(), [this](int number) { switched_on = number; }});
    }
    ~Offered() { offer_planted_faults({}); }
    Offered(const Offered&) = delete;
    Offered& operator=(const Offered&) = delete;

    int switched_on = 0;
};

}  // namespace

TEST_CASE("mutants: a fault is caught by its check at its stage", "[verify][mutants]") {
    const auto result =
        judge(expecting({"leaf-hits", "bounce0/level[0-9]+/intersect", "too few", {}}),
              failed("leaf-hits", "bounce0/level3/intersect", "there are too few"));
    CHECK(result.why_not.empty());
    CHECK(result.found.launch == 12);
    CHECK(result.found.place == "node 4, ray 77");
}

TEST_CASE("mutants: another check, stage or sentence, or nothing, is an escape",
          "[verify][mutants]") {
    const ProcessOutcome found =
        failed("leaf-hits", "bounce0/level3/intersect", "there are too few");
    CHECK(judge(expecting({"merge", ".*", "", {}}), found).why_not ==
          "expected to be found by merge");
    CHECK(judge(expecting({"leaf-hits", "bounce0/level3", "", {}}), found).why_not ==
          "expected at bounce0/level3");
    CHECK(judge(expecting({"leaf-hits", ".*", "too many", {}}), found).why_not ==
          "expected to say too many");
    CHECK(judge(expecting({"leaf-hits", ".*", "", {"image-tile"}}), found).caught());
    CHECK(judge(expecting({"leaf-hits", ".*", "", {"image-global"}}), found).why_not ==
          "expected image-global to fail");
    CHECK(judge(expecting({"leaf-hits", ".*", "", {}}), ProcessOutcome{}).why_not ==
          "nothing was found");
}

TEST_CASE("mutants: an error is told by its kind, and placed where it says", "[verify][mutants]") {
    const auto result =
        judge(expecting({"data-race", "bounce0/level0/intersect_root", "", {}}),
              failed("error", "render",
                     "running bounce0/level0/intersect_root: kernel intersect_root<Width>, block 3 "
                     "(64 threads): data race on ray queues, byte 8 of 64: thread 1 of block 3 "
                     "writes it at ../../gpu/kernels/intersect.h:120"));
    CHECK(result.why_not.empty());
    CHECK(result.found.place == "gpu/kernels/intersect.h:120, node 4, ray 77");
    CHECK(result.found.launch == 3);  // so many were judged before it
    CHECK(kind_of_error("its threads part: ...") == "divergence");
    CHECK(kind_of_error("the disk is full") == "error");
}

TEST_CASE("mutants: a process that ends early is judged by its last words", "[verify][mutants]") {
    ProcessOutcome outcome;
    outcome.exit_code = kExitInternal;
    outcome.errors =
        "scotty: info: hello\nkernel intersect<Width>, block 1 (64 threads): thread 3 reached "
        "memory that is not there at gpu/kernels/intersect.h:252\n";
    CHECK(judge(expecting({"bad-address", "intersect", "thread 3", {}}), outcome).caught());
    outcome.exit_code = -1;
    outcome.errors = "";
    outcome.signal = SIGSEGV;
    CHECK(judge(expecting({"bad-address", ".*", "", {}}), outcome).found.says ==
          strsignal(SIGSEGV));
    outcome.signal = SIGALRM;
    outcome.timed_out = true;
    CHECK(judge(expecting({"bad-address", ".*", "", {}}), outcome).found.check == "time-limit");
}

/// Columns of the widest line that is no command.
std::size_t longest_line(const std::string& text) {
    std::size_t most = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.find(" scotty ") == std::string::npos) most = std::max(most, line.size());
    }
    return most;
}

TEST_CASE("mutants: the score counts, and a hostile condition that fails fails the report",
          "[verify][mutants]") {
    const ProcessOutcome found =
        failed("leaf-hits", "bounce0/level3/intersect", "there are too few");
    MutantReport report;
    report.faults = {judge(expecting({"leaf-hits", ".*", "", {}}), found),
                     judge(expecting({"merge", ".*", "", {}}), found)};
    CHECK(report.caught() == 1);
    CHECK_FALSE(report.passed());
    CHECK(to_text(report).find("mutants: 1 of 2 caught") != std::string::npos);
    CHECK(longest_line(to_text(report)) <= 80);
    report.faults.pop_back();
    CHECK(report.passed());
    report.hostile = {judge(HostileCondition{"tight", "?", "verify coil"}, found)};
    CHECK_FALSE(report.passed());
    CHECK(to_json(report)["hostile"][0]["failure"] ==
          "[leaf-hits] bounce0/level3/intersect: there are too few");
}

TEST_CASE("mutants: each command has a process of its own, with its exit code and both streams",
          "[verify][mutants]") {
    std::vector<ProcessOutcome> outcomes(3);
    run_in_processes(
        run_command, {{"list"}, {"render", "no-such-scene", "-o", "x.png"}, {"--version"}},
        {.at_once = 2, .seconds = 60},
        [&](std::size_t index, const ProcessOutcome& outcome) { outcomes[index] = outcome; });
    CHECK(outcomes[0].exit_code == kExitPassed);
    CHECK(outcomes[0].output.find("coil") != std::string::npos);
    CHECK(outcomes[1].exit_code == kExitUsage);
    CHECK(outcomes[1].errors.find("no-such-scene") != std::string::npos);
    CHECK(outcomes[2].exit_code == kExitPassed);
}

TEST_CASE("mutants: a fault that something else finds fails the command", "[verify][mutants]") {
    const Offered offered("verify no-such-scene");
    const Result result = scotty_here("mutants");
    CHECK(result.exit_code == kExitFailed);
    CHECK(result.out.find("ESCAPED  some_fault") != std::string::npos);
    CHECK(result.out.find("expected to be found by leaf-hits") != std::string::npos);
    CHECK(result.out.find("mutants: 0 of 1 caught") != std::string::npos);
}

TEST_CASE("mutants: a fault whose text has changed fails the command, and nothing is run of it",
          "[verify][mutants]") {
    const Offered offered("verify no-such-scene", "found 0 times in emulation/kernels/intersect.h");
    const Result result = scotty_here("mutants");
    CHECK(result.exit_code == kExitFailed);
    CHECK(result.out.find("GONE     some_fault") != std::string::npos);
    CHECK(result.out.find("does not apply any more: found 0 times") != std::string::npos);
    CHECK(result.out.find("1 of them do not apply any more") != std::string::npos);
    CHECK(result.out.find("no-such-scene") == std::string::npos);
    CHECK_THROWS_WITH(
        plant("some_fault", "emulator"),
        Catch::Matchers::ContainsSubstring("some_fault does not apply any more: found 0"));
    CHECK(scotty_here("mutants --list").exit_code == kExitPassed);
    CHECK(offered.switched_on == 0);
}

TEST_CASE("mutants: planting needs a fault's name and the back end that has it",
          "[verify][mutants]") {
    const Offered offered("verify coil");
    CHECK_THROWS_WITH(plant("nonsense", "emulator"),
                      "--plant: 'nonsense' is no fault; scotty mutants --list has their names");
    CHECK_THROWS_WITH(plant("some_fault", "simt"),
                      "--plant: some_fault is in emulation/kernels/intersect.h: it needs --backend "
                      "emulator");
    CHECK(offered.switched_on == 0);
    plant("some_fault", "emulator");
    CHECK(offered.switched_on == 1);
}

TEST_CASE("mutants: a fault in what the back ends share is in both that are planted",
          "[verify][mutants]") {
    PlantedFault fault;
    fault.file = "reference/stages/filters.h";
    CHECK(fault.is_of("emulator"));
    CHECK(fault.is_of("simt"));
    CHECK_FALSE(fault.is_of("cuda"));
    fault.file = "gpu/kernels/intersect.h";
    CHECK_FALSE(fault.is_of("emulator"));
    CHECK(fault.is_of("simt"));
}

TEST_CASE("mutants: a shard is every N-th, and together they are all", "[verify][mutants]") {
    std::multiset<std::size_t> dealt;
    for (const char* text : {"1/3", "2/3", "3/3"}) {
        const Shard shard = parse_shard(text);
        for (std::size_t i = 0; i < 10; ++i) {
            if (shard.has(i)) dealt.insert(i);
        }
    }
    CHECK(dealt.size() == 10);
    CHECK(std::set<std::size_t>(dealt.begin(), dealt.end()).size() == 10);
    CHECK(parse_shard("").has(7));
    for (const char* text : {"0/3", "4/3", "3", "1/", "/2", "1/2x", "a/b"}) {
        CAPTURE(text);
        CHECK_THROWS_WITH(parse_shard(text), Catch::Matchers::ContainsSubstring("expected I/N"));
    }
}

TEST_CASE("mutants: the registry has faults of each back end and of what they share, by own names",
          "[verify][mutants]") {
    if (!can_plant()) return;
    const Result result = run_scotty("mutants --list");
    CHECK(longest_line(result.out) <= 80);
    REQUIRE(result.exit_code == kExitPassed);
    std::istringstream lines(result.out);
    std::set<std::string> names;
    std::size_t in_gpu = 0, in_emulation = 0, shared = 0, hostile = 0, all = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with(' ')) continue;  // what it is
        ++all;
        names.insert(line.substr(0, line.find(' ')));
        in_gpu += line.find(" gpu/") != std::string::npos ? 1 : 0;
        in_emulation += line.find(" emulation/") != std::string::npos ? 1 : 0;
        shared += line.find(" reference/stages/") != std::string::npos ? 1 : 0;
        hostile += line.ends_with(" no fault") ? 1 : 0;
    }
    CHECK(names.size() == all);
    CHECK(in_gpu + in_emulation + shared + hostile == all);
    CHECK(shared >= 20);
    CHECK(in_gpu >= 20);
    CHECK(in_emulation >= 20);
}

TEST_CASE("mutants: a planted fault fails the command that it is planted in", "[verify][mutants]") {
    if (!can_plant()) return;
    const Result result = run_scotty(
        "verify cornell --size 5x4 --spp 1 --bounces 0 --light-samples 1 --width 8 --early-out off "
        "--no-golden --stage reconstruct_image --plant mean_not_divided");
    CHECK(result.exit_code == kExitPassed);  // one sample: the mean is the sum
    const Result two = run_scotty(
        "verify cornell --size 5x4 --spp 2 --bounces 0 --light-samples 1 --width 8 --early-out off "
        "--no-golden --stage reconstruct_image --plant mean_not_divided");
    CHECK(two.exit_code == kExitFailed);
    CHECK(two.out.find("[pixels]") != std::string::npos);
    CHECK(two.out.find("--plant mean_not_divided") != std::string::npos);
}

TEST_CASE("mutants: where nobody looks between levels an overflow ends them all the same",
          "[verify][mutants]") {
    if (!can_plant()) return;
    const scotty::verify::test::TemporaryFolder folder;
    RayFile rays;
    for (int i = 0; i < 200; ++i) {
        const float x = -0.9f + 0.009f * static_cast<float>(i);
        rays.rays.push_back({{x, 1.0f, 3.0f}, 0.0f, {0.0f, -0.1f, -1.0f}, 100.0f});
    }
    write_rays(folder.file("a.ray"), rays);
    const std::string trace = "trace --scene spheres --rays '" + folder.file("a.ray") +
                              "' --backend simt --check --width 4 --leaf-size 1";
    const Result right = run_scotty(trace);
    INFO(right.err);
    CHECK(right.exit_code == kExitPassed);
    const Result wrong = run_scotty(trace + " --plant region_too_small");
    INFO(wrong.err);
    CHECK(wrong.exit_code == kExitFailed);  // what is under test failed, not the program
    CHECK_THAT(wrong.err, Catch::Matchers::Matches(
                              "(.|\n)*level\\d+/intersect\\w*: the queue of node \\d+ has "
                              "\\d+ slots, but \\d+ rays were pushed to it(.|\n)*"));
    CHECK(wrong.err.find("nobody has written") == std::string::npos);
}
