/// --plant NAME: the same command with a fault in the kernels, run by the program that has them
/// all.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace scotty::verify {

/// What has to find a fault.
struct ExpectedCatch {
    std::string check;              ///< MutantCatch::check (verify/mutants/judge.h)
    std::string stage;              ///< as a regular expression, of the whole name
    std::string says;               ///< the same of a part of what is said; empty: anything
    std::vector<std::string> also;  ///< checks that have to fail besides
};

struct PlantedFault {
    int number = 0;  ///< of its switch
    std::string name;
    std::string what;    ///< in one sentence
    std::string file;    ///< from the project's root: "gpu/kernels/intersect.h"
    std::string defect;  ///< of a published program that had it; mostly empty
    std::string run;     ///< the arguments of the command that has to catch it
    ExpectedCatch expect;

    /// Of the back end whose kernels have it.
    std::string backend() const { return file.starts_with("gpu/") ? "simt" : "emulator"; }
};

/// Nothing is planted, but little room, odd sizes or a strange order: it has to pass.
struct HostileCondition {
    std::string name;
    std::string what;
    std::string run;
};

/// The faults of the running program: a registry as JSON, and what switches one on.
struct PlantedFaults {
    std::string registry;
    std::function<void(int number)> switch_on;
};
/// Called by main() of scotty-mutants, and by tests. Every other program has no faults.
void offer_planted_faults(PlantedFaults faults);
bool has_planted_faults();

/// All of them, in the registry's order. Throws internal where it is not as it should be.
std::vector<PlantedFault> planted_faults();
std::vector<HostileCondition> hostile_conditions();

/// Plants a fault for whatever this process runs from now on; in a program without any, goes on as
/// scotty-mutants first. Throws bad_input for a name that there is not, and where the fault is not
/// in the kernels of `backend`.
void plant(const std::string& name, const std::string& backend);

}  // namespace scotty::verify
