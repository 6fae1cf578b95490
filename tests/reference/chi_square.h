/// Do counts follow expected frequencies? For the tests of every sampling routine.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scotty::reference::test {

/// Pearson's statistic as a standard normal number (Wilson and Hilferty 1931, good to a percent of
/// a deviation from 10 degrees of freedom on): large where counts do not follow, far below zero
/// where they follow too well to be random. Cells of equal expectation.
inline double chi_square_z(const std::vector<std::uint32_t>& counts) {
    double total = 0.0;
    for (const std::uint32_t count : counts) total += count;
    const double expected = total / static_cast<double>(counts.size());
    double chi2 = 0.0;
    for (const std::uint32_t count : counts) {
        chi2 += (count - expected) * (count - expected) / expected;
    }
    const double freedom = static_cast<double>(counts.size()) - 1.0;
    const double spread = 2.0 / (9.0 * freedom);
    return (std::cbrt(chi2 / freedom) - (1.0 - spread)) / std::sqrt(spread);
}

/// Counts of points of the unit square in n x n equal cells. A routine whose points should be
/// uniform after a change of variables is tested by it.
class SquareCells {
 public:
    explicit SquareCells(std::size_t n) : n_(n), counts_(n * n) {}
    void add(double u, double v) { ++counts_[index(u) * n_ + index(v)]; }
    double z() const { return chi_square_z(counts_); }

 private:
    std::size_t index(double x) const {
        return static_cast<std::size_t>(
            std::clamp(x * static_cast<double>(n_), 0.0, static_cast<double>(n_) - 1.0));
    }
    std::size_t n_;
    std::vector<std::uint32_t> counts_;
};

/// Two-sided, one in 150,000: seeds are fixed, so a test passes always or never.
inline bool follows(double z) { return std::abs(z) < 4.5; }

}  // namespace scotty::reference::test
