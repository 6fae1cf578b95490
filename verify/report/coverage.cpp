#include "verify/report/coverage.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace scotty::verify {

std::string to_text(const Coverage& coverage) {
    return fmt::format(
        "{} cases of {} factors: {} of {} pairs of values, {} of {} triples; {} "
        "golden hashes",
        coverage.cases, coverage.factors.size(), coverage.pairs, coverage.all_pairs,
        coverage.triples, coverage.all_triples, coverage.hashes);
}

nlohmann::json to_json(const Coverage& coverage) {
    nlohmann::json factors = nlohmann::json::object();
    for (const CoverageFactor& factor : coverage.factors) factors[factor.name] = factor.values;
    return {{"cases", coverage.cases},
            {"pairs", {{"covered", coverage.pairs}, {"all", coverage.all_pairs}}},
            {"triples", {{"covered", coverage.triples}, {"all", coverage.all_triples}}},
            {"golden_hashes", coverage.hashes},
            {"factors", factors}};
}

}  // namespace scotty::verify
