#include <string>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/golden/ledger.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;

Ledger ledger_of_run(const Spoil& spoil = {}, const emulation::DeviceOptions& device = {}) {
    const TemporaryFolder folder;
    return ledger_of(make_capture(folder / "capture", small_parameters(), spoil, device));
}

const Ledger& truth() {
    static const Ledger ledger = ledger_of_run();
    return ledger;
}

}  // namespace

TEST_CASE("ledger: text holds all of it, and another order of blocks changes none",
          "[verify][golden]") {
    const TemporaryFolder folder;
    spill(folder / "ledger.txt", to_text(truth()));
    const Ledger read = read_ledger(folder / "ledger.txt");
    CHECK(read.header == truth().header);
    CHECK(read.lines == truth().lines);
    CHECK(read.lines.size() > 100);

    emulation::DeviceOptions reversed;
    reversed.schedule = emulation::ScheduleKind::reversed;
    const LedgerComparison same = compare_ledgers(read, ledger_of_run({}, reversed));
    CHECK(same.passed());
    CHECK(same.compared == read.lines.size());
    CHECK(same.differing == 0);
}

TEST_CASE("ledger: the first stage and buffer that differ are named", "[verify][golden]") {
    const Ledger spoiled = ledger_of_run([](StageCopies& stages) {
        stages.at("bounce1/scene_rays").output<float>("throughput")[7] += 1.0f;
        stages.at("bounce0/light0/resolve_light").output<float>("radiance")[5] += 1e-6f;
    });
    const LedgerComparison found = compare_ledgers(truth(), spoiled);
    CHECK_FALSE(found.passed());
    CHECK(found.stage == "bounce0/light0/resolve_light");
    CHECK(found.buffer == "radiance");
    CHECK(found.differing == 2);
    CHECK_THAT(found.sentence,
               ContainsSubstring("bounce0/light0/resolve_light: buffer 'radiance'"));
}

TEST_CASE("ledger: a missing stage, a new one and another buffer are named", "[verify][golden]") {
    const auto is_scene_rays = [](const LedgerLine& line) {
        return line.stage == "bounce0/scene_rays";
    };
    Ledger other = truth();
    std::erase_if(other.lines, is_scene_rays);
    CHECK_THAT(
        compare_ledgers(truth(), other).sentence,
        ContainsSubstring("bounce0/scene_rays: the golden run has this stage, this one has not"));
    CHECK_THAT(compare_ledgers(other, truth()).sentence,
               ContainsSubstring("bounce0/scene_rays: the golden run has no such stage"));
    other = truth();
    other.lines.pop_back();
    CHECK(compare_ledgers(truth(), other).stage == "reconstruct_image");
    CHECK(compare_ledgers(other, truth()).stage == "reconstruct_image");
    other = truth();
    std::swap(other.lines[0], other.lines[1]);
    CHECK_THAT(compare_ledgers(truth(), other).sentence, ContainsSubstring("was expected"));
}

TEST_CASE("ledger: another scene, tree or parameter is not compared line by line",
          "[verify][golden]") {
    Ledger other = truth();
    other.header[1].second = "0000000000000000";
    const LedgerComparison found = compare_ledgers(truth(), other);
    CHECK_THAT(found.sentence, ContainsSubstring("another bvh"));
    CHECK(found.stage.empty());
}

TEST_CASE("ledger: text that is none is refused by file and line", "[verify][golden]") {
    const TemporaryFolder folder;
    const auto error = [&](const std::string& text) {
        spill(folder / "ledger.txt", text);
        return error_of([&] { read_ledger(folder / "ledger.txt"); });
    };
    const std::string good = to_text(truth());
    CHECK_THAT(error("hello"), ContainsSubstring("ledger.txt: line 1"));
    CHECK_THAT(error(good + "stage buffer 0123\n"), ContainsSubstring("hexadecimal"));
    CHECK_THAT(error(good + "stage buffer 0123456789abcdef more\n"),
               ContainsSubstring("hexadecimal"));
    CHECK_THAT(error_of([&] { read_ledger(folder / "none.txt"); }),
               ContainsSubstring("cannot be read"));
}

}  // namespace scotty::verify::test
