/// What is wrong with golden/: missing, orphaned, stale, corrupted, waivers past their end.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "scenes/scenes.h"
#include "verify/golden/golden.h"

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

std::string propose_and_approve(const std::string& name) {
    return fmt::format("scotty golden propose {0}, then scotty golden approve {0} --reason \"...\"",
                       name);
}
std::string restore(const std::string& file) {
    return fmt::format("git checkout golden/{}, or propose and approve it anew", file);
}

/// The first member in which two settings differ, as "image/bounces is 2, expected 3".
std::string difference(const nlohmann::json& found, const nlohmann::json& expected) {
    const nlohmann::json flat_found = found.flatten();
    const nlohmann::json flat_expected = expected.flatten();
    for (const auto& item : flat_expected.items()) {
        const auto other = flat_found.find(item.key());
        if (other == flat_found.end()) {
            return fmt::format("{} is not given, now it is {}", item.key().substr(1),
                               item.value().dump());
        }
        if (*other != item.value()) {
            return fmt::format("{} was {}, now it is {}", item.key().substr(1), other->dump(),
                               item.value().dump());
        }
    }
    return "it has settings that are no more";
}

class FolderCheck {
 public:
    FolderCheck(const fs::path& golden, const std::vector<GoldenCase>& cases)
        : golden_(golden), cases_(cases), manifest_(read_manifest(golden)) {}

    std::vector<GoldenFinding> run(const Date& day) {
        for (const GoldenCase& golden : cases_) check_case(golden);
        for (const GoldenEntry& entry : manifest_.entries) check_has_case(entry);
        check_files();
        check_waivers(day);
        return std::move(findings_);
    }

 private:
    bool is_case(const std::string& name) const {
        return std::any_of(cases_.begin(), cases_.end(),
                           [&](const GoldenCase& golden) { return golden.name == name; });
    }

    void check_case(const GoldenCase& golden) {
        const GoldenEntry* entry = manifest_.find(golden.name);
        if (entry == nullptr) {
            findings_.push_back({GoldenProblem::missing, golden.name, "",
                                 "the manifest has no entry for this case",
                                 propose_and_approve(golden.name)});
            return;
        }
        const nlohmann::json expected = settings_of(golden, scenes::load_scene(golden.scene));
        if (const nlohmann::json found = entry->settings; found != expected) {
            findings_.push_back({GoldenProblem::stale, golden.name, "",
                                 "was made for other settings: " + difference(found, expected),
                                 propose_and_approve(golden.name)});
        }
        for (const fs::path& file : {image_path(golden.name), ledger_path(golden.name)}) {
            check_file(*entry, file);
        }
    }

    void check_file(const GoldenEntry& entry, const std::string& file) {
        const auto listed = entry.files.find(file);
        std::error_code ignored;
        if (listed == entry.files.end()) {
            findings_.push_back({GoldenProblem::missing, entry.name, file,
                                 "its entry does not list this file",
                                 propose_and_approve(entry.name)});
        } else if (!fs::is_regular_file(golden_ / file, ignored)) {
            findings_.push_back({GoldenProblem::missing, entry.name, file,
                                 "the manifest lists this file, and it is not there",
                                 restore(file)});
        } else if (const std::string found = checksum(golden_ / file); found != listed->second) {
            findings_.push_back(
                {GoldenProblem::corrupted, entry.name, file,
                 fmt::format("its checksum is {}, the manifest says {}", found, listed->second),
                 restore(file)});
        }
    }

    void check_has_case(const GoldenEntry& entry) {
        if (is_case(entry.name)) return;
        if (entry.name == kHashesName) return check_file(entry, kHashesFile);
        findings_.push_back({GoldenProblem::orphaned, entry.name, "",
                             "the manifest has an entry for a case that is no more",
                             "remove the entry and its files"});
    }

    void check_files() {
        std::set<std::string> known{"README.md", "manifest.json", "waivers.json"};
        for (const GoldenEntry& entry : manifest_.entries) {
            for (const auto& [file, sum] : entry.files) known.insert(file);
        }
        std::set<std::string> orphans;
        for (const auto& found : fs::recursive_directory_iterator(golden_)) {
            if (found.is_directory()) continue;
            const std::string file = fs::relative(found.path(), golden_).generic_string();
            if (!known.contains(file)) orphans.insert(file);
        }
        for (const std::string& file : orphans) {
            findings_.push_back({GoldenProblem::orphaned, "", file,
                                 "no entry of the manifest lists this file",
                                 fmt::format("rm golden/{}", file)});
        }
    }

    void check_waivers(const Date& day) {
        for (const Waiver& waiver : read_waivers(golden_)) {
            if (waiver.has_expired(day)) {
                findings_.push_back(
                    {GoldenProblem::waiver, waiver.golden, "waivers.json",
                     fmt::format("{} expired on {}", to_string(waiver), waiver.expires),
                     "mend the fault and remove the waiver, or give it a new end and say why"});
            }
            if (!is_case(waiver.golden)) {
                findings_.push_back({GoldenProblem::waiver, waiver.golden, "waivers.json",
                                     to_string(waiver) + " is of no case that there is",
                                     "remove it"});
            }
        }
    }

    const fs::path& golden_;
    const std::vector<GoldenCase>& cases_;
    Manifest manifest_;
    std::vector<GoldenFinding> findings_;
};

}  // namespace

std::vector<GoldenFinding> check_golden(const fs::path& golden,
                                        const std::vector<GoldenCase>& cases, const Date& today) {
    return FolderCheck(golden, cases).run(today);
}

}  // namespace scotty::verify
