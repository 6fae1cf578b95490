#include "verify/mutants/plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "reference/base/error.h"
#include "verify/backends/checked_program.h"

namespace scotty::verify {

using reference::Error;

namespace {

PlantedFaults& offered() {
    static PlantedFaults faults;
    return faults;
}

void for_each_entry(const char* list, const std::function<void(const nlohmann::json&)>& take) {
    std::size_t entry = 0;
    try {
        const auto registry = nlohmann::json::parse(offered().registry);
        for (const auto& one : registry.at(list)) {
            ++entry;
            take(one);
        }
    } catch (const nlohmann::json::exception& error) {
        throw Error::internal(
            fmt::format("registry of planted faults, {} {}: {}", list, entry, error.what()));
    }
}

}  // namespace

void offer_planted_faults(PlantedFaults faults) { offered() = std::move(faults); }

bool has_planted_faults() { return offered().switch_on != nullptr; }

std::vector<PlantedFault> planted_faults() {
    std::vector<PlantedFault> faults;
    for_each_entry("faults", [&](const nlohmann::json& entry) {
        PlantedFault& fault = faults.emplace_back();
        fault.number = static_cast<int>(faults.size());
        fault.name = entry.at("name");
        fault.what = entry.at("what");
        fault.file = entry.at("file");
        fault.defect = entry.value("defect", "");
        fault.run = entry.at("run");
        fault.unapplied = entry.value("unapplied", "");
        const auto& expect = entry.at("expect");
        fault.expect = {expect.at("check"), expect.at("stage"), expect.value("says", ""),
                        expect.value("also", std::vector<std::string>())};
    });
    return faults;
}

std::vector<HostileCondition> hostile_conditions() {
    std::vector<HostileCondition> conditions;
    for_each_entry("hostile", [&](const nlohmann::json& entry) {
        conditions.push_back({entry.at("name"), entry.at("what"), entry.at("run")});
    });
    return conditions;
}

void plant(const std::string& name, const std::string& backend) {
    if (!has_planted_faults()) {
        become_program("scotty-mutants", "--plant");
        return;
    }
    const auto faults = planted_faults();
    const auto found = std::find_if(faults.begin(), faults.end(),
                                    [&](const PlantedFault& fault) { return fault.name == name; });
    if (found == faults.end()) {
        throw Error::bad_input(
            "--plant",
            fmt::format("'{}' is no fault; scotty mutants --list has their names", name));
    }
    if (!found->unapplied.empty()) {
        throw Error::bad_input("--plant",
                               fmt::format("{} does not apply any more: {} (verify/mutants/"
                                           "registry.json)",
                                           name, found->unapplied));
    }
    if (!found->is_of(backend)) {
        throw Error::bad_input("--plant", fmt::format("{} is in {}: it needs --backend {}", name,
                                                      found->file, found->backend()));
    }
    offered().switch_on(found->number);
}

}  // namespace scotty::verify
