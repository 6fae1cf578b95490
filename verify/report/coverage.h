/// Which combinations of values a verification has run.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace scotty::verify {

struct CoverageFactor {
    std::string name;
    std::vector<std::string> values;
};

/// Of the cases of a covering array (verify/sweep/cases.h).
struct Coverage {
    std::uint64_t cases = 0;
    std::uint64_t pairs = 0;      ///< of values of two factors that stand together in some case
    std::uint64_t all_pairs = 0;  ///< that there are
    std::uint64_t triples = 0;
    std::uint64_t all_triples = 0;
    std::uint64_t hashes = 0;  ///< golden ones that the runs were held against
    std::vector<CoverageFactor> factors;
};

/// "87 cases of 19 factors: 3120 of 3120 pairs of values, 41200 of 72000 triples;
/// 512 golden hashes".
std::string to_text(const Coverage& coverage);
nlohmann::json to_json(const Coverage& coverage);

}  // namespace scotty::verify
