#include "verify/oracles/trace_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "reference/base/error.h"
#include "reference/truth/tracers.h"
#include "verify/base/same_bits.h"

namespace scotty::verify {

using reference::Hit;
using reference::Ray;
using reference::TraversalKind;
using reference::Vec3;

namespace {

/// Steele, Lea, Flood: "Fast splittable pseudorandom number generators" (SplitMix64).
class Draws {
 public:
    explicit Draws(std::uint64_t seed) : state_(seed) {}
    std::size_t below(std::size_t end) { return static_cast<std::size_t>(next() % end); }
    float unit() { return static_cast<float>(next() >> 40) * 0x1p-24f; }

 private:
    std::uint64_t next() {
        std::uint64_t x = state_ += 0x9e3779b97f4a7c15ull;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
        return x ^ (x >> 31);
    }
    std::uint64_t state_;
};

struct Probe {
    Ray ray;
    const char* what;
    std::optional<Hit> recorded;  ///< what a watched traversal has found for it
    std::string stage;            ///< of that traversal
};

void add_recorded(const Recording& recording, std::size_t count, Draws& draws,
                  std::vector<Probe>& probes) {
    if (recording.traversals.empty() || recording.traversals.front().rays.empty()) return;
    for (std::size_t i = 0; i < count; ++i) {
        // Every traversal in turn: a few rays of the last bounce are worth as much as the first's.
        const TraversalRecord& from = recording.traversals[i % recording.traversals.size()];
        const std::size_t path = draws.below(from.rays.size());
        Probe probe{from.rays[path], "a ray of the render", from.hits[path], from.stage()};
        if (from.is_shadow()) probe.recorded.reset();  // may have ended at any hit
        probes.push_back(std::move(probe));
    }
}

void add_aimed(const reference::Scene& scene, std::size_t count, Draws& draws,
               std::vector<Probe>& probes) {
    const Vec3 eye = scene.camera.position;
    for (std::size_t i = 0; i < count; ++i) {
        const auto& corners = scene.triangles[draws.below(scene.triangles.size())];
        const Vec3& a = scene.vertices[corners[i % 3]];
        const Vec3& b = scene.vertices[corners[(i + 1) % 3]];
        Ray ray{eye, 0.0f, a - eye, reference::kInfinity};
        const char* what = "a ray at a vertex";
        if (i % 4 == 1) {
            const float along = draws.unit();
            ray.direction = (1.0f - along) * a + along * b - eye;
            what = "a ray at an edge";
        } else if (i % 4 == 2) {
            // Through the middle of the triangle, so that it has something to hit.
            const Vec3& c = scene.vertices[corners[(i + 2) % 3]];
            ray.origin = (1.0f / 3.0f) * (a + b + c);
            ray.direction = Vec3(0.0f, 0.0f, 0.0f);
            const std::size_t axis = draws.below(3);
            const float sign = i % 8 == 2 ? 1.0f : -1.0f;
            (axis == 0 ? ray.direction.x : axis == 1 ? ray.direction.y : ray.direction.z) = sign;
            ray.origin = ray.origin - 3.0f * ray.direction;
            what = "a ray along an axis";
        } else if (i % 4 == 3) {
            ray.direction = 1e-12f * ray.direction;
            what = "a ray of a tiny direction";
        }
        if (reference::is_zero(ray.direction)) continue;
        probes.push_back({ray, what, std::nullopt, ""});
    }
}

/// Each that hits something with other intervals; and intervals that hold no distance at all.
void add_intervals(const std::vector<Hit>& truth, std::vector<Probe>& probes) {
    const std::size_t count = truth.size();
    for (std::size_t i = 0; i < count; ++i) {
        const Ray ray = probes[i].ray;
        const float t = truth[i].t;
        if (!is_hit(truth[i])) continue;
        const auto add = [&](float low, float high, const char* what) {
            Ray other = ray;
            other.t_min = low;
            other.t_max = high;
            probes.push_back({other, what, std::nullopt, ""});
        };
        switch (i % 6) {
            case 0:
                add(ray.t_min, t, "a ray that ends where it hit something does not hit it");
                break;
            case 1:
                add(ray.t_min, std::nextafter(t, reference::kInfinity),
                    "a ray that ends just beyond what it hit hits it");
                break;
            case 2:
                add(t, ray.t_max, "a ray that starts where it hit something hits it");
                break;
            case 3:
                add(std::nextafter(t, reference::kInfinity), ray.t_max,
                    "a ray that starts just beyond what it hit does not hit it");
                break;
            case 4:
                add(t, t, "an interval without a point in it holds no hit");
                break;
            default:
                add(ray.t_min, -1.0f, "a dead ray hits nothing");
                break;
        }
    }
}

Failure failure_of(const char* invariant, const Probe& probe, std::size_t number,
                   const char* query) {
    Failure failure;
    failure.invariant = invariant;
    failure.stage = "trace";
    failure.ray = static_cast<std::uint32_t>(number);
    failure.field = "hit";
    failure.sentence =
        fmt::format("{} ({} query); the ray: {}", probe.what, query, exact(probe.ray));
    return failure;
}

}  // namespace

std::vector<Failure> check_traces(const reference::Scene& scene, const Recording& recording,
                                  const TraceRays& trace, const TraceCheckSettings& settings) {
    const std::uint64_t triangles = std::max<std::uint64_t>(1, scene.triangles.size());
    const auto most = static_cast<std::size_t>(settings.brute_force_tests / (2 * triangles));
    Draws draws(settings.seed);
    std::vector<Probe> probes;
    add_recorded(recording, std::min(settings.recorded, most), draws, probes);
    add_aimed(scene, std::min(settings.aimed, most), draws, probes);
    const auto rays_of = [&] {
        std::vector<Ray> rays;
        rays.reserve(probes.size());
        for (const Probe& probe : probes) rays.push_back(probe.ray);
        return rays;
    };
    std::vector<Failure> failures;
    if (probes.empty()) return failures;
    std::vector<Ray> rays = rays_of();
    std::vector<Hit> truth(rays.size());
    reference::brute_force_closest(scene, rays, truth);
    add_intervals(truth, probes);
    // Neighbours of all kinds in one block, and another ray at the end of each batch.
    for (std::size_t i = probes.size(); i > 1; --i) {
        std::swap(probes[i - 1], probes[draws.below(i)]);
    }
    rays = rays_of();
    truth.resize(rays.size());
    reference::brute_force_closest(scene, rays, truth);

    std::vector<Hit> closest(rays.size());
    std::vector<Hit> any(rays.size());
    try {
        trace(rays, TraversalKind::closest, closest);
        trace(rays, TraversalKind::any, any);
    } catch (const reference::Error& error) {
        Failure failure;
        failure.invariant = "error";
        failure.stage = "trace";
        failure.sentence = error.what();
        return {failure};
    }
    // One of each kind: the first leads.
    const auto find_first = [&](const char* invariant, const char* query, const auto& expected,
                                const std::vector<Hit>& found, const auto& agree) {
        for (std::size_t i = 0; i < probes.size(); ++i) {
            const std::optional<Hit> wanted = expected(i);
            if (!wanted || agree(*wanted, found[i])) continue;
            Failure failure = failure_of(invariant, probes[i], i, query);
            if (!probes[i].stage.empty()) failure.sentence += ", of " + probes[i].stage;
            failure.expected = exact(*wanted);
            failure.found = exact(found[i]);
            failures.push_back(std::move(failure));
            return;
        }
    };
    const auto by_brute_force = [&](std::size_t i) { return std::optional<Hit>(truth[i]); };
    const auto by_recording = [&](std::size_t i) { return probes[i].recorded; };
    const auto same = [](const Hit& a, const Hit& b) { return same_bits(a, b); };
    const auto answer = [&](const Hit& a, const Hit& b) {
        return settings.any_is_closest ? same_bits(a, b) : is_hit(a) == is_hit(b);
    };
    find_first("brute-force", "closest-hit", by_brute_force, closest, same);
    find_first(invariant::kUnwatched, "closest-hit", by_recording, closest, same);
    find_first("brute-force", "any-hit", by_brute_force, any, answer);
    return failures;
}

}  // namespace scotty::verify
