/// scotty doctor: what this machine has, and what that means.
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "verify/commands/command.h"
#include "verify/commands/doctor.h"
#include "verify/commands/options.h"

namespace scotty::verify {

void add_doctor_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "doctor", "Say what this machine has: CPU, memory, libraries, CUDA compiler, device.");
    command->footer(
        "Examples:\n"
        "  scotty doctor\n"
        "  scotty doctor --json\n"
        "  scotty doctor --require-gpu\n\n"
        "Exit code 3 where something is missing that everything needs. CUDA is not needed.");
    auto json = std::make_shared<JsonOutput>();
    auto require_gpu = std::make_shared<bool>(false);
    add_json_option(*command, *json);
    command->add_flag("--require-gpu", *require_gpu, "a CUDA device is something needed");
    command->callback([&action, json, require_gpu] {
        action = [json, require_gpu] {
            std::vector<Finding> findings = examine_machine();
            for (Finding& finding : findings) {
                if (finding.name == "CUDA device") finding.required = *require_gpu;
            }
            print_result(*json, to_json(findings).dump(2), table(findings));
            const bool complete =
                std::all_of(findings.begin(), findings.end(),
                            [](const Finding& f) { return f.found || !f.required; });
            return complete ? kExitPassed : kExitMissingEnvironment;
        };
    });
}

}  // namespace scotty::verify
