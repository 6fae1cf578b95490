#include "verify/render/render_defaults.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "reference/base/assert.h"
#include "reference/contract/parameter_table.h"

namespace scotty::verify {

namespace {

using reference::parameter;
using reference::ParameterInfo;

/// Bytes of device memory that a path needs, with room to spare; more than this many at once are
/// no faster.
constexpr std::uint64_t kBytesPerPath = 1024;
constexpr std::uint64_t kMostPaths = 1u << 22;

/// Buffers are as large as a batch, which a small picture does not fill.
std::uint64_t device_batch(const Backend& backend) {
    SCOTTY_ASSERT(backend.free_memory, >, 0u);  // or batches would be small, and nobody would know
    const std::uint64_t room = backend.free_memory / 2 / kBytesPerPath;
    return std::clamp<std::uint64_t>(room, 1u << 16, kMostPaths);
}

}  // namespace

void set_render_defaults(const Backend& backend, reference::PipelineParameters& p,
                         const std::function<bool(std::string_view)>& is_given) {
    constexpr auto kImmediate = static_cast<std::uint64_t>(reference::EarlyOut::immediate);
    constexpr auto kPacked = static_cast<std::uint64_t>(reference::HitMode::packed);
    std::vector<std::pair<const ParameterInfo*, std::uint64_t>> fastest;
    if (backend.name == "embree") {
        fastest = {{&parameter("batch_rays"), 1u << 20}};
    } else {
        fastest = {{&parameter("early_out"), kImmediate}, {&parameter("hit_mode"), kPacked}};
    }
    if (backend.name == "cuda" || backend.name == "simt") {
        fastest.insert(fastest.end(), {{&parameter("queue_levels"), 1}, {&parameter("width"), 4}});
    }
    if (backend.name == "cuda") {
        fastest.emplace_back(&parameter("batch_rays"), device_batch(backend));
    }
    for (const auto& [info, value] : fastest) {
        if (!is_given(info->option)) info->set(p, value);
    }
}

}  // namespace scotty::verify
