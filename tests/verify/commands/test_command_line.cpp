/// The command as a user runs it: exit codes, what goes to which stream, clean JSON.
///
/// The real program is run, but for the long table of bad input.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/command_tools.h"
#include "tests/verify/image_tools.h"
#include "verify/commands/options.h"
#include "verify/golden/golden.h"
#include "verify/images/image_read.h"

namespace {

using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using scotty::verify::read_image;
using scotty::verify::ReadImage;
namespace fs = std::filesystem;
using Folder = TemporaryFolder;

Result scotty(const std::string& arguments) { return run_scotty(arguments); }

constexpr const char* kQuick =
    " --size 9x5 --spp 1 --bounces 1 --light-samples 1 --threads 1 --width 8 --rays-per-block 64 "
    "--queue-levels 0 --queues nodes "
    "--schedule free";

TEST_CASE("command: --json takes a file where one is named", "[verify][cli]") {
    using scotty::verify::json_words;
    using Words = std::vector<std::string>;
    CHECK(json_words({"list", "--json"}) == Words{"list", "--json=-"});
    CHECK(json_words({"diff", "--json", "a.exr", "b.exr"}) ==
          Words{"diff", "--json=-", "a.exr", "b.exr"});
    CHECK(json_words({"diff", "--json", "out.json", "a"}) ==
          Words{"diff", "--json", "out.json", "a"});
    CHECK(json_words({"diff", "--json", "-", "a"}) == Words{"diff", "--json", "-", "a"});

    const Folder folder;
    const std::string file = folder.file("list.json");
    const auto both = run_scotty("list --json '" + file + "'");
    CHECK(both.exit_code == 0);
    CHECK_THAT(both.out, ContainsSubstring("empty Cornell box") && !ContainsSubstring("{"));
    CHECK(slurp(file) == run_scotty("list --json").out);
    const auto lost = run_scotty("list --json /nowhere/list.json");
    CHECK(lost.exit_code == 2);
    CHECK_THAT(lost.err, ContainsSubstring("/nowhere"));
}

TEST_CASE("command: help and version go to standard output and pass", "[verify][cli]") {
    for (const std::string command :
         {"", "list ", "info ", "render ", "verify ", "bench ", "doctor ", "golden ", "check "}) {
        const Result help = scotty_here(command + "--help");
        CHECK(help.exit_code == 0);
        CHECK_THAT(help.out, ContainsSubstring("Examples:"));
        CHECK(help.err.empty());
    }
    const Result version = scotty("--version");
    CHECK(version.exit_code == 0);
    CHECK_THAT(version.out, ContainsSubstring("scotty 0."));
}

TEST_CASE("command: bad usage and bad input exit with 2 and one clear line", "[verify][cli]") {
    const Folder folder;
    const std::string out = " -o '" + folder.file("a.png") + "'";
    std::ofstream(folder.file("truncated.obj")) << "v 0 0 0\nv 1 0 0\nf 1 2 3\n";
    const std::vector<std::pair<std::string, std::string>> table{
        {"", "subcommand"},
        {"frobnicate", "frobnicate"},
        {"verify --frobnicate", "--frobnicate"},
        {"golden", "subcommand"},
        {"golden check --golden '" + folder.file("none") + "'", "manifest.json: cannot be read"},
        {"golden propose nosuchcase", "no such case; there are cornell"},
        {"golden approve cornell", "--reason"},
        {"render", "scene"},
        {"render cornell", "--output"},
        {"render nosuchscene" + out, "no such scene"},
        {"render missing.dae" + out, "no such file"},
        {"render '" + folder.file("truncated.obj") + "'" + out, "truncated.obj"},
        {"render cornell" + out + " --width 3", "2, 4, 8 or 16, found 3"},
        {"render cornell" + out + " --rays-per-block 0", "32..1024, a multiple of 32, found 0"},
        {"render cornell" + out + " --rays-per-block 65", "multiple of 32"},
        {"render cornell" + out + " --size 0x0", "image width"},
        {"render cornell" + out + " --size 65536x65536", "image size"},
        {"render cornell" + out + " --size 99999999999x1", "--size"},
        {"render cornell" + out + " --size -1x5", "--size"},
        {"render cornell" + out + " --size wide", "WIDTHxHEIGHT"},
        {"render cornell" + out + " --spp 0", "samples per pixel"},
        {"render cornell" + out + " --spp many", "--spp"},
        {"render cornell" + out + " --early-out never", "off, level, immediate"},
        {"render cornell" + out + " --filter blur", "gaussian"},
        {"render cornell" + out + " --backend abacus", "embree, found 'abacus'"},
        {"render cornell" + out + " --display ::1:80", "IPv6 address stands in brackets"},
        {"render cornell" + out + " --display localhost:tev", "1..65535"},
        {"render cornell" + out + " --progressive --samples-per-pass 0", "--samples-per-pass"},
        {"render cornell -o picture.gif", "picture.gif"},
        {"render cornell -o '" + folder.file("no/such/a.png") + "'", "no/such does not exist"},
        {"verify nosuchscene", "no such scene"},
        {"verify cornell --width 3", "found 3"},
        {"verify cornell cornell", "cornell: is named twice"},
        {"verify cornell --width 8,,4", "--width"},
        {"verify cornell --hit-mode stack", "buffer, packed"},
        {"verify cornell --schedule backwards", "shuffle:SEED"},
        {"verify cornell" + std::string(kQuick) + " --no-oracles --stage nosuchstage",
         "nosuchstage"},
        {"bench", "what"},
        {"bench abacus", "abacus"},
        {"bench emulator nosuchscene", "no such scene"},
        {"list --frobnicate", "--frobnicate"}};
    for (const auto& [arguments, expected] : table) {
        const Result result = scotty_here(arguments);
        INFO("scotty " << arguments << "\n" << result.err);
        CHECK(result.exit_code == 2);
        CHECK_THAT(result.err, ContainsSubstring("error: ") && ContainsSubstring(expected));
        CHECK(result.out.empty());
    }
    CHECK_FALSE(fs::exists(folder.file("a.png")));
    CHECK(scotty("render cornell" + out + " --width 3").exit_code == 2);
    CHECK(scotty("frobnicate").exit_code == 2);
}

TEST_CASE("list: names every built-in scene, as clean JSON too", "[verify][cli]") {
    const Result text = scotty("list");
    CHECK(text.exit_code == 0);
    const Result json = scotty("list --json");
    CHECK(json.exit_code == 0);
    const auto scenes = nlohmann::json::parse(json.out);
    CHECK(scenes.size() == 8);
    for (const auto& scene : scenes)
        CHECK_THAT(text.out, ContainsSubstring(scene["name"].get<std::string>()));
}

TEST_CASE("golden check: fails and names what is missing, as clean JSON too", "[verify][cli]") {
    const Folder folder;
    std::ofstream(folder.file("manifest.json"))
        << R"({"format": "cuda-scotty-golden", "version": 1, "cases": []})";
    const std::string golden = " --golden '" + folder.path().string() + "'";
    const Result text = scotty_here("golden check" + golden);
    CHECK(text.exit_code == 1);
    CHECK_THAT(text.out,
               ContainsSubstring("missing") && ContainsSubstring("scotty golden propose coil"));
    const Result json = scotty_here("golden check --json" + golden);
    CHECK(json.exit_code == 1);
    const auto result = nlohmann::json::parse(json.out);
    CHECK(result["passed"] == false);
    CHECK(result["findings"].size() == 8);
}

TEST_CASE("doctor: says what there is, as clean JSON too", "[verify][cli]") {
    const Result text = scotty("doctor");
    CHECK(text.exit_code == 0);
    for (const char* word : {"CPU", "memory", "TBB", "Embree", "CUDA compiler", "CUDA device"}) {
        CHECK_THAT(text.out, ContainsSubstring(word));
    }
    const auto findings = nlohmann::json::parse(scotty("doctor --json").out);
    CHECK(findings.size() >= 8);
}

TEST_CASE("render: both backends draw the same picture", "[verify][cli]") {
    const Folder folder;
    const std::string common = " --size 20x11 --spp 1 --threads 1 -o ";
    const Result ours = scotty("render cornell" + common + "'" + folder.file("a.exr") + "'");
    CHECK(ours.exit_code == 0);
    CHECK(ours.out.empty());
    CHECK_THAT(ours.err, ContainsSubstring("a.exr"));
    CHECK(scotty("render cornell --backend embree" + common + "'" + folder.file("b.exr") + "'")
              .exit_code == 0);
    CHECK(slurp(folder.file("a.exr")).size() > 300);
    CHECK(same_picture(folder.file("a.exr"), folder.file("b.exr")));
    CHECK(scotty("render cornell --filter median --exposure 1" + common + "'" +
                 folder.file("c.png") + "'")
              .exit_code == 0);
    CHECK(fs::exists(folder.file("c.png")));
}

TEST_CASE("verify: passes with 0, a table on standard output and all reports", "[verify][cli]") {
    const Folder folder;
    const Result result =
        scotty("verify cornell" + std::string(kQuick) + " --report '" + folder.file("r") + "'");
    CHECK(result.exit_code == 0);
    CHECK_THAT(result.out, ContainsSubstring("cornell") && ContainsSubstring("passed"));
    CHECK_THAT(result.err, ContainsSubstring("configurations"));
    CHECK(nlohmann::json::parse(slurp(folder.file("r/verify.json")))["passed"].get<bool>());
    CHECK_THAT(slurp(folder.file("r/verify.junit.xml")),
               ContainsSubstring("<testsuite name=\"cornell\""));
    CHECK_THAT(slurp(folder.file("r/verify.html")), ContainsSubstring("passed"));
}

TEST_CASE("verify: JSON on standard output is clean, and its replay commands run",
          "[verify][cli]") {
    const Result result = scotty("verify furnace --no-oracles" + std::string(kQuick) + " --json -");
    CHECK(result.exit_code == 0);
    const auto report = nlohmann::json::parse(result.out);
    CHECK(report["passed"].get<bool>());
    const auto& scene = report["scenes"][0];
    CHECK_FALSE(scene["oracles_ran"].get<bool>());
    std::string replay = scene["configurations"][1]["replay"];
    REQUIRE(replay.rfind("scotty ", 0) == 0);
    const Result again =
        scotty(replay.substr(7) + " --no-oracles --stage 'bounce0/level?/*' --json -");
    INFO(replay << "\n" << again.err);
    CHECK(again.exit_code == 0);
    const auto replayed = nlohmann::json::parse(again.out);
    CHECK(replayed["scenes"][0]["configurations"].size() == 2);  // the baseline, and that one
    CHECK(replayed["scenes"][0]["configurations"][1]["configuration"] ==
          scene["configurations"][1]["configuration"]);
}

TEST_CASE("bench: has the ratio to Embree, rays by kind and time by stage and level",
          "[verify][cli]") {
    const Result result =
        scotty("bench emulator cornell --size 16x16 --repeats 1 --warm-ups 0 --threads 1 --json -");
    CHECK(result.exit_code == 0);
    const auto report = nlohmann::json::parse(result.out);
    CHECK(report["ratio_to_embree"].get<double>() > 0.0);
    CHECK(report["rays"].size() == 4);  // primary, two bounces, shadow
    CHECK(report["stages"].size() >= 7);
    CHECK(report["levels"].size() >= 2);
    const Result text =
        scotty("bench emulator cornell --size 16x16 --repeats 1 --warm-ups 0 --threads 1");
    CHECK_THAT(text.out, ContainsSubstring("primary") && ContainsSubstring("shadow") &&
                             ContainsSubstring("level 1"));
}

TEST_CASE("scotty diff --backends: two back ends, or one and a capture", "[verify][command]") {
    const Folder folder;
    const std::string small = " --size 9x7 --bounces 1 --width 4";
    const Result two = scotty("diff --backends emulator,simt cornell" + small);
    CHECK(two.exit_code == 0);
    CHECK_THAT(two.out, ContainsSubstring("passed"));

    CHECK(scotty("capture cornell -o '" + folder.file("c") + "'" + small).exit_code == 0);
    CHECK(scotty("diff --backends simt,'" + folder.file("c") + "'").exit_code == 0);
    CHECK(scotty("diff --isolated --backends '" + folder.file("c") + "',simt").exit_code == 0);

    const Result nobody = scotty("diff --backends abacus,slide-rule cornell");
    CHECK(nobody.exit_code == 2);
    CHECK_THAT(nobody.err, ContainsSubstring("abacus,slide-rule"));
    const Result nothing = scotty("diff --backends emulator,simt");
    CHECK(nothing.exit_code == 2);
    CHECK_THAT(nothing.err, ContainsSubstring("expected a scene"));
}

TEST_CASE("render: an EXR has its variance and says where it comes from, and is judged by that",
          "[verify][cli]") {
    const Folder folder;
    const std::string file = folder.file("picture.exr");
    const std::string golden =
        (scotty::verify::find_golden_folder() / "images/slivers.exr").string();
    for (const char* how : {"--backend emulator", "--backend embree", "--backend simt",
                            "--backend emulator --batch-rays 1000 --progressive"}) {
        INFO(how);
        REQUIRE(scotty_here("render slivers --size 64x64 --spp 16 -o '" + file + "' " + how)
                    .exit_code == 0);
        const ReadImage read = read_image(file);
        CHECK(read.image.samples == 16);
        REQUIRE(read.image.variance.size() == 64 * 64);
        CHECK(read.attributes.at("scotty:scene") == "slivers");
        CHECK(read.attributes.at("scotty:version").find('.') != std::string::npos);
        CHECK_THAT(how, ContainsSubstring(read.attributes.at("scotty:backend")));
        const auto parameters = nlohmann::json::parse(read.attributes.at("scotty:parameters"));
        CHECK(parameters["spp"] == 16);
        CHECK(scotty_here("diff '" + golden + "' '" + file + "'").exit_code == 0);
    }
    for (const char* unknown : {"--spp 1", "--spp 16 --filter median"}) {
        INFO(unknown);
        REQUIRE(scotty_here("render slivers --size 64x64 -o '" + file + "' " + unknown).exit_code ==
                0);
        CHECK(read_image(file).image.variance.empty());
        CHECK(scotty_here("diff '" + golden + "' '" + file + "'").exit_code == 2);  // not judged
    }
    // A capture's image has its variance, too.
    const std::string capture = folder.file("capture");
    REQUIRE(scotty_here("capture slivers --size 64x64 --spp 16 --stages reconstruct_image -o '" +
                        capture + "'")
                .exit_code == 0);
    CHECK(scotty_here("diff '" + golden + "' '" + capture + "'").exit_code == 0);
}

}  // namespace
