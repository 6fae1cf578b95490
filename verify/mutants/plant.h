/// --plant NAME: the same command with a fault in the kernels, run by the program that has all of
/// them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "verify/report/mutant_report.h"

namespace scotty::verify {

/// The faults of the running program: a registry as JSON, and a function that switches one on.
struct PlantedFaults {
    std::string registry;
    std::function<void(int number)> switch_on;
};
/// Called by main() of scotty-mutants, and by tests. Every other program has no faults.
void offer_planted_faults(PlantedFaults faults);
bool has_planted_faults();

/// All of them, in the registry's order. Throws internal if the registry is malformed.
std::vector<PlantedFault> planted_faults();
std::vector<HostileCondition> hostile_conditions();

/// Plants a fault for whatever this process runs from now on; a program without faults first
/// restarts as scotty-mutants. Throws bad_input for an unknown name, and if the fault is not in the
/// kernels of `backend`.
void plant(const std::string& name, const std::string& backend);

}  // namespace scotty::verify
