/// The cases of the verification: nothing that code depends on is left out of them, and a parameter
/// or a member of a scene record that is new has to be put in.
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "reference/contract/parameter_table.h"
#include "scenes/probe.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "verify/sweep/cases.h"
#include "verify/sweep/covering_array.h"
#include "verify/sweep/verify.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using reference::LightKind;
using reference::MaterialKind;
using reference::PipelineParameters;

/// Members of an aggregate: it can be initialised from so many values and not from one more.
struct AnyValue {
    template <class T>
    operator T() const;
};
template <class Aggregate, class... Values>
constexpr std::size_t member_count() {
    if constexpr (requires { Aggregate{Values{}..., AnyValue{}}; }) {
        return member_count<Aggregate, Values..., AnyValue>();
    } else {
        return sizeof...(Values);
    }
}

const std::vector<Case>& standard_cases() {
    static const std::vector<Case> cases = covering_cases(Budget::standard).cases;
    return cases;
}

TEST_CASE("covering rows: with strength three, every triple of values stands in some row",
          "[verify][cases]") {
    const std::vector<std::size_t> sizes{3, 2, 4, 2, 3};
    const auto rows = covering_rows(sizes, 3);
    std::set<std::vector<std::size_t>> triples;
    for (const Row& row : rows) {
        for (std::size_t f = 0; f < sizes.size(); ++f) {
            for (std::size_t g = f + 1; g < sizes.size(); ++g) {
                for (std::size_t h = g + 1; h < sizes.size(); ++h) {
                    triples.insert({f, row[f], g, row[g], h, row[h]});
                }
            }
        }
    }
    std::size_t all = 0;
    for (std::size_t f = 0; f < sizes.size(); ++f) {
        for (std::size_t g = f + 1; g < sizes.size(); ++g) {
            for (std::size_t h = g + 1; h < sizes.size(); ++h)
                all += sizes[f] * sizes[g] * sizes[h];
        }
    }
    CHECK(triples.size() == all);
    const Covered covered = covered_by(sizes, rows, 3);
    CHECK(covered.covered == all);
    CHECK(covered.all == all);
    CHECK(rows.size() < 80);  // of 144 combinations; 36 at least
    CHECK(rows == covering_rows(sizes, 3));
    CHECK(covered_by(sizes, {rows.front()}, 3).covered == 10);
}

TEST_CASE("cases: every member of the parameters is in a factor or exempt with a reason",
          "[verify][cases]") {
    CHECK(reference::kParameters.size() == member_count<PipelineParameters>());
    std::map<std::string, int> named;
    for (const CaseFactor& factor : case_factors()) {
        for (const std::string& parameter : factor.parameters) ++named[parameter];
    }
    for (const Exemption& exempt : case_exemptions()) {
        ++named[exempt.parameter];
        CHECK(exempt.reason.size() > 20);
    }
    for (const reference::ParameterInfo& info : reference::kParameters) {
        INFO("a parameter that no factor of verify/sweep/cases.cpp varies: " << info.name);
        CHECK(named[std::string(info.name)] == 1);
    }
    CHECK(named.size() == reference::kParameters.size());
}

TEST_CASE("cases: a factor's parameter takes as many values as the factor says, or more",
          "[verify][cases]") {
    std::map<std::string, std::set<std::uint64_t>> taken;
    for (const Case& one : standard_cases()) {
        for (const reference::ParameterInfo& info : reference::kParameters) {
            taken[std::string(info.name)].insert(info.get(one.configuration.parameters));
        }
    }
    for (const CaseFactor& factor : case_factors()) {
        for (const std::string& parameter : factor.parameters) {
            INFO(parameter);
            if (factor.parameters.size() == 1) {
                CHECK(taken[parameter].size() >= factor.values.size() - 1);
            }
            CHECK(taken[parameter].size() > 1);
        }
    }
}

TEST_CASE("cases: all pairs are covered by default, all triples when thorough, most when quick",
          "[verify][cases]") {
    const Coverage quick = covering_cases(Budget::quick).coverage;
    const Coverage standard = covering_cases(Budget::standard).coverage;
    const Coverage thorough = covering_cases(Budget::thorough).coverage;
    CHECK(standard.pairs == standard.all_pairs);
    CHECK(thorough.pairs == thorough.all_pairs);
    CHECK(thorough.triples == thorough.all_triples);
    CHECK(standard.triples < thorough.triples);
    CHECK(quick.pairs * 10 > quick.all_pairs * 8);
    CHECK(quick.cases < standard.cases);
    CHECK(standard.cases < 150);
    CHECK(standard.cases == standard_cases().size());
}

TEST_CASE("cases: passes and batches come in every order of size", "[verify][cases]") {
    bool pass_above_batch = false;
    bool pass_below_batch = false;
    bool last_pass_is_short = false;
    bool last_batch_is_short = false;
    bool several_batches_a_pixel = false;
    for (const Case& one : standard_cases()) {
        const PipelineParameters& p = one.configuration.parameters;
        const std::uint32_t pass = reference::samples_of_pass(p);
        const std::uint32_t pixels = p.image_width * p.image_height;
        pass_above_batch = pass_above_batch || pass > p.batch_rays;
        pass_below_batch = pass_below_batch || (pass < p.spp && pass < p.batch_rays);
        last_pass_is_short = last_pass_is_short || p.spp % pass != 0;
        last_batch_is_short =
            last_batch_is_short || (p.batch_rays > pass && pixels % (p.batch_rays / pass) != 0 &&
                                    pixels > p.batch_rays / pass);
        several_batches_a_pixel =
            several_batches_a_pixel || (pass > p.batch_rays && pass % p.batch_rays != 0);
    }
    CHECK(pass_above_batch);
    CHECK(pass_below_batch);
    CHECK(last_pass_is_short);
    CHECK(last_batch_is_short);
    CHECK(several_batches_a_pixel);
}

/// No default: a kind that is new does not compile until it is in a probe scene.
constexpr std::size_t place_of(LightKind kind) {
    switch (kind) {
        case LightKind::parallelogram:
        case LightKind::triangle:
        case LightKind::point:
        case LightKind::directional:
        case LightKind::environment:
        case LightKind::hemisphere:
        case LightKind::spot:
            break;
    }
    return static_cast<std::size_t>(kind);
}
constexpr std::size_t place_of(MaterialKind kind) {
    switch (kind) {
        case MaterialKind::diffuse:
        case MaterialKind::mirror:
        case MaterialKind::glass:
        case MaterialKind::conductor:
            break;
    }
    return static_cast<std::size_t>(kind);
}

TEST_CASE("cases: every kind of light and material, of emission, normals and camera is in some",
          "[verify][cases]") {
    std::set<std::size_t> lights;
    std::set<std::size_t> light_counts;
    std::set<std::size_t> materials;
    std::set<std::uint32_t> glows;
    bool flat = false;
    bool smooth = false;
    bool by_width = false;
    for (const Case& one : standard_cases()) {
        const reference::Scene scene = scenes::load_scene(one.scene);
        for (const auto& light : scene.lights) lights.insert(place_of(light.kind));
        for (const auto& material : scene.materials) {
            materials.insert(place_of(material.kind));
            if (!reference::is_zero(material.emission)) glows.insert(material.emission_is_sampled);
        }
        light_counts.insert(scene.lights.size());
        flat = flat || scene.normals.empty();
        smooth = smooth || !scene.normals.empty();
        by_width = by_width || scene.camera.tan_half_width > 0.0f;
    }
    CHECK(lights.size() == reference::kLightKinds);
    CHECK(materials.size() == reference::kMaterialKinds);
    CHECK(glows.size() == 2);
    CHECK(light_counts.count(0) == 1);
    CHECK(light_counts.count(1) == 1);
    CHECK(light_counts.size() >= 4);
    CHECK(flat);
    CHECK(smooth);
    CHECK(by_width);
    // What else a scene may hold: a member that is new is to be put into a probe scene, above.
    CHECK(member_count<reference::Light>() == 7);
    CHECK(member_count<reference::Material>() == 6);
    CHECK(member_count<reference::Camera>() == 6);
}

TEST_CASE(
    "cases: leaves of more triangles than a block loads at once, and levels of more tiles "
    "than two windows of the scan",
    "[verify][cases]") {
    std::uint32_t largest_leaf = 0;
    std::uint32_t most_nodes = 0;
    for (const Case& one : standard_cases()) {
        const PipelineParameters& p = one.configuration.parameters;
        const bool coincident = one.label.find("coincident") != std::string::npos;
        const bool field = one.label.find("field") != std::string::npos;
        if (!field && !(coincident && p.max_leaf_size > 64)) continue;
        const auto bvh =
            reference::build_wide_bvh(scenes::load_scene(one.scene), bvh_parameters(p, 0));
        for (const reference::Leaf& leaf : bvh.leaves) {
            largest_leaf = std::max(largest_leaf, leaf.count);
        }
        for (std::uint32_t level = 0; level < bvh.level_count(); ++level) {
            most_nodes =
                std::max(most_nodes, bvh.level_begins[level + 1] - bvh.level_begins[level]);
        }
    }
    CHECK(largest_leaf > 128);
    CHECK(most_nodes > 65 * 1024);
}

TEST_CASE("verify: a fault in one case is told with its scene, picture and command",
          "[verify][whole][cases]") {
    std::vector<Case> cases = standard_cases();
    cases.resize(3);
    VerifySettings settings;
    CHECK(verify_cases(cases, settings).passed());
    // The baseline's image of the third: all else agrees with it but the Embree renderer.
    std::size_t runs = 0;
    settings.tamper = [&](const reference::StageView& stage, std::size_t configuration,
                          const auto& show) {
        if (stage.kind == reference::StageKind::primary_rays && stage.batch == 0 &&
            configuration == 0) {
            ++runs;
        }
        if (stage.kind != reference::StageKind::merge_intersections || runs != 3)
            return show(stage);
        reference::StageView spoiled = stage;
        const auto merged = stage.get<reference::Hit>("merged");
        std::vector<reference::Hit> other(merged.begin(), merged.end());
        other.back().u += 0.25f;
        for (auto& buffer : spoiled.outputs) {
            if (buffer.name == "merged") buffer.data = other.data();
        }
        show(spoiled);
    };
    const SceneReport report = verify_cases(cases, settings);
    REQUIRE(report.configurations.size() == 3);
    CHECK(report.configurations[0].failures.empty());
    CHECK(report.configurations[1].failures.empty());
    REQUIRE_FALSE(report.configurations[2].failures.empty());
    CHECK_THAT(report.configurations[2].replay,
               Catch::Matchers::ContainsSubstring(cases[2].scene) &&
                   Catch::Matchers::ContainsSubstring("--spp") &&
                   Catch::Matchers::ContainsSubstring("--schedule"));
    CHECK(report.configurations[2].failures.front().sentence.find("baseline") != std::string::npos);
}

TEST_CASE("verify: a filter that runs at its threshold, and one that does not below it, are found",
          "[verify][whole][cases]") {
    // On the heap: gcc 12 sees uninitialised memory where there is none.
    const auto made = std::make_unique<VerifySettings>();
    VerifySettings& settings = *made;
    settings.parameters = default_verify_parameters();
    settings.parameters.image_width = 5;
    settings.parameters.image_height = 3;
    settings.parameters.filter = reference::Filter::median;
    settings.only.emplace();
    const reference::Scene scene = scenes::load_scene("probe");
    const auto leave_out_filter = [](const reference::StageView& stage, std::size_t,
                                     const auto& show) {
        if (stage.kind != reference::StageKind::filter) show(stage);
    };
    const auto first_failure = [&] {
        const SceneReport report = verify_scene(scene, settings);
        const auto& failures = report.configurations.front().failures;
        return failures.empty() ? std::string() : failures.front().invariant;
    };
    CHECK(first_failure().empty());
    settings.tamper = leave_out_filter;
    CHECK(first_failure() == invariant::kFilter);
    settings.tamper = nullptr;
    settings.parameters.filter_threshold = settings.parameters.spp;
    CHECK(first_failure().empty());
    settings.tamper = [](const reference::StageView& stage, std::size_t, const auto& show) {
        show(stage);
        if (stage.kind != reference::StageKind::reconstruct_image) return;
        reference::StageView filter;
        filter.name = "filter_median";
        filter.kind = reference::StageKind::filter;
        filter.launch = stage.launch + 1;
        const auto image = stage.get<reference::Vec3>("image");
        filter.inputs = {reference::buffer_view(reference::buffers::image, image)};
        filter.outputs = {reference::buffer_view(reference::buffers::filtered, image)};
        show(filter);
    };
    CHECK(first_failure() == invariant::kFilter);
}

TEST_CASE("verify: a bilateral weight that is zero in float and 1e-301 in double is no failure",
          "[verify][whole][cases]") {
    // On the heap: gcc 12 sees uninitialised memory where there is none.
    const auto made = std::make_unique<VerifySettings>();
    VerifySettings& settings = *made;
    settings.parameters.image_width = 1;
    settings.parameters.image_height = 7;
    settings.parameters.spp = 1;
    settings.parameters.bounces = 0;
    settings.parameters.seed = (std::uint64_t{1} << 32) + 7;
    settings.parameters.max_leaf_size = 1;
    settings.parameters.filter = reference::Filter::bilateral;
    settings.parameters.filter_threshold = 2;
    settings.only.emplace();
    const SceneReport report =
        verify_scene(scenes::load_scene("probe:geometry=3,lights=1"), settings);
    CHECK(report.passed());
}

}  // namespace
