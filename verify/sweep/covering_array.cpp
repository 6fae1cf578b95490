#include "verify/sweep/covering_array.h"

#include <numeric>
#include <utility>

#include "reference/base/assert.h"

namespace scotty::verify {

namespace {

constexpr std::size_t kOpen = ~std::size_t{0};
constexpr std::size_t kCandidates = 12;

/// The combinations of values of `strength` factors, and which of them stand in no row yet.
class Tuples {
 public:
    Tuples(std::vector<std::size_t> sizes, std::size_t strength)
        : sizes_(std::move(sizes)), strength_(strength) {
        std::vector<std::size_t> factors;
        add_factors(factors, 0);
        missing_.assign(begin_.back().second, true);
        left_ = missing_.size();
    }

    std::uint64_t all() const { return missing_.size(); }
    std::uint64_t left() const { return left_; }

    /// Sets the values of the first combination that is missing.
    void seed(Row& row) {
        while (!missing_[first_]) ++first_;
        std::size_t combination = 0;
        while (begin_[combination + 1].second <= first_) ++combination;
        std::size_t rest = first_ - begin_[combination].second;
        const std::vector<std::size_t>& factors = begin_[combination].first;
        for (std::size_t k = factors.size(); k-- > 0;) {
            row[factors[k]] = rest % sizes_[factors[k]];
            rest /= sizes_[factors[k]];
        }
    }
    /// Combinations that are missing, have the factor in them, and whose values are all set.
    std::size_t gain(const Row& row, std::size_t factor) const {
        std::size_t sum = 0;
        for (const std::size_t combination : with_factor_[factor]) {
            const std::size_t place = place_of(row, combination);
            sum += place != kOpen && missing_[place] ? 1 : 0;
        }
        return sum;
    }
    /// Takes what stands in the row off the list. Returns how many were missing.
    std::size_t cover(const Row& row) {
        const std::uint64_t before = left_;
        for (std::size_t combination = 0; combination + 1 < begin_.size(); ++combination) {
            const std::size_t place = place_of(row, combination);
            if (place == kOpen || !missing_[place]) continue;
            missing_[place] = false;
            --left_;
        }
        return before - left_;
    }
    std::size_t would_cover(const Row& row) const {
        std::size_t sum = 0;
        for (std::size_t combination = 0; combination + 1 < begin_.size(); ++combination) {
            sum += missing_[place_of(row, combination)] ? 1 : 0;
        }
        return sum;
    }

 private:
    void add_factors(std::vector<std::size_t>& factors, std::size_t from) {
        if (with_factor_.empty()) with_factor_.resize(sizes_.size());
        if (begin_.empty()) begin_.push_back({{}, 0});
        if (factors.size() == strength_) {
            std::size_t values = 1;
            for (const std::size_t f : factors) {
                values *= sizes_[f];
                with_factor_[f].push_back(begin_.size() - 1);
            }
            begin_.back().first = factors;
            begin_.push_back({{}, begin_.back().second + values});
            return;
        }
        for (std::size_t f = from; f < sizes_.size(); ++f) {
            factors.push_back(f);
            add_factors(factors, f + 1);
            factors.pop_back();
        }
    }
    std::size_t place_of(const Row& row, std::size_t combination) const {
        std::size_t place = 0;
        for (const std::size_t f : begin_[combination].first) {
            if (row[f] == kOpen) return kOpen;
            place = place * sizes_[f] + row[f];
        }
        return begin_[combination].second + place;
    }

    std::vector<std::size_t> sizes_;
    std::size_t strength_;
    /// Factors, and where their values' combinations begin; an end without factors.
    std::vector<std::pair<std::vector<std::size_t>, std::size_t>> begin_;
    std::vector<std::vector<std::size_t>> with_factor_;
    std::vector<bool> missing_;
    std::uint64_t left_ = 0;
    std::size_t first_ = 0;
};

/// Numerical Recipes' linear congruential generator, by its upper bits.
struct Lottery {
    std::uint64_t state = 1;
    std::size_t below(std::size_t end) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        return static_cast<std::size_t>(state >> 33) % end;
    }
};

/// The open values one after the other, each the one that covers most with those that are set.
void fill(Row& row, const std::vector<std::size_t>& sizes, const Tuples& tuples, Lottery& lottery) {
    std::vector<std::size_t> order(sizes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[lottery.below(i)]);
    for (const std::size_t f : order) {
        if (row[f] != kOpen) continue;
        const std::size_t first = lottery.below(sizes[f]);  // of those that cover as much
        std::size_t best = first;
        std::size_t most = 0;
        for (std::size_t k = 0; k < sizes[f]; ++k) {
            row[f] = (first + k) % sizes[f];
            const std::size_t gain = tuples.gain(row, f);
            if (gain <= most) continue;
            most = gain;
            best = row[f];
        }
        row[f] = best;
    }
}

}  // namespace

std::vector<Row> product_rows(const std::vector<std::size_t>& sizes) {
    std::vector<Row> rows{{}};
    for (const std::size_t size : sizes) {
        std::vector<Row> longer;
        longer.reserve(rows.size() * size);
        for (const auto& row : rows) {
            for (std::size_t value = 0; value < size; ++value) {
                longer.push_back(row);
                longer.back().push_back(value);
            }
        }
        rows = std::move(longer);
    }
    return rows;
}

std::vector<Row> covering_rows(const std::vector<std::size_t>& sizes, std::size_t strength) {
    SCOTTY_ASSERT(strength, >=, std::size_t{1});
    if (sizes.size() <= strength) return product_rows(sizes);
    Tuples tuples(sizes, strength);
    Lottery lottery;
    std::vector<Row> rows;
    while (tuples.left() != 0) {
        Row best;
        std::size_t most = 0;
        for (std::size_t candidate = 0; candidate < kCandidates; ++candidate) {
            Row row(sizes.size(), kOpen);
            tuples.seed(row);
            fill(row, sizes, tuples, lottery);
            const std::size_t covers = tuples.would_cover(row);
            if (covers <= most) continue;
            most = covers;
            best = std::move(row);
        }
        tuples.cover(best);
        rows.push_back(std::move(best));
    }
    return rows;
}

Covered covered_by(const std::vector<std::size_t>& sizes, const std::vector<Row>& rows,
                   std::size_t strength) {
    Tuples tuples(sizes, strength);
    for (const Row& row : rows) tuples.cover(row);
    return {tuples.all() - tuples.left(), tuples.all()};
}

}  // namespace scotty::verify
