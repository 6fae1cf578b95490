/// scotty info: what is in a scene.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "reference/bvh/tree_figures.h"
#include "scenes/scene_summary.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"

namespace scotty::verify {
namespace {

std::string tree_text(const reference::TreeFigures& tree) {
    return fmt::format(
        "{:<14} expected inner nodes of a ray {:.4g}, after reinsertion {:.4g}; built in {:.4g} "
        "ms, optimised in {:.4g} ms\n",
        "tree", tree.cost_built, tree.cost_optimised, 1.0e3 * tree.seconds_built,
        1.0e3 * tree.seconds_optimised);
}

nlohmann::ordered_json tree_json(const reference::TreeFigures& tree) {
    return {{"cost_built", tree.cost_built},
            {"cost_optimised", tree.cost_optimised},
            {"seconds_built", tree.seconds_built},
            {"seconds_optimised", tree.seconds_optimised}};
}

}  // namespace

void add_info_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "info",
        "Say what is in a scene: meshes, triangles, materials, lights, camera, extents, and what "
        "of the file was repaired or is not supported.");
    command->footer(
        "Examples:\n"
        "  scotty info scene.dae\n"
        "  scotty info scene.glb --json | jq .not_supported\n"
        "  scotty info coil --tree     what its tree costs, before and after reinsertion\n"
        "  scotty info 'scene.obj#camera=fit,lights=none'\n"
        "                              how a file's end is read: camera=file takes the file's\n"
        "                              camera, camera=fit frames everything, lights=none adds no\n"
        "                              light where the file has none");
    auto scene = std::make_shared<std::string>();
    auto json = std::make_shared<JsonOutput>();
    command->add_option("scene", *scene, "a built-in scene (scotty list), a file, or a .scn")
        ->required();
    add_json_option(*command, *json);
    auto tree = std::make_shared<bool>(false);
    command->add_flag("--tree", *tree,
                      "build the binary tree that all others are made from, and say what it costs "
                      "before and after its subtrees were reinserted where they cost less");
    command->callback([&action, scene, json, tree] {
        action = [scene, json, tree] {
            const reference::Scene loaded = load_scene_argument(*scene);
            const scenes::SceneSummary summary = scenes::summarize(loaded);
            nlohmann::ordered_json object = to_json(summary);
            std::string text = to_text(summary);
            if (*tree) {
                const reference::TreeFigures figures = reference::measure_tree(loaded, 0);
                object["tree"] = tree_json(figures);
                text += tree_text(figures);
            }
            print_result(*json, object.dump(2), text);
            return kExitPassed;
        };
    });
}

}  // namespace scotty::verify
