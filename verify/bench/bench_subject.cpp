#include "verify/bench/bench_subject.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <nlohmann/json.hpp>

#include "reference/contract/parameter_table.h"

namespace scotty::verify {

BenchSubject subject_of(const reference::Scene& scene, const BenchSettings& settings) {
    const std::size_t threads =
        settings.threads != 0 ? settings.threads
                              : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    return {scene.name, scene.triangles.size(), settings.parameters,
            threads,    settings.warm_ups,      settings.repeats};
}

std::string heading(const BenchSubject& subject) {
    const auto& p = subject.parameters;
    return fmt::format(
        "{} ({} triangles), {}x{} pixels, {} spp, {} bounces, {} light samples\n"
        "width {}, {} rays per block, queue levels {}, {}early-out {}, {}, {}, shadow {}; {} "
        "threads, "
        "median of {} after {} to warm up\n\n",
        subject.scene, subject.triangles, p.image_width, p.image_height, p.spp, p.bounces,
        p.light_samples, p.width, p.rays_per_block,
        p.queue_levels == 0 ? "all" : std::to_string(p.queue_levels),
        p.queues == reference::QueueKind::pairs ? "queues of pairs, " : "", to_string(p.early_out),
        to_string(p.hit_mode), to_string(p.block_order), to_string(p.shadow_query), subject.threads,
        subject.repeats, subject.warm_ups);
}

nlohmann::json subject_json(const BenchSubject& subject) {
    const auto& p = subject.parameters;
    nlohmann::json out = {{"scene", subject.scene},
                          {"triangles", subject.triangles},
                          {"image", {{"width", p.image_width}, {"height", p.image_height}}},
                          {"threads", subject.threads},
                          {"warm_ups", subject.warm_ups},
                          {"repeats", subject.repeats}};
    for (const reference::ParameterInfo& info : reference::kParameters) {
        if (info.option == "--size") continue;  // "image" says it
        nlohmann::json& member = out[std::string(info.name)];
        if (info.words.empty()) {
            member = info.get(p);
        } else {
            member = text_of(info, p);
        }
    }
    return out;
}

}  // namespace scotty::verify
