#include "reference/contract/stage_observer.h"

#include <fmt/format.h>

namespace scotty::reference {

const char* to_string(StageKind kind) {
    switch (kind) {
        case StageKind::primary_rays:
            return "primary_rays";
        case StageKind::scan_counts:
            return "scan_counts";
        case StageKind::intersect_root:
            return "intersect_root";
        case StageKind::intersect:
            return "intersect";
        case StageKind::publish_minimum:
            return "publish_minimum";
        case StageKind::merge_intersections:
            return "merge_intersections";
        case StageKind::direct_light_rays:
            return "direct_light_rays";
        case StageKind::resolve_light:
            return "resolve_light";
        case StageKind::scene_rays:
            return "scene_rays";
        case StageKind::reconstruct_image:
            return "reconstruct_image";
        case StageKind::filter:
            return "filter";
    }
    return "(invalid)";
}

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
