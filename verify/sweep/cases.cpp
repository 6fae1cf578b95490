#include "verify/sweep/cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "scenes/probe.h"
#include "verify/sweep/covering_array.h"

namespace scotty::verify {

using emulation::ScheduleKind;
using reference::BlockOrder;
using reference::EarlyOut;
using reference::Filter;
using reference::HitMode;
using reference::PipelineParameters;
using reference::QueueKind;
using reference::ShadowQuery;

namespace {

/// A case while its factors are applied, one after the other.
struct Draft {
    std::size_t geometry = 0;
    std::size_t lights = 0;
    std::size_t camera = 0;
    Configuration configuration;

    PipelineParameters& p() { return configuration.parameters; }
};

struct DraftValue {
    std::string name;
    std::function<void(Draft&)> set;
};

struct DraftFactor {
    std::string name;
    std::vector<std::string> parameters;
    std::vector<DraftValue> values;
};

template <class T>
DraftFactor numbers(const char* name, T PipelineParameters::*member, const std::vector<T>& values) {
    DraftFactor factor{name, {name}, {}};
    for (const T value : values) {
        factor.values.push_back(
            {fmt::format("{}", value), [member, value](Draft& d) { d.p().*member = value; }});
    }
    return factor;
}

template <class Enum>
DraftFactor words(const char* name, Enum PipelineParameters::*member,
                  const std::vector<Enum>& values) {
    DraftFactor factor{name, {name}, {}};
    for (const Enum value : values) {
        factor.values.push_back(
            {to_string(value), [member, value](Draft& d) { d.p().*member = value; }});
    }
    return factor;
}

DraftFactor scene_factor(const char* name, std::size_t Draft::*member,
                         const std::vector<std::string>& names) {
    DraftFactor factor{name, {}, {}};
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (member == &Draft::geometry && i == scenes::probe_field()) continue;
        factor.values.push_back({names[i], [member, i](Draft& d) { d.*member = i; }});
    }
    return factor;
}

DraftFactor image_size() {
    DraftFactor factor{"image size", {"image_width", "image_height"}, {}};
    for (const auto& [width, height] :
         {std::pair{1u, 1u}, {1u, 7u}, {9u, 1u}, {2u, 2u}, {5u, 3u}, {3u, 11u}}) {
        factor.values.push_back(
            {fmt::format("{}x{}", width, height), [w = width, h = height](Draft& d) {
                 d.p().image_width = w;
                 d.p().image_height = h;
             }});
    }
    return factor;
}

/// In terms of the samples, which are set by now: half of them, rounded up, leaves a last pass that
/// is short where their number is odd.
DraftFactor samples_per_pass() {
    return {"samples per pass",
            {"samples_per_pass"},
            {{"all", [](Draft& d) { d.p().samples_per_pass = 0; }},
             {"1", [](Draft& d) { d.p().samples_per_pass = 1; }},
             {"more than half", [](Draft& d) { d.p().samples_per_pass = d.p().spp / 2 + 1; }},
             {"a third", [](Draft& d) { d.p().samples_per_pass = d.p().spp / 3 + 1; }},
             {"more than there are", [](Draft& d) { d.p().samples_per_pass = d.p().spp + 5; }}}};
}

std::uint32_t pass_of(Draft& d) { return reference::samples_of_pass(d.p()); }

/// In terms of pass and image: smaller than a pass, so that a pixel's samples are parted; the
/// samples of several pixels and a few more; of all but one pixel; of everything.
DraftFactor rays_per_batch() {
    return {"rays per batch",
            {"batch_rays"},
            {{"65536", [](Draft& d) { d.p().batch_rays = 65536; }},
             // Of a pass of one sample only so many rays that there are no hundreds of batches.
             {"half a pass",
              [](Draft& d) {
                  const std::uint32_t pixels = d.p().image_width * d.p().image_height;
                  d.p().batch_rays = std::max(pixels > 8 ? 7u : 2u, pass_of(d) / 2 + 1);
              }},
             {"two pixels and some",
              [](Draft& d) { d.p().batch_rays = 2 * pass_of(d) + pass_of(d) / 2; }},
             {"all but one pixel", [](Draft& d) {
                  const std::uint32_t pixels = d.p().image_width * d.p().image_height;
                  d.p().batch_rays = pass_of(d) * std::max(1u, pixels - 1);
              }}}};
}

/// A filter is applied only below its threshold: that is asked on both sides, and at it.
DraftFactor filter_factor() {
    DraftFactor factor{"filter", {"filter", "filter_threshold"}, {}};
    factor.values.push_back({"none", [](Draft& d) { d.p().filter = Filter::none; }});
    for (const Filter kind : {Filter::gaussian, Filter::bilateral, Filter::median}) {
        factor.values.push_back(
            {fmt::format("{} below the threshold", to_string(kind)), [kind](Draft& d) {
                 d.p().filter = kind;
                 d.p().filter_threshold = d.p().spp + 1;
             }});
        factor.values.push_back(
            {fmt::format("{} at the threshold", to_string(kind)), [kind](Draft& d) {
                 d.p().filter = kind;
                 d.p().filter_threshold = d.p().spp;
             }});
    }
    factor.values.push_back({"gaussian, usual threshold", [](Draft& d) {
                                 d.p().filter = Filter::gaussian;
                                 d.p().filter_threshold = PipelineParameters{}.filter_threshold;
                             }});
    return factor;
}

DraftFactor schedule_factor() {
    DraftFactor factor{"schedule", {}, {}};
    for (const Schedule& value :
         {Schedule{}, Schedule{ScheduleKind::linear, 0}, Schedule{ScheduleKind::reversed, 0},
          Schedule{ScheduleKind::shuffled, 3}, Schedule{ScheduleKind::adversarial, 0}}) {
        factor.values.push_back(
            {to_string(value), [value](Draft& d) { d.configuration.schedule = value; }});
    }
    return factor;
}

/// In the order in which they are applied: what others are counted in terms of comes first.
std::vector<DraftFactor> factors() {
    using P = PipelineParameters;
    constexpr std::uint64_t k32Bits = std::uint64_t{1} << 32;
    return {scene_factor("geometry", &Draft::geometry, scenes::probe_geometries()),
            scene_factor("lights", &Draft::lights, scenes::probe_lights()),
            scene_factor("camera", &Draft::camera, scenes::probe_cameras()),
            image_size(),
            numbers<std::uint32_t>("spp", &P::spp, {2, 1, 3, 41, 47, 49}),
            numbers<std::uint32_t>("bounces", &P::bounces, {2, 0, 1, 3, 4, 5}),
            numbers<std::uint32_t>("light_samples", &P::light_samples, {2, 0, 1, 3}),
            numbers<std::uint32_t>("roulette", &P::roulette, {0, 1, 3}),
            numbers<std::uint64_t>("seed", &P::seed, {0, 7, k32Bits + 7, 0xfedcba9876543210u}),
            numbers<int>("width", &P::width, {8, 2, 4, 16}),
            numbers<int>("rays_per_block", &P::rays_per_block, {64, 32, 96, 256, 1024}),
            numbers<int>("max_leaf_size", &P::max_leaf_size, {4, 1, 2, 64, 200}),
            numbers<std::uint32_t>("queue_levels", &P::queue_levels, {0, 1, 2, 3}),
            words<QueueKind>("queues", &P::queues, {QueueKind::nodes, QueueKind::pairs}),
            words<EarlyOut>("early_out", &P::early_out,
                            {EarlyOut::level, EarlyOut::off, EarlyOut::immediate}),
            words<BlockOrder>("block_order", &P::block_order,
                              {BlockOrder::linear, BlockOrder::strided}),
            words<HitMode>("hit_mode", &P::hit_mode, {HitMode::buffer, HitMode::packed}),
            words<ShadowQuery>("shadow_query", &P::shadow_query,
                               {ShadowQuery::any, ShadowQuery::closest}),
            numbers<std::uint32_t>("hit_capacity", &P::hit_capacity, {8, 1, 3}),
            samples_per_pass(),
            rays_per_batch(),
            filter_factor(),
            schedule_factor()};
}

/// Cases that cost more than the others, or that no pair of values makes: levels of so many nodes
/// that their scan takes more than two look-back windows of 32 tiles of 1024 nodes.
std::vector<Draft> extra_drafts() {
    Draft field;
    field.geometry = scenes::probe_field();
    field.lights = 4;
    field.p().image_width = 5;
    field.p().image_height = 3;
    field.p().spp = 3;
    field.p().bounces = 1;
    field.p().light_samples = 1;
    field.p().seed = 11;
    field.p().width = 16;
    field.p().max_leaf_size = 1;
    // Stores are seen late, so that tiles look back over sums that are not complete.
    field.configuration.schedule = {emulation::ScheduleKind::adversarial, 0};
    return {field};
}

/// More rays in one batch, and more pixels, than 16 bits number: run under every budget, since it
/// takes no time.
Draft many_rays() {
    Draft draft;
    draft.p().image_width = 257;
    draft.p().image_height = 256;
    draft.p().spp = 1;
    draft.p().bounces = 0;
    draft.p().light_samples = 1;
    draft.p().width = 4;
    draft.p().hit_mode = HitMode::packed;
    draft.p().batch_rays = 257 * 256;
    draft.configuration.schedule = {emulation::ScheduleKind::linear, 0};
    return draft;
}

Case finished(const Draft& draft) {
    Case out;
    out.configuration = draft.configuration;
    const PipelineParameters& p = out.configuration.parameters;
    out.scene = fmt::format("probe:geometry={},lights={},camera={}", draft.geometry, draft.lights,
                            draft.camera);
    const std::string pass =
        p.samples_per_pass == 0 ? "" : fmt::format(", {} a pass", p.samples_per_pass);
    const std::string filter =
        p.filter == Filter::none
            ? ""
            : fmt::format(", {} filter below {} samples", to_string(p.filter), p.filter_threshold);
    out.label = fmt::format(
        "{} with {}, camera {}, {}x{}, {} samples{}, {} bounces, {} light samples, roulette {}, "
        "seed {}{}, leaves of {}",
        scenes::probe_geometries()[draft.geometry], scenes::probe_lights()[draft.lights],
        scenes::probe_cameras()[draft.camera], p.image_width, p.image_height, p.spp, pass,
        p.bounces, p.light_samples, p.roulette, p.seed, filter, p.max_leaf_size);
    return out;
}

/// The cases of the quick budget.
constexpr std::size_t kQuickCases = 40;

}  // namespace

std::vector<CaseFactor> case_factors() {
    std::vector<CaseFactor> out;
    for (DraftFactor& factor : factors()) {
        CaseFactor& one = out.emplace_back();
        one.name = std::move(factor.name);
        one.parameters = std::move(factor.parameters);
        for (DraftValue& value : factor.values) one.values.push_back(std::move(value.name));
    }
    return out;
}

std::vector<Exemption> case_exemptions() {
    return {{"arithmetic",
             "fast arithmetic is the device's alone and has no exact answer; docs/gpu.md"}};
}

CaseList covering_cases(Budget budget) {
    const std::vector<DraftFactor> all = factors();
    std::vector<std::size_t> sizes;
    CaseList list;
    for (const DraftFactor& factor : all) {
        sizes.push_back(factor.values.size());
        CoverageFactor& shown = list.coverage.factors.emplace_back();
        shown.name = factor.name;
        for (const DraftValue& value : factor.values) shown.values.push_back(value.name);
    }
    std::vector<Row> rows = covering_rows(sizes, budget == Budget::thorough ? 3 : 2);
    if (budget == Budget::quick && rows.size() > kQuickCases) rows.resize(kQuickCases);
    for (const Row& row : rows) {
        Draft draft;
        for (std::size_t f = 0; f < all.size(); ++f) all[f].values[row[f]].set(draft);
        list.cases.push_back(finished(draft));
    }
    list.cases.push_back(finished(many_rays()));
    if (budget != Budget::quick) {
        for (const Draft& draft : extra_drafts()) list.cases.push_back(finished(draft));
    }
    const Covered pairs = covered_by(sizes, rows, 2);
    const Covered triples = covered_by(sizes, rows, 3);
    list.coverage.cases = list.cases.size();
    list.coverage.pairs = pairs.covered;
    list.coverage.all_pairs = pairs.all;
    list.coverage.triples = triples.covered;
    list.coverage.all_triples = triples.all;
    for (const Case& one : list.cases) reference::validate(one.configuration.parameters);
    return list;
}

}  // namespace scotty::verify
