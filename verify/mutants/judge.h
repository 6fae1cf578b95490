/// Which check caught a planted fault, and whether it is the one that should have.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "verify/mutants/processes.h"
#include "verify/report/mutant_report.h"

namespace scotty::verify {

/// "data-race", "divergence", "out-of-bounds", "unwritten-memory", "bad-address", "capacity", or
/// "error" for anything else.
std::string kind_of_error(const std::string& says);

/// A fault that is not in the program is not caught, whatever its command said.
MutantResult judge(const PlantedFault& fault, const ProcessOutcome& outcome);
HostileResult judge(const HostileCondition& condition, const ProcessOutcome& outcome);

}  // namespace scotty::verify
