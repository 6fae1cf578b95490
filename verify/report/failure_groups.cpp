#include "verify/report/failure_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <utility>

namespace scotty::verify {

namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string number_of(std::size_t count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace

std::string stage_family(const std::string& stage) {
    if (stage.find('/') == std::string::npos) return stage;
    std::string family;
    const std::size_t begin = stage.starts_with("batch") ? stage.find('/') + 1 : 0;
    for (const char c : stage.substr(begin)) {
        if (!is_digit(c)) {
            family += c;
        } else if (family.empty() || family.back() != '*') {
            family += '*';
        }
    }
    return family;
}

std::vector<FailureGroup> failure_groups(const std::vector<PlacedFailure>& failures) {
    std::vector<FailureGroup> groups;
    std::map<std::pair<std::string, std::string>, std::size_t> known;
    std::vector<std::set<std::pair<std::string, std::string>>> runs;
    for (std::size_t i = 0; i < failures.size(); ++i) {
        const PlacedFailure& placed = failures[i];
        const std::string family = stage_family(placed.failure.stage);
        const auto [at, is_new] =
            known.try_emplace({placed.failure.invariant, family}, groups.size());
        if (is_new) {
            groups.push_back({placed.failure.invariant, family, {}, {}, 0});
            runs.emplace_back();
        }
        FailureGroup& group = groups[at->second];
        group.members.push_back(i);
        const auto& scenes = group.scenes;
        if (std::find(scenes.begin(), scenes.end(), placed.scene) == scenes.end()) {
            group.scenes.push_back(placed.scene);
        }
        runs[at->second].emplace(placed.scene, placed.configuration);
        group.configurations = runs[at->second].size();
    }
    return groups;
}

std::string to_text(const PlacedFailure& placed) {
    std::string text = fmt::format("scene {}, {}\n  {}\n", placed.scene, placed.configuration,
                                   to_string(placed.failure));
    if (!placed.replay.empty()) text += fmt::format("  show it again: {}\n", placed.replay);
    if (!placed.approve.empty()) {
        text += fmt::format("  if the new image is right: {}\n", placed.approve);
    }
    return text;
}

std::string to_text(const std::vector<FailureGroup>& groups) {
    std::size_t all = 0;
    for (const FailureGroup& group : groups) all += group.members.size();
    if (all < 2) return "";
    std::string text = fmt::format("\n{}, by invariant and stage:\n", number_of(all, "failure"));
    for (const FailureGroup& group : groups) {
        text += fmt::format("{:>7}  {:<20} {:<36}  {}\n", group.members.size(), group.invariant,
                            group.stage, number_of(group.scenes.size(), "scene"));
    }
    return text;
}

}  // namespace scotty::verify
