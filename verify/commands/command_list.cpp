/// scotty list: the built-in scenes.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "scenes/scenes.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"

namespace scotty::verify {

void add_list_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("list", "List the built-in scenes and their parameters.");
    command->footer(
        "Examples:\n"
        "  scotty list\n"
        "  scotty list --json\n"
        "  scotty render blob:triangles=1000000 -o blob.png    a built-in with parameters");
    auto json = std::make_shared<JsonOutput>();
    add_json_option(*command, *json);
    command->callback([&action, json] {
        action = [json] {
            nlohmann::json scenes = nlohmann::json::array();
            std::string text;
            for (const scenes::BuiltIn& scene : scenes::built_in_scenes()) {
                scenes.push_back({{"name", scene.name},
                                  {"parameters", scene.parameters},
                                  {"description", scene.description}});
                text += fmt::format("{:<10} {}\n", scene.name, scene.description);
                if (!scene.parameters.empty())
                    text += fmt::format("{:<10} {}:{}\n", "", scene.name, scene.parameters);
            }
            text +=
                "\nor the path of a .dae, .obj, .ply, .gltf or .glb file; at its end may stand\n"
                "#camera=FILE.camera   a camera that scotty view has saved, for any scene\n"
                "#camera=file   the file's own camera, #camera=fit one that frames everything\n"
                "#lights=none   add no light where the file has none (or both: "
                "#camera=fit,lights=none)\n";
            print_result(*json, scenes.dump(2), text);
            return kExitPassed;
        };
    });
}

}  // namespace scotty::verify
