/// scotty info: what is in a scene.
#include <memory>
#include <nlohmann/json.hpp>

#include "scenes/scene_summary.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"

namespace scotty::verify {

void add_info_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "info",
        "Say what is in a scene: meshes, triangles, materials, lights, camera, extents, and what "
        "of the file was repaired or is not supported.");
    command->footer(
        "Examples:\n"
        "  scotty info scene.dae\n"
        "  scotty info scene.glb --json | jq .not_supported\n"
        "  scotty info 'scene.obj#camera=fit,lights=none'\n"
        "                              how a file's end is read: camera=file takes the file's\n"
        "                              camera, camera=fit frames everything, lights=none adds no\n"
        "                              light where the file has none");
    auto scene = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    command->add_option("scene", *scene, "a built-in scene (scotty list), a file, or a .scn")
        ->required();
    command->add_flag("--json", *json, "as JSON");
    command->callback([&action, scene, json] {
        action = [scene, json] {
            const scenes::SceneSummary summary = scenes::summarize(load_scene_argument(*scene));
            print_result(*json ? to_json(summary).dump(2) : to_text(summary));
            return kExitPassed;
        };
    });
}

}  // namespace scotty::verify
