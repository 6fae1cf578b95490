#include "tests/properties.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "verify/sweep/configurations.h"
#include "verify/sweep/covering_array.h"

namespace {

using namespace scotty::verify;
using namespace scotty::reference;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("covering rows: every pair of values of any factors stands in some row",
          "[verify][configurations]") {
    scotty::tests::check_property("pairs are covered, rows are few", [] {
        const auto sizes =
            *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(1, 5));
        RC_PRE(sizes.size() <= 8u);
        const auto rows = covering_rows(sizes);
        for (std::size_t f = 0; f < sizes.size(); ++f) {
            for (std::size_t g = f + 1; g < sizes.size(); ++g) {
                std::set<std::pair<std::size_t, std::size_t>> pairs;
                for (const auto& row : rows) {
                    RC_ASSERT(row.size() == sizes.size());
                    RC_ASSERT(row[f] < sizes[f]);
                    pairs.insert({row[f], row[g]});
                }
                RC_ASSERT(pairs.size() == sizes[f] * sizes[g]);
            }
        }
        RC_ASSERT(rows.size() <= 32u);  // two of the largest factors need 16
    });
    CHECK(covering_rows({}).size() == 1);
    CHECK(covering_rows({3}).size() == 3);
}

TEST_CASE("configurations: by default every pair of values, and one run in small odd batches",
          "[verify][configurations]") {
    const auto all = configurations(PipelineParameters{}, {});
    CHECK(all.size() >= 17);
    CHECK(all.size() <= 26);
    std::set<int> widths;
    std::set<std::pair<EarlyOut, HitMode>> pairs;
    bool small_batches = false;
    bool grows = false;
    std::set<std::string> schedules;
    std::set<std::string> labels;
    for (const Configuration& c : all) {
        widths.insert(c.parameters.width);
        pairs.insert({c.parameters.early_out, c.parameters.hit_mode});
        schedules.insert(to_string(c.schedule));
        labels.insert(c.label());
        small_batches = small_batches || c.parameters.batch_rays % 2 == 1;
        grows =
            grows || (c.parameters.hit_capacity == 1 && c.parameters.hit_mode == HitMode::buffer);
    }
    CHECK(widths == std::set<int>{2, 4, 8, 16});
    CHECK(pairs.size() == 6);
    CHECK(schedules == std::set<std::string>{"free", "linear", "shuffle:0"});
    CHECK(labels.size() == all.size());
    CHECK(small_batches);
    CHECK(grows);
}

TEST_CASE("configurations: filters select all combinations of the values asked for",
          "[verify][configurations]") {
    ConfigurationFilter filter;
    filter.widths = {8, 16};
    filter.early_out = {EarlyOut::level, EarlyOut::immediate};
    std::map<std::pair<int, EarlyOut>, int> count;
    for (const Configuration& c : configurations(PipelineParameters{}, filter)) {
        ++count[{c.parameters.width, c.parameters.early_out}];
    }
    CHECK(count.size() == 4);
    for (const auto& [combination, configurations] : count) CHECK(configurations > 1);
}

TEST_CASE("configurations: with every parameter given there is exactly one",
          "[verify][configurations]") {
    ConfigurationFilter filter;
    filter.widths = {4};
    filter.rays_per_block = {96};
    filter.queue_levels = {3};
    filter.queues = {QueueKind::pairs};
    filter.early_out = {EarlyOut::immediate};
    filter.hit_mode = {HitMode::buffer};
    filter.block_order = {BlockOrder::strided};
    filter.shadow_query = {ShadowQuery::any};
    filter.hit_capacity = {3};
    filter.batch_rays = {1001};
    filter.schedule = {Schedule{scotty::emulation::ScheduleKind::reversed, 0}};
    const auto all = configurations(PipelineParameters{}, filter);
    REQUIRE(all.size() == 1);
    CHECK(all[0].options() ==
          "--width 4 --rays-per-block 96 --leaf-size 4 --queue-levels 3 --queues pairs "
          "--early-out immediate --block-order strided --hit-mode buffer --shadow-query any "
          "--hit-capacity 3 "
          "--batch-rays 1001 --samples-per-pass 0 --schedule reversed");
    CHECK(all[0].device(5).threads == 1);
    CHECK(all[0].device(5).schedule == scotty::emulation::ScheduleKind::reversed);
}

TEST_CASE("configurations: with --all, every combination", "[verify][configurations]") {
    ConfigurationFilter filter;
    filter.all = true;
    CHECK(configurations(PipelineParameters{}, filter).size() ==
          4u * 4 * 4 * 3 * 2 * 2 * 2 * 2 + 1);
}

TEST_CASE("configurations: a value that no pipeline takes is refused", "[verify][configurations]") {
    ConfigurationFilter filter;
    filter.widths = {3};
    CHECK_THROWS_WITH(configurations(PipelineParameters{}, filter), ContainsSubstring("found 3"));
}

}  // namespace
