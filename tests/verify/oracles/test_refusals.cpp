/// What is spoiled is refused; and validators that believe too much or too little are seen.
#include <set>
#include <string>

#include "reference/base/error.h"
#include "scenes/probe.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "verify/oracles/refusal_check.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;

std::string sentences(const std::vector<Failure>& failures) {
    std::string text;
    for (const Failure& failure : failures) text += failure.sentence + "\n";
    return text;
}

/// Scenes with every kind of light and material.
std::vector<reference::Scene> scenes_with_everything() {
    std::vector<reference::Scene> all{scenes::load_scene("cornell"), scenes::load_scene("furnace")};
    for (std::size_t lights = 0; lights < scenes::probe_lights().size(); ++lights) {
        all.push_back(scenes::load_scene("probe:geometry=" + std::to_string(lights % 4) +
                                         ",lights=" + std::to_string(lights) + ",camera=0"));
    }
    return all;
}

void believe_all(reference::Scene&) {}
void believe_nothing(reference::Scene& scene) {
    throw reference::Error::bad_input(scene.name, "is refused");
}

}  // namespace

TEST_CASE("refusals: scenes, trees and parameters that are sound pass", "[verify][oracles]") {
    for (const reference::Scene& scene : scenes_with_everything()) {
        CAPTURE(scene.source);
        CHECK(sentences(check_scene_refusals(scene)).empty());
        for (const int width : {2, 16}) {
            for (const std::uint32_t levels : {0u, 1u, 2u}) {
                const auto bvh = build_wide_bvh(scene, {width, 2, 1, levels});
                CHECK(sentences(check_tree_refusals(bvh, scene)).empty());
            }
        }
    }
    CHECK(sentences(check_parameter_refusals()).empty());
}

TEST_CASE("refusals: a validator that believes all is seen at every element", "[verify][oracles]") {
    std::set<std::string> elements;
    for (const reference::Scene& scene : scenes_with_everything()) {
        for (const Failure& failure : check_scene_refusals(scene, believe_all)) {
            elements.insert(failure.field.substr(0, failure.field.find(' ')));
        }
    }
    for (const char* element : {"vertex", "triangle", "material", "light", "camera,"}) {
        CAPTURE(element);
        CHECK(elements.contains(element));
    }
    const reference::Scene scene = scenes::load_scene("cornell");
    const auto bvh = build_wide_bvh(scene, {4, 2, 1, 0});
    const auto believed = [](const auto&, const auto&) { return std::vector<std::string>(); };
    CHECK(check_tree_refusals(bvh, scene, believed).size() > 100);
    CHECK(check_parameter_refusals([](const auto&) {}).size() > 10);
}

TEST_CASE("refusals: a validator that believes nothing is seen", "[verify][oracles]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    CHECK_FALSE(check_scene_refusals(scene, believe_nothing).empty());
    const auto refused = [](const reference::PipelineParameters&) {
        throw reference::Error::bad_input("anything", "is refused");
    };
    CHECK_FALSE(check_parameter_refusals(refused).empty());
}

TEST_CASE("refusals: a validator that says nothing of empty triangles or darkness is seen",
          "[verify][oracles]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    const auto silent = [](reference::Scene& copy) {
        reference::validate_and_repair(copy);
        copy.warnings.clear();
    };
    const auto alarmed = [](reference::Scene& copy) {
        reference::validate_and_repair(copy);
        copy.warnings.emplace_back("1 triangles have zero area, the first is triangle 1; black");
    };
    CHECK_THAT(sentences(check_scene_refusals(scene, silent)),
               ContainsSubstring("along x is not reported as empty") &&
                   ContainsSubstring("of one point is not") &&
                   ContainsSubstring("nothing shines is not called black"));
    CHECK_THAT(sentences(check_scene_refusals(scene, alarmed)),
               ContainsSubstring("as thin as x can be is called empty") &&
                   ContainsSubstring("one light that shines is called black"));
}

TEST_CASE("refusals: what errors say is handed on", "[verify][oracles]") {
    std::string said;
    const reference::Scene scene = scenes::load_scene("cornell");
    check_scene_refusals(scene, reference::validate_and_repair, &said);
    CHECK_THAT(said, ContainsSubstring("vertex 0") && ContainsSubstring("zero area") &&
                         ContainsSubstring("black"));
    said.clear();
    check_parameter_refusals([](const auto& p) { reference::validate(p); }, &said);
    CHECK_THAT(said, ContainsSubstring("BVH width") && ContainsSubstring("found '0x8'"));
}

TEST_CASE("refusals: a validator that errs by one value is seen", "[verify][oracles]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    const auto with = [&](const auto& let_pass) {
        return check_scene_refusals(scene, [&](reference::Scene& spoiled) {
            if (!let_pass(spoiled)) validate_and_repair(spoiled);
        });
    };
    const auto last = scene.vertices.size() - 1;
    CHECK(with([&](const auto& s) { return s.vertices[last].z > 1e12f; }).size() == 2);
    CHECK(with([&](const auto& s) { return s.materials[0].reflectance.y < 0.0f; }).size() == 2);
    CHECK(with([](const auto& s) { return s.camera.tan_half_fov > 1e4f; }).size() == 2);
    CHECK(with([](const auto& s) { return s.triangles.empty(); }).size() == 1);
}

}  // namespace scotty::verify::test
