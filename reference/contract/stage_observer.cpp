#include "reference/contract/stage_observer.h"

#include <fmt/format.h>

namespace scotty::reference {

const BufferView* StageView::find(std::string_view buffer) const {
    // Outputs first: where a stage updates a buffer in place, what it made of it is meant.
    for (const BufferView& view : outputs) {
        if (view.name == buffer) return &view;
    }
    for (const BufferView& view : inputs) {
        if (view.name == buffer) return &view;
    }
    return nullptr;
}

std::string stage_name(StageKind kind, std::uint32_t batch, std::uint32_t bounce,
                       std::uint32_t light, std::uint32_t level, bool several_batches) {
    std::string name;
    if (several_batches) name += fmt::format("batch{}/", batch);
    if (bounce != kNotApplicable) {
        name += fmt::format("bounce{}/", bounce);
    } else if (level != kNotApplicable || kind == StageKind::merge_intersections) {
        name += "trace/";  // a traversal of rays that came from elsewhere
    }
    if (light != kNotApplicable) name += fmt::format("light{}/", light);
    if (level != kNotApplicable) name += fmt::format("level{}/", level);
    return name + to_string(kind);
}

}  // namespace scotty::reference
