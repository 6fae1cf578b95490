/// scotty doctor: what this machine has, and what that means.
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "verify/command.h"
#include "verify/doctor.h"

namespace scotty::verify {

void add_doctor_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "doctor", "Say what this machine has: CPU, memory, libraries, CUDA compiler, device.");
    command->footer(
        "Examples:\n"
        "  scotty doctor\n"
        "  scotty doctor --json\n\n"
        "Exit code 3 where something is missing that everything needs. CUDA is not needed.");
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "as JSON");
    command->callback([&action, json] {
        action = [json] {
            const std::vector<Finding> findings = examine_machine();
            print_result(*json ? to_json(findings).dump(2) : table(findings));
            const bool complete =
                std::all_of(findings.begin(), findings.end(),
                            [](const Finding& f) { return f.found || !f.required; });
            return complete ? kExitPassed : kExitMissingEnvironment;
        };
    });
}

}  // namespace scotty::verify
