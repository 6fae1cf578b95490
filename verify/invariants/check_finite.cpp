/// A value that has to be finite and is not is a failure of its own, and comes first.
#include <fmt/format.h>

#include <bit>

#include "verify/capture/finite.h"
#include "verify/invariants/check_state.h"

namespace scotty::verify {

void check_finite(CheckState& state, const reference::StageView& stage) {
    for (const reference::BufferView& buffer : stage.outputs) {
        const NonFiniteValues found = find_non_finite_values(stage, buffer);
        if (found.values == 0) continue;
        state.counts.non_finite += found.rows;
        Failure failure = failure_at(
            stage, invariant::kNonFinite,
            fmt::format("{} of the buffer's records hold a value that is not finite", found.rows));
        const reference::BufferInfo& info = reference::buffer_info(buffer.name);
        if (info.row == reference::Row::ray) failure.ray = found.row;
        failure.field = fmt::format("{}[{}]{}{}", buffer.name, found.row,
                                    found.field.empty() ? "" : ".", found.field);
        failure.expected = "finite values";
        failure.found = exact(std::bit_cast<float>(found.bits));
        state.add(std::move(failure));
    }
}

}  // namespace scotty::verify
