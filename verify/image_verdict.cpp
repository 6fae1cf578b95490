#include <algorithm>

#include "verify/image_gates.h"

namespace scotty::verify {

std::string_view name(Gate gate) {
    switch (gate) {
        case Gate::layout:
            return "layout";
        case Gate::finite:
            return "finite";
        case Gate::global:
            return "global";
        case Gate::tile:
            return "tile";
        case Gate::pixel:
            return "pixel";
    }
    return "unknown";
}

const GateResult* ImageVerdict::first_failure() const {
    const auto failed = std::find_if(gates.begin(), gates.end(),
                                     [](const GateResult& g) { return g.ran && !g.passed; });
    return failed == gates.end() ? nullptr : &*failed;
}

bool ImageVerdict::passed() const { return first_failure() == nullptr; }

}  // namespace scotty::verify
