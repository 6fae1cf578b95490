/// Any value that is not finite where it has to be is a failure of its own, and comes first.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "verify/invariants/check_state.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records and vectors

namespace {

/// Counts what is wrong in one buffer and remembers the first.
struct Scan {
    std::uint64_t wrong = 0;
    std::size_t first = 0;
    std::string found;

    template <class T>
    void look(std::size_t index, bool fine, const T& value) {
        if (fine) return;
        if (wrong++ == 0) {
            first = index;
            found = exact(value);
        }
    }
};

bool finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
/// t_max alone may be infinite.
bool finite(const Ray& ray) {
    return finite(ray.origin) && finite(ray.direction) && std::isfinite(ray.t_min) &&
           !std::isnan(ray.t_max);
}
/// "No hit" is the one hit whose distance is infinite.
bool finite(const Hit& hit) {
    return is_hit(hit) ? std::isfinite(hit.t) && std::isfinite(hit.u) && std::isfinite(hit.v)
                       : hit.t == kInfinity && hit.u == 0.0f && hit.v == 0.0f;
}

template <class T>
Scan scan_all(std::span<const T> values) {
    Scan scan;
    for (std::size_t i = 0; i < values.size(); ++i) scan.look(i, finite(values[i]), values[i]);
    return scan;
}

/// Distances of gathered hits: only the slots in use.
Scan scan_hits(const StageView& stage) {
    Scan scan;
    const auto counts = stage.get<std::uint32_t>("hit_counts");
    const auto hits = stage.get<HitCandidate>("hits");
    const std::size_t capacity = counts.empty() ? 0 : hits.size() / counts.size();
    for (std::size_t ray = 0; ray < counts.size(); ++ray) {
        for (std::size_t slot = 0; slot < std::min<std::size_t>(counts[ray], capacity); ++slot) {
            const float t = hits[ray * capacity + slot].t;
            scan.look(ray, std::isfinite(t), t);
        }
    }
    return scan;
}

Scan scan_packed(std::span<const std::uint64_t> packed) {
    Scan scan;
    for (std::size_t ray = 0; ray < packed.size(); ++ray) {
        const auto t = std::bit_cast<float>(static_cast<std::uint32_t>(packed[ray] >> 32));
        scan.look(ray, packed[ray] == ~std::uint64_t{0} || std::isfinite(t), t);
    }
    return scan;
}

Scan scan_minimum(std::span<const float> minimum) {
    Scan scan;
    for (std::size_t ray = 0; ray < minimum.size(); ++ray) {
        const float value = minimum[ray];
        scan.look(ray, value == kInfinity || std::isfinite(value), value);
    }
    return scan;
}

}  // namespace

void check_finite(CheckState& state, const StageView& stage) {
    for (const BufferView& buffer : stage.outputs) {
        Scan scan;
        const std::string_view name = buffer.name;
        if (name == "rays" || name == "shadow_rays") {
            scan = scan_all(stage.get<Ray>(name));
        } else if (name == "merged") {
            scan = scan_all(stage.get<Hit>(name));
        } else if (name == "throughput" || name == "radiance" || name == "potential" ||
                   name == "image" || name == "filtered") {
            scan = scan_all(stage.get<Vec3>(name));
        } else if (name == "hits") {
            scan = scan_hits(stage);
        } else if (name == "packed_hits") {
            scan = scan_packed(stage.get<std::uint64_t>(name));
        } else if (name == "minimum") {
            scan = scan_minimum(stage.get<float>(name));
        }
        if (scan.wrong == 0) continue;
        state.counts.non_finite += scan.wrong;
        const bool of_pixel = name == "image" || name == "filtered";
        Failure failure = failure_at(
            stage, invariant::kNonFinite,
            fmt::format("{} of the buffer's records hold a value that is not finite", scan.wrong));
        if (!of_pixel) failure.ray = static_cast<std::uint32_t>(scan.first);
        failure.field = fmt::format("{}[{}]", name, scan.first);
        failure.expected = "finite values";
        failure.found = scan.found;
        state.add(std::move(failure));
    }
}

}  // namespace scotty::verify
