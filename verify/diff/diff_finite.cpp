/// The diff's message for a value that must be finite and is not.
#include "verify/capture/finite.h"
#include "verify/diff/diff_parts.h"

namespace scotty::verify {

std::optional<NonFinite> find_non_finite(const reference::StageView& stage,
                                         const reference::BufferView& output) {
    const NonFiniteValues values = find_non_finite_values(stage, output);
    if (values.values == 0) return std::nullopt;
    NonFinite found;
    found.stage = stage.name;
    found.launch = stage.launch;
    found.buffer = output.name;
    found.values = values.values;
    found.first_row = values.row;
    found.field = values.field;
    found.value = value_text(values.bits, true);
    return found;
}

}  // namespace scotty::verify
