/// Small runs that between them cover every parameter and scene property which code depends on.
///
/// A case is one probe scene (scenes/probe.h) in one configuration of picture and pipeline. The
/// cases are the rows of a covering array: all values of any two factors meet in some case.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "verify/report/coverage.h"
#include "verify/sweep/configurations.h"

namespace scotty::verify {

/// One thing that varies over the cases.
struct CaseFactor {
    std::string name;
    std::vector<std::string> values;  ///< what each is called
    /// Members of PipelineParameters that it sets, as they are called in JSON; empty for a property
    /// of the scene and for the schedule.
    std::vector<std::string> parameters;
};
std::vector<CaseFactor> case_factors();

/// A member of PipelineParameters that no factor varies.
struct Exemption {
    std::string parameter;
    std::string reason;
};
std::vector<Exemption> case_exemptions();

struct Case {
    std::string scene;  ///< what load_scene() takes
    std::string label;  ///< scene and picture in words; Configuration::label() has the rest
    Configuration configuration;
};

/// How much is run.
enum class Budget {
    quick,     ///< the first cases, which hold most pairs
    standard,  ///< all pairs of values
    thorough   ///< all triples
};

struct CaseList {
    std::vector<Case> cases;  ///< the most telling first
    Coverage coverage;
};
CaseList covering_cases(Budget budget);

}  // namespace scotty::verify
