/// golden/: what check finds, that propose touches nothing and approve only its case.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/golden/golden.h"
#include "verify/golden/golden_proposal.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

const Date kDay = "2020-06-15";

GoldenCase tiny_case(const std::string& name, const std::string& scene) {
    GoldenCase golden{name, scene, {}, {}, {}};
    golden.image.image_width = 4;
    golden.image.image_height = 3;
    golden.image.spp = 4;
    golden.image.bounces = 1;
    golden.pipeline = golden.image;
    golden.ledger = small_parameters();
    golden.ledger.image_width = 3;
    golden.ledger.image_height = 2;
    return golden;
}

const std::vector<GoldenCase>& cases() {
    static const std::vector<GoldenCase> list{tiny_case("box", "cornell"),
                                              tiny_case("sky", "furnace")};
    return list;
}

/// Every file of a folder with its bytes.
std::map<std::string, std::string> contents(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            files[fs::relative(entry.path(), folder).string()] = slurp(entry.path());
        }
    }
    return files;
}

/// A golden folder and one of proposals, both gone with this.
struct Store {
    TemporaryFolder folder;
    fs::path golden = folder / "golden";
    fs::path proposals = folder / "proposals";

    Store() {
        fs::create_directories(golden);
        write_manifest(golden, {});
    }
    ProposalSettings settings() const {
        ProposalSettings out;
        out.golden = golden;
        out.output = proposals;
        out.command = "scotty golden propose";
        out.commit = "0123";
        return out;
    }
    Proposal propose(const GoldenCase& golden_case) const {
        return propose_golden(golden_case, settings());
    }
    void approve(const GoldenCase& golden_case) const {
        approve_golden(golden_case, golden, proposals, "for a test");
    }
    std::vector<GoldenFinding> check(const std::vector<GoldenCase>& list = cases()) const {
        return check_golden(golden, list, kDay);
    }
    void write_waivers(const std::string& waivers) const {
        spill(golden / "waivers.json",
              R"({"format": "cuda-scotty-waivers", "version": 1, "waivers": [)" + waivers + "]}");
    }
};

/// With both cases approved.
struct FullStore : Store {
    FullStore() {
        for (const GoldenCase& golden_case : cases()) {
            propose(golden_case);
            approve(golden_case);
        }
    }
};

/// The only finding there is; its sentence and its way out behind it.
std::string only_finding(const std::vector<GoldenFinding>& findings) {
    REQUIRE(findings.size() == 1);
    const GoldenFinding& f = findings.front();
    CHECK_FALSE(f.way_out.empty());
    return std::string(to_string(f.problem)) + " " + f.name + " " + f.file + ": " + f.text + " / " +
           f.way_out;
}

}  // namespace

TEST_CASE("golden: what was proposed and approved is found whole, with its provenance",
          "[verify][golden]") {
    const FullStore store;
    CHECK(store.check().empty());
    const Manifest manifest = read_manifest(store.golden);
    REQUIRE(manifest.entries.size() == 2);
    const GoldenEntry& entry = *manifest.find("box");
    CHECK(entry.reason == "for a test");
    CHECK(entry.commit == "0123");
    CHECK(entry.settings["scene"] == "cornell");
    CHECK(entry.settings["image"]["samples"] == 4);
    CHECK(entry.files.at("images/box.exr") == checksum(store.golden / "images" / "box.exr"));
}

TEST_CASE("golden check: a case without an entry and an entry without its file are missing",
          "[verify][golden]") {
    const FullStore store;
    std::vector<GoldenCase> more = cases();
    more.push_back(tiny_case("new", "cornell"));
    CHECK_THAT(only_finding(store.check(more)),
               ContainsSubstring("missing new") && ContainsSubstring("scotty golden propose new"));
    fs::remove(store.golden / "images" / "sky.exr");
    CHECK_THAT(only_finding(store.check()), ContainsSubstring("missing sky images/sky.exr") &&
                                                ContainsSubstring("git checkout"));
}

TEST_CASE("golden check: files and entries that nobody knows are orphaned", "[verify][golden]") {
    const FullStore store;
    spill(store.golden / "images" / "old.exr", "what is this");
    CHECK_THAT(only_finding(store.check()), ContainsSubstring("orphaned  images/old.exr"));
    fs::remove(store.golden / "images" / "old.exr");
    CHECK_THAT(only_finding(store.check({cases()[0]})), ContainsSubstring("orphaned sky"));
}

TEST_CASE("golden check: other parameters and another scene make an entry stale",
          "[verify][golden]") {
    const FullStore store;
    std::vector<GoldenCase> list = cases();
    list[0].image.bounces = 2;
    CHECK_THAT(
        only_finding(store.check(list)),
        ContainsSubstring("stale box") && ContainsSubstring("image/bounces was 1, now it is 2"));
    list = cases();
    list[1].ledger.width = 8;
    CHECK_THAT(
        only_finding(store.check(list)),
        ContainsSubstring("stale sky") && ContainsSubstring("ledger/width was 4, now it is 8"));
    list = cases();
    list[1].scene = "furnace:albedo=0.25";
    CHECK_THAT(only_finding(store.check(list)),
               ContainsSubstring("stale sky") && ContainsSubstring("scene"));
    list = cases();
    list[0].pipeline.spp = 99;  // the pipeline's side is not in the files
    CHECK(store.check(list).empty());
}

TEST_CASE("golden check: one byte that is not what was approved is corruption",
          "[verify][golden]") {
    const FullStore store;
    const fs::path file = store.golden / "ledgers" / "box.txt";
    std::string text = slurp(file);
    text[text.size() / 2] ^= 1;
    spill(file, text);
    CHECK_THAT(only_finding(store.check()),
               ContainsSubstring("corrupted box ledgers/box.txt") && ContainsSubstring("checksum"));
}

TEST_CASE("golden check: a waiver past its end and one of no case are found", "[verify][golden]") {
    const FullStore store;
    const std::string good = R"({"case": "box", "gate": "pixel", "device": "cuda",
                                 "reason": "known", "expires": "2020-06-15"})";
    store.write_waivers(good);
    CHECK(store.check().empty());  // its last day
    store.write_waivers(replaced(good, "06-15", "06-14"));
    CHECK_THAT(only_finding(store.check()), ContainsSubstring("waiver box") &&
                                                ContainsSubstring("expired on 2020-06-14") &&
                                                ContainsSubstring("known"));
    store.write_waivers(replaced(good, "box", "bax"));
    CHECK_THAT(only_finding(store.check()),
               ContainsSubstring("waiver bax") && ContainsSubstring("no case"));
}

TEST_CASE("golden: a manifest that is not one is refused with file and member",
          "[verify][golden]") {
    const FullStore store;
    const fs::path file = store.golden / "manifest.json";
    const std::string good = slurp(file);
    const auto error = [&](const std::string& text) {
        spill(file, text);
        return error_of([&] { read_manifest(store.golden); });
    };
    CHECK_THAT(error(good.substr(0, 200)),
               ContainsSubstring("manifest.json") && ContainsSubstring("JSON"));
    CHECK_THAT(error(replaced(good, "\"version\": 1", "\"version\": 2")),
               ContainsSubstring("version 1"));
    CHECK_THAT(error(replaced(good, "\"commit\"", "\"comet\"")),
               ContainsSubstring("'commit' is missing"));
    CHECK_THAT(error(replaced(good, "\"name\": \"sky\"", "\"name\": \"box\"")),
               ContainsSubstring("manifest.json"));
    CHECK_THAT(error(replaced(good, "images/box.exr", "../box.exr")),
               ContainsSubstring("not of this case"));
}

TEST_CASE("golden propose: nothing in the golden folder changes, and it may not write there",
          "[verify][golden]") {
    const FullStore store;
    const auto before = contents(store.golden);
    std::vector<GoldenCase> list = cases();
    list[0].image.seed = 3;
    const Proposal changed = store.propose(list[0]);
    CHECK(contents(store.golden) == before);
    CHECK(changed.image == Proposal::Change::changed);
    CHECK(changed.pixels_changed == 12);
    CHECK(changed.largest_z > 0.0);
    CHECK(changed.ledger == Proposal::Change::unchanged);
    CHECK_THAT(changed.reason_to_propose, ContainsSubstring("stale"));
    CHECK_THAT(to_text({changed}), ContainsSubstring("image changed in 12 pixels") &&
                                       ContainsSubstring("scotty golden approve box"));

    const Proposal same = store.propose(cases()[1]);
    CHECK(same.image == Proposal::Change::unchanged);
    CHECK(same.reason_to_propose.empty());
    CHECK(to_json(std::vector<Proposal>{same})[0]["image"] == "unchanged");

    ProposalSettings inside = store.settings();
    inside.output = store.golden / "new";
    CHECK_THAT(error_of([&] { propose_golden(cases()[0], inside); }),
               ContainsSubstring("only approve"));
    CHECK(contents(store.golden) == before);
}

TEST_CASE("golden propose: the same case gives the same bytes", "[verify][golden]") {
    const Store store;
    store.propose(cases()[0]);
    const auto first = contents(store.proposals);
    fs::remove_all(store.proposals);
    store.propose(cases()[0]);
    CHECK(contents(store.proposals) == first);
}

TEST_CASE("golden propose: --ledger-only keeps the image, and asks for one that is there",
          "[verify][golden]") {
    const FullStore store;
    const GoldenCase changed = [] {
        GoldenCase golden = cases()[0];
        golden.image.seed = 99;  // would be another image
        return golden;
    }();
    ProposalSettings settings = store.settings();
    settings.ledger_only = true;
    const Proposal proposal = propose_golden(changed, settings);
    CHECK(proposal.image == Proposal::Change::unchanged);
    CHECK(proposal.ledger == Proposal::Change::unchanged);
    CHECK(slurp(store.proposals / "images" / (changed.name + ".exr")) ==
          slurp(store.golden / "images" / (changed.name + ".exr")));
    fs::remove(store.golden / "images" / (changed.name + ".exr"));
    CHECK_THROWS_WITH(propose_golden(changed, settings),
                      ContainsSubstring("without --ledger-only"));
}

TEST_CASE("golden approve: only the files and the entry of its case change", "[verify][golden]") {
    const FullStore store;
    std::vector<GoldenCase> list = cases();
    list[0].image.seed = 3;
    list[1].image.seed = 3;
    store.propose(list[0]);
    store.propose(list[1]);
    const auto before = contents(store.golden);
    const GoldenEntry other = *read_manifest(store.golden).find("sky");
    store.approve(list[0]);
    const auto after = contents(store.golden);
    REQUIRE(after.size() == before.size());
    std::vector<std::string> changed;
    for (const auto& [file, bytes] : after) {
        if (before.at(file) != bytes) changed.push_back(file);
    }
    CHECK(changed == std::vector<std::string>{"images/box.exr", "manifest.json"});
    const Manifest manifest = read_manifest(store.golden);
    CHECK(to_json(*manifest.find("sky")) == to_json(other));
    CHECK(manifest.find("box")->settings["image"]["seed"] == 3);
}

TEST_CASE("golden approve: without a reason, a proposal, or the proposed files it refuses",
          "[verify][golden]") {
    const FullStore store;
    const auto before = contents(store.golden);
    const auto approve = [&](const GoldenCase& golden_case, const char* reason) {
        return error_of(
            [&] { approve_golden(golden_case, store.golden, store.proposals, reason); });
    };
    CHECK_THAT(approve(cases()[0], " "), ContainsSubstring("--reason"));
    CHECK_THAT(approve(tiny_case("new", "cornell"), "why"),
               ContainsSubstring("no proposal") && ContainsSubstring("scotty golden propose new"));
    GoldenCase other = cases()[0];
    other.image.spp = 5;
    CHECK_THAT(approve(other, "why"), ContainsSubstring("other settings"));
    spill(store.proposals / "images" / "box.exr", "changed since");
    CHECK_THAT(approve(cases()[0], "why"), ContainsSubstring("not the file that was proposed"));
    CHECK(contents(store.golden) == before);
}

TEST_CASE("golden: the files of this tree are whole, of every built-in scene, and small",
          "[verify][golden]") {
    const fs::path golden = find_golden_folder();
    for (const GoldenFinding& finding : check_golden(golden, golden_cases(), "2000-01-01")) {
        FAIL_CHECK(to_string(finding.problem) << " " << finding.name << " " << finding.file << ": "
                                              << finding.text << "; " << finding.way_out);
    }
    std::uintmax_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(golden)) {
        if (entry.is_regular_file()) bytes += entry.file_size();
    }
    CHECK(bytes <= 3u * 1024 * 1024);
}

}  // namespace scotty::verify::test
