/// What this machine has.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace scotty::verify {

/// One thing that was looked for.
struct Finding {
    std::string name;  ///< "CUDA compiler"
    bool found = false;
    bool required = false;
    std::string detail;  ///< version, model, size; where it is missing, what that means
};

/// Looks, and starts nothing but nvcc and nvidia-smi, to ask for their versions.
std::vector<Finding> examine_machine();

std::string table(const std::vector<Finding>& findings);
nlohmann::json to_json(const std::vector<Finding>& findings);

}  // namespace scotty::verify
