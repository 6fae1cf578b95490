/// Covering arrays: few rows in which all values of any two (or three) factors meet.
///
/// Cohen, Dalal, Fredman, Patton: "The AETG system: an approach to testing based on combinatorial
/// design" (1997): each row is the best of several greedy candidates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scotty::verify {

/// One value index a factor.
using Row = std::vector<std::size_t>;

/// Rows of value indices, one entry a factor (sizes[f] values), such that all values of every
/// `strength` factors (2 or 3) stand together in some row. Deterministic; near the least number.
/// The first rows cover most. With fewer factors than that: all combinations.
std::vector<Row> covering_rows(const std::vector<std::size_t>& sizes, std::size_t strength = 2);

/// How many combinations of values of `strength` factors there are, and how many the rows hold.
struct Covered {
    std::uint64_t covered = 0;
    std::uint64_t all = 0;
};
Covered covered_by(const std::vector<std::size_t>& sizes, const std::vector<Row>& rows,
                   std::size_t strength);

/// Every combination: the last factor runs fastest.
std::vector<Row> product_rows(const std::vector<std::size_t>& sizes);

}  // namespace scotty::verify
