#include "verify/mutants/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <regex>
#include <utility>

#include "verify/base/exit_code.h"

namespace scotty::verify {

namespace {

std::string first_match(const std::string& text, const char* pattern) {
    std::smatch match;
    return std::regex_search(text, match, std::regex(pattern)) ? match.str(0) : std::string();
}

std::string last_line(const std::string& text) {
    const std::size_t end = text.find_last_not_of('\n');
    if (end == std::string::npos) return {};
    const std::size_t begin = text.find_last_of('\n', end);
    return text.substr(begin == std::string::npos ? 0 : begin + 1,
                       end - (begin == std::string::npos ? std::size_t(-1) : begin));
}

/// Removes from paths what precedes the project's folders.
std::string shorten(const std::string& text) {
    return std::regex_replace(
        text, std::regex(R"([\w./-]*/((gpu|emulation|reference)(/\w+)+\.\w+:))"), "$1");
}

std::string place_of(const nlohmann::json& failure, const std::string& says) {
    std::string place = first_match(says, R"((gpu|emulation)(/\w+)+\.\w+:\d+)");
    for (const char* name : {"node", "block", "ray"}) {
        if (!failure.contains(name) || !failure[name].is_number()) continue;
        place += fmt::format("{}{} {}", place.empty() ? "" : ", ", name,
                             failure[name].get<std::uint64_t>());
    }
    return place;
}

/// The leading failure of the report of `scotty verify`.
MutantCatch leading_failure(const nlohmann::json& report) {
    MutantCatch found;
    const auto& failures = report.at("failures");
    if (failures.empty()) return found;
    const auto& first = failures.front();
    for (const auto& failure : failures) found.checks.push_back(failure.at("invariant"));
    found.check = first.at("invariant");
    found.stage = first.at("stage");
    if (first.at("launch").is_number()) found.launch = first.at("launch");
    found.says = shorten(first.at("sentence").get<std::string>());
    const std::string by = shorten(first.at("written_by").get<std::string>());
    if (!by.empty()) found.says += "; written by " + by;
    found.place = place_of(first, by.empty() ? found.says : by);
    if (found.check == "error") {
        found.check = kind_of_error(found.says);
        const std::string named =
            first_match(found.says, R"((batch\d+/)?(bounce\d+/)(light\d+/)?(level\d+/)?[a-z_]+)");
        if (!named.empty()) found.stage = named;
        // The run ended there: as many stages were judged as launches came before it.
        for (const auto& scene : report.at("scenes")) {
            for (const auto& one : scene.at("configurations")) found.launch = one.at("stages");
        }
    }
    return found;
}

/// The catch of a process that ended before it could report.
MutantCatch last_words(const ProcessOutcome& outcome) {
    MutantCatch found;
    found.says = shorten(last_line(outcome.errors));
    if (outcome.timed_out) {
        found.check = "time-limit";
    } else if (outcome.signal != 0) {
        found.check = kind_of_error(found.says);
        if (found.says.empty()) found.says = ::strsignal(outcome.signal);
    } else {
        found.check = kind_of_error(found.says);
    }
    std::smatch kernel;
    const std::regex named(R"(kernel (\w+))");
    if (std::regex_search(found.says, kernel, named)) found.stage = kernel.str(1);
    found.place = place_of(nlohmann::json::object(), found.says);
    return found;
}

MutantCatch what_was_found(const ProcessOutcome& outcome) {
    if (outcome.exit_code == kExitPassed) return {};
    const auto report = nlohmann::json::parse(outcome.output, nullptr, false);
    if (outcome.exit_code == kExitFailed && report.is_object()) return leading_failure(report);
    return last_words(outcome);
}

}  // namespace

std::string kind_of_error(const std::string& says) {
    static const std::pair<const char*, const char*> kinds[] = {
        {"data race on", "data-race"},
        {"nobody has written", "unwritten-memory"},
        {"out of bounds", "out-of-bounds"},
        {"its threads part", "divergence"},
        {"with a mask that it is not in", "divergence"},
        {"reached memory that is not there", "bad-address"},
        {"were pushed to it", "capacity"}};
    for (const auto& [words, kind] : kinds) {
        if (says.find(words) != std::string::npos) return kind;
    }
    return "error";
}

MutantResult judge(const PlantedFault& fault, const ProcessOutcome& outcome) {
    if (!fault.unapplied.empty()) {
        return {fault, {}, 0.0, "does not apply any more: " + fault.unapplied};
    }
    MutantResult result{fault, what_was_found(outcome), outcome.seconds, ""};
    const MutantCatch& found = result.found;
    const ExpectedCatch& expect = fault.expect;
    if (found.check.empty()) {
        result.why_not = "nothing was found";
    } else if (found.check != expect.check) {
        result.why_not = fmt::format("expected to be found by {}", expect.check);
    } else if (!std::regex_match(found.stage, std::regex(expect.stage))) {
        result.why_not = fmt::format("expected at {}", expect.stage);
    } else if (!std::regex_search(found.says, std::regex(expect.says))) {
        result.why_not = fmt::format("expected to say {}", expect.says);
    }
    for (const std::string& check : expect.also) {
        const bool fails =
            std::find(found.checks.begin(), found.checks.end(), check) != found.checks.end();
        if (!fails && result.caught()) result.why_not = fmt::format("expected {} to fail", check);
    }
    return result;
}

HostileResult judge(const HostileCondition& condition, const ProcessOutcome& outcome) {
    HostileResult result{condition, outcome.seconds, ""};
    if (outcome.exit_code == kExitPassed) return result;
    const MutantCatch found = what_was_found(outcome);
    result.failure = fmt::format("[{}] {}: {}", found.check, found.stage, found.says);
    return result;
}

}  // namespace scotty::verify
