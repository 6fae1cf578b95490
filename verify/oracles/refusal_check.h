/// What must not be believed: copies of a sound scene and of its tree with one value spoiled, and
/// parameters just beyond their ranges. All must be refused, and what is just within must be taken.
/// What the errors and warnings say is added to `said`, where there is one.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/wide_bvh.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

/// The name of the check in reports.
inline constexpr const char* kRefusal = "refusal";

/// Larger scenes are not copied so often: small ones have the same values.
constexpr std::size_t kMostSpoiledTriangles = 1000;

/// Spoils the first, the middle and the last element of every table of a valid scene in turn, each
/// with values on both sides of its limits. A spoiled scene must be refused with an error that
/// names the element; one at the limit must be taken, and must have another fingerprint. Triangles
/// without area and scenes without light must be warned of, and no others.
using SceneValidator = std::function<void(reference::Scene&)>;
std::vector<Failure> check_scene_refusals(
    const reference::Scene& scene, const SceneValidator& validator = reference::validate_and_repair,
    std::string* said = nullptr);

/// The same for a valid tree of that scene: validate() must find something.
using TreeValidator =
    std::function<std::vector<std::string>(const reference::WideBvh&, const reference::Scene&)>;
std::vector<Failure> check_tree_refusals(
    const reference::WideBvh& bvh, const reference::Scene& scene,
    const TreeValidator& validator = [](const auto& tree,
                                        const auto& of) { return reference::validate(tree, of); },
    std::string* said = nullptr);

/// Every parameter of the table at its limits and one beyond them, and as text that is no number;
/// width and leaf size of trees.
using ParameterValidator = std::function<void(const reference::PipelineParameters&)>;
std::vector<Failure> check_parameter_refusals(
    const ParameterValidator& validator = [](const auto& p) { reference::validate(p); },
    std::string* said = nullptr);

}  // namespace scotty::verify
