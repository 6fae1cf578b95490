#include <array>
#include <functional>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_observer.h"
#include "tests/catch.h"

namespace {

using namespace scotty::reference;
using Catch::Matchers::ContainsSubstring;

std::string complaint_about(const std::function<void(PipelineParameters&)>& spoil) {
    PipelineParameters parameters;
    spoil(parameters);
    try {
        validate(parameters);
    } catch (const Error& error) {
        CHECK(error.kind() == ErrorKind::bad_input);
        return error.what();
    }
    return "";
}

TEST_CASE("parameters: the defaults are valid", "[reference][parameters]") {
    CHECK_NOTHROW(validate(PipelineParameters{}));
}

TEST_CASE("parameters: what is out of range is named with its value and what is allowed",
          "[reference][parameters]") {
    CHECK_THAT(complaint_about([](auto& p) { p.width = 3; }),
               ContainsSubstring("tree width") && ContainsSubstring("2, 4, 8 or 16") &&
                   ContainsSubstring("found 3"));
    CHECK_THAT(complaint_about([](auto& p) { p.rays_per_block = 0; }),
               ContainsSubstring("rays per block") && ContainsSubstring("32..1024") &&
                   ContainsSubstring("found 0"));
    CHECK_THAT(complaint_about([](auto& p) { p.rays_per_block = -64; }),
               ContainsSubstring("found -64"));
    CHECK_THAT(complaint_about([](auto& p) { p.rays_per_block = 48; }),
               ContainsSubstring("multiple of 32") && ContainsSubstring("48"));
    CHECK_THAT(complaint_about([](auto& p) { p.image_width = 0; }),
               ContainsSubstring("image width") && ContainsSubstring("found 0"));
    CHECK_THAT(complaint_about([](auto& p) { p.image_height = 0; }),
               ContainsSubstring("image height"));
    CHECK_THAT(complaint_about([](auto& p) { p.image_width = p.image_height = 60000; }),
               ContainsSubstring("image size") && ContainsSubstring("60000x60000"));
    CHECK_THAT(complaint_about([](auto& p) { p.spp = 0; }), ContainsSubstring("samples per pixel"));
    CHECK_THAT(complaint_about([](auto& p) { p.bounces = 65; }), ContainsSubstring("bounces"));
    CHECK_THAT(complaint_about([](auto& p) { p.light_samples = 65; }),
               ContainsSubstring("light samples"));
    CHECK_THAT(complaint_about([](auto& p) { p.max_leaf_size = 1025; }),
               ContainsSubstring("triangles per leaf"));
    CHECK_THAT(complaint_about([](auto& p) { p.hit_capacity = 0; }),
               ContainsSubstring("hit capacity"));
    CHECK_THAT(complaint_about([](auto& p) { p.batch_rays = 0; }),
               ContainsSubstring("rays per batch"));
}

/// Whether a struct of that many members can be initialised with one member more.
struct Anything {
    template <class T>
    operator T() const;
};
template <class T, class... Members>
constexpr std::size_t members_of(Members... members) {
    if constexpr (requires { T{members..., Anything{}}; }) {
        return members_of<T>(members..., Anything{});
    } else {
        return sizeof...(Members);
    }
}

TEST_CASE("parameters: every member is a row of the table, and every row is a member of its own",
          "[reference][parameters]") {
    CHECK(members_of<PipelineParameters>() == kParameters.size());
    for (const ParameterInfo& info : kParameters) {
        INFO(info.name);
        PipelineParameters changed;
        const std::string before = text_of(info, changed);
        const std::uint64_t other =
            info.words.empty()
                ? (info.only.empty() ? info.low + 5 * info.multiple_of : info.only.front())
                : (info.get(changed) + 1) % info.words.size();
        info.set(changed, other);
        CHECK(text_of(info, changed) != before);
        std::size_t changes = 0;
        for (const ParameterInfo& row : kParameters) {
            changes += row.get(changed) != row.get(PipelineParameters{});
        }
        CHECK(changes == 1);
        PipelineParameters read;
        set_from_text(info, read, text_of(info, changed));
        CHECK(info.get(read) == other);
        if (!info.words.empty()) {
            CHECK_THROWS_WITH(set_from_text(info, read, "nonsense"),
                              ContainsSubstring("'nonsense'"));
            continue;
        }
        CHECK_THROWS_WITH(set_from_text(info, read, "1x"), ContainsSubstring("expected a number"));
        if (info.high != ~std::uint64_t{0}) {
            CHECK_THROWS_WITH(set_from_text(info, read, "-1"), ContainsSubstring("found -1"));
        }
    }
}

TEST_CASE("parameters: every word is read back as the value that it names",
          "[reference][parameters]") {
    for (const EarlyOut v : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        CHECK(parse_early_out(to_string(v)) == v);
    }
    for (const BlockOrder v : {BlockOrder::linear, BlockOrder::strided}) {
        CHECK(parse_block_order(to_string(v)) == v);
    }
    for (const HitMode v : {HitMode::buffer, HitMode::packed}) {
        CHECK(parse_hit_mode(to_string(v)) == v);
    }
    for (const ShadowQuery v : {ShadowQuery::any, ShadowQuery::closest}) {
        CHECK(parse_shadow_query(to_string(v)) == v);
    }
    for (const Filter v : {Filter::none, Filter::gaussian, Filter::bilateral, Filter::median}) {
        CHECK(parse_filter(to_string(v)) == v);
    }
}

TEST_CASE("parameters: an unknown word is answered with the words there are",
          "[reference][parameters]") {
    CHECK_THROWS_WITH(parse_early_out("never"), ContainsSubstring("early-out") &&
                                                    ContainsSubstring("off, level, immediate") &&
                                                    ContainsSubstring("'never'"));
    CHECK_THROWS_WITH(parse_filter(""), ContainsSubstring("gaussian"));
    CHECK_THROWS_WITH(parse_block_order("x"), ContainsSubstring("linear, strided"));
    CHECK_THROWS_WITH(parse_hit_mode("x"), ContainsSubstring("buffer, packed"));
    CHECK_THROWS_WITH(parse_shadow_query("x"), ContainsSubstring("any, closest"));
}

TEST_CASE("stages: a name is the path to its place", "[reference][stages]") {
    constexpr std::uint32_t none = kNotApplicable;
    CHECK(stage_name(StageKind::primary_rays, 0, none, none, none, false) == "primary_rays");
    CHECK(stage_name(StageKind::primary_rays, 2, none, none, none, true) == "batch2/primary_rays");
    CHECK(stage_name(StageKind::intersect, 0, 1, 0, 3, false) == "bounce1/light0/level3/intersect");
    CHECK(stage_name(StageKind::scene_rays, 0, 1, none, none, false) == "bounce1/scene_rays");
    CHECK(stage_name(StageKind::intersect_root, 0, none, none, 0, false) ==
          "trace/level0/intersect_root");
    CHECK(stage_name(StageKind::merge_intersections, 0, none, none, none, false) ==
          "trace/merge_intersections");
    CHECK(stage_name(StageKind::reconstruct_image, 0, none, none, none, false) ==
          "reconstruct_image");
}

TEST_CASE("stages: a buffer is found by name and read as its type", "[reference][stages]") {
    const std::array<std::uint32_t, 3> counts{1, 2, 3};
    const std::array<std::uint32_t, 3> after{4, 5, 6};
    StageView stage;
    stage.name = "level0/scan_counts";
    stage.inputs.push_back(buffer_view<std::uint32_t>("counts", counts, "rays per node"));
    CHECK(stage.find("nothing") == nullptr);
    CHECK(stage.get<std::uint32_t>("nothing").empty());
    CHECK(stage.get<std::uint32_t>("counts")[2] == 3);
    CHECK_THROWS_WITH(stage.get<std::uint64_t>("counts"),
                      ContainsSubstring("counts of level0/scan_counts"));
    stage.outputs.push_back(buffer_view<std::uint32_t>("counts", after, "rays per node"));
    CHECK(stage.get<std::uint32_t>("counts")[2] == 6);  // what the stage made of it
}

}  // namespace
