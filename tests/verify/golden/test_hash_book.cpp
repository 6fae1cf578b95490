/// golden/hashes.txt: what a hash is of, what is compared, and how the file changes.
#include <filesystem>
#include <string>
#include <vector>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/golden/golden.h"
#include "verify/golden/golden_proposal.h"
#include "verify/golden/hash_book.h"
#include "verify/sweep/cases.h"
#include "verify/sweep/verify.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

VerifySettings small_settings(HashBook& book) {
    VerifySettings settings;
    settings.parameters = small_parameters();
    settings.only.emplace(
        {Configuration{settings.parameters, {emulation::ScheduleKind::linear, 0}}});
    settings.oracles = false;
    settings.hashes = &book;
    return settings;
}

const Hashes& recorded_hashes() {
    static const Hashes hashes = [] {
        HashBook book;
        const SceneReport report =
            verify_scene(scenes::load_scene("cornell"), small_settings(book));
        REQUIRE(report.passed());
        return book.recorded();
    }();
    return hashes;
}

std::string part_of(const std::string& what) { return what.substr(0, what.find(' ')); }

}  // namespace

TEST_CASE("hash book: a run leaves a hash of scene, trees, rays, hits, image and work",
          "[verify][golden]") {
    std::vector<std::string> parts;
    for (const auto& [what, hash] : recorded_hashes()) {
        CAPTURE(what);
        if (part_of(what) != "table") CHECK_THAT(what, ContainsSubstring(" cornell"));
        CHECK(hash != 0);
        parts.push_back(part_of(what));
    }
    for (const char* part : {"table", "scene", "tree", "rays", "hits", "image", "work"}) {
        CHECK(std::count(parts.begin(), parts.end(), part) >= 1);
    }
    HashBook again;
    verify_scene(scenes::load_scene("cornell"), small_settings(again));
    CHECK((again.recorded() == recorded_hashes()));
}

TEST_CASE("hash book: each hash that is another fails the verification and is named",
          "[verify][golden]") {
    for (const auto& [what, hash] : recorded_hashes()) {
        CAPTURE(what);
        Hashes golden = recorded_hashes();
        golden[what] ^= 1;
        HashBook book(golden, true);
        const SceneReport report =
            verify_scene(scenes::load_scene("cornell"), small_settings(book));
        const std::vector<PlacedFailure> failures = placed_failures(report);
        REQUIRE(failures.size() == 1);
        CHECK(failures.front().failure.invariant == kGoldenHash);
        CHECK(failures.front().failure.stage == part_of(what));
        CHECK(failures.front().failure.field == what);
        CHECK_THAT(failures.front().failure.sentence,
                   ContainsSubstring("scotty golden propose hashes"));
        CHECK(book.compared() == recorded_hashes().size());
    }
}

TEST_CASE("hash book: the first failure is of what makes the others", "[verify][golden]") {
    Hashes golden = recorded_hashes();
    for (auto& [what, hash] : golden) ++hash;
    HashBook book(golden, true);
    const std::vector<Failure> failures = book.look_up(recorded_hashes());
    REQUIRE(failures.size() == recorded_hashes().size());
    CHECK(failures.front().stage == "table");
    CHECK(failures.back().stage == "work");
}

TEST_CASE("hash book: a run that is not in the book fails only where the book is complete",
          "[verify][golden]") {
    HashBook incomplete({}, false);
    CHECK(incomplete.look_up(recorded_hashes()).empty());
    CHECK(incomplete.compared() == 0);
    HashBook complete({}, true);
    const std::vector<Failure> failures = complete.look_up({{"tree x --width 8", 1}});
    REQUIRE(failures.size() == 1);
    CHECK_THAT(failures.front().sentence, ContainsSubstring("has no hash of this run"));
}

TEST_CASE("hash book: what a check has called wrong is not called another besides",
          "[verify][golden]") {
    Hashes golden = recorded_hashes();
    for (auto& [what, hash] : golden) ++hash;
    HashBook book(golden, true);
    VerifySettings settings = small_settings(book);
    settings.tamper = [](const reference::StageView& stage, std::size_t,
                         const std::function<void(const reference::StageView&)>& show) {
        reference::StageView other = stage;
        if (!other.outputs.empty()) other.outputs.front().bytes = 0;
        show(other);
    };
    const SceneReport report = verify_scene(scenes::load_scene("cornell"), settings);
    REQUIRE_FALSE(report.passed());
    for (const PlacedFailure& placed : placed_failures(report)) {
        CHECK(placed.failure.invariant != kGoldenHash);
    }
}

TEST_CASE("hash book: text and back, and a line that is no hash is named", "[verify][golden]") {
    const TemporaryFolder folder;
    const std::string file = (folder / "hashes.txt").string();
    reference::write_file(file, to_text(recorded_hashes()));
    CHECK((read_hashes(file) == recorded_hashes()));
    for (const char* line : {"0123", "0123456789abcdef", "0123456789abcdeg tree x",
                             "0123456789ABCDEF tree x", "0123456789abcdef", ""}) {
        CAPTURE(line);
        reference::write_file(file, "0123456789abcdef tree x\n" + std::string(line) + "\n");
        CHECK_THROWS_WITH(read_hashes(file),
                          ContainsSubstring(file) && ContainsSubstring("line 2"));
    }
    CHECK_THROWS_WITH(read_hashes(folder / "none.txt"), ContainsSubstring("cannot be read"));
}

TEST_CASE("hash book: proposed, approved, checked", "[verify][golden]") {
    const TemporaryFolder folder;
    ProposalSettings settings;
    settings.golden = folder / "golden";
    settings.output = folder / "proposals";
    fs::create_directories(settings.golden);
    write_manifest(settings.golden, {});
    CHECK_FALSE(golden_hashes(settings.golden));

    const HashProposal first = propose_hashes(recorded_hashes(), settings);
    CHECK(first.added == recorded_hashes().size());
    CHECK_FALSE(fs::exists(settings.golden / kHashesFile));
    CHECK_THROWS_WITH(approve_hashes(settings.golden, settings.output, " "),
                      ContainsSubstring("--reason"));
    approve_hashes(settings.golden, settings.output, "a test");
    CHECK((golden_hashes(settings.golden) == recorded_hashes()));
    CHECK(check_golden(settings.golden, {}, "2020-06-15").empty());

    Hashes changed = recorded_hashes();
    const std::string gone = changed.begin()->first;
    changed.erase(gone);
    ++changed.begin()->second;
    changed["tree new"] = 1;
    const HashProposal second = propose_hashes(changed, settings);
    CHECK(second.added == 1);
    CHECK(second.changed == 1);
    CHECK(second.gone == 1);
    CHECK_THAT(to_text(second), ContainsSubstring("scotty golden approve hashes"));

    reference::write_file((settings.golden / kHashesFile).string(), "0123456789abcdef tree x\n");
    CHECK_THROWS_WITH(golden_hashes(settings.golden),
                      ContainsSubstring("not what the manifest says"));
    const auto findings = check_golden(settings.golden, {}, "2020-06-15");
    REQUIRE(findings.size() == 1);
    CHECK(findings.front().problem == GoldenProblem::corrupted);
}

TEST_CASE("hash book: golden/hashes.txt has the picture of every case and of every built-in scene",
          "[verify][golden]") {
    const std::optional<Hashes> golden = golden_hashes(find_golden_folder());
    REQUIRE(golden);
    const auto expect = [&](const std::string& scene, const reference::PipelineParameters& p) {
        for (const auto& [what, hash] : picture_hashes(scene, p, {})) {
            INFO(what << ": scotty golden propose hashes && scotty golden approve hashes");
            CHECK(golden->contains(what));
        }
    };
    for (const Case& one : covering_cases(Budget::standard).cases) {
        expect(one.scene, one.configuration.parameters);
    }
    for (const auto& scene : scenes::built_in_scenes()) {
        expect(scene.name, default_verify_parameters());
    }
}

}  // namespace scotty::verify::test
