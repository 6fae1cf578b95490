/// Merging the hits that leaves have found, and publishing minima.
#include <bit>
#include <cstring>
#include <vector>

#include "emulation/kernels/merge_intersections.h"
#include "emulation/kernels/publish_minimum.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::emulation;
using namespace scotty::reference;

namespace {

HitCandidate closest_of(std::vector<HitCandidate> candidates, std::uint32_t count,
                        std::uint32_t capacity) {
    candidates.resize(capacity, {0.0f, 0});  // slots past the count hold hits that would win
    HitView hits{};
    hits.mode = HitMode::buffer;
    hits.capacity = capacity;
    hits.counts = &count;
    hits.candidates = candidates.data();
    return closest_candidate(0, hits);
}

HitCandidate closest_of_packed(std::uint64_t packed) {
    HitView hits{};
    hits.mode = HitMode::packed;
    hits.packed = &packed;
    return closest_candidate(0, hits);
}

}  // namespace

TEST_CASE("merge: the nearest hit wins, in any order, and a tie goes to the lower primitive id",
          "[emulation][merge]") {
    CHECK(closest_of({{2, 5}, {1, 9}, {3, 1}}, 3, 4).primitive == 9);
    CHECK(closest_of({{1, 9}, {1, 4}, {1, 7}}, 3, 4).primitive == 4);
    CHECK(closest_of({{1, 4}, {1, 9}}, 2, 4).primitive == 4);
    CHECK(closest_of({{0, 3}, {0, 2}}, 2, 4).t == 0.0f);
}

TEST_CASE("merge: an empty set of hits is no hit, and slots past the count are not read",
          "[emulation][merge]") {
    CHECK(closest_of({}, 0, 4).primitive == kNone);
    CHECK(closest_of({{5, 6}}, 1, 4).primitive == 6);
    CHECK(closest_of({{5, 6}, {4, 7}}, 9, 2).primitive == 7);  // overfull: only written slots count
    CHECK(closest_of_packed(kNoPackedHit).primitive == kNone);
}

TEST_CASE("merge: packed hits order as (t, primitive) and come back whole", "[emulation][merge]") {
    const auto pack = [](float t, std::uint32_t primitive) {
        return std::uint64_t{std::bit_cast<std::uint32_t>(t)} << 32 | primitive;
    };
    CHECK(pack(0.0f, 5) < pack(1e-40f, 0));
    CHECK(pack(1.0f, 4) < pack(1.0f, 5));
    CHECK(pack(1.0f, kNone - 1) < pack(2.0f, 0));
    CHECK(pack(kInfinity, kNone) < kNoPackedHit);
    CHECK(closest_of_packed(pack(1.5f, 7)).t == 1.5f);
    CHECK(closest_of_packed(pack(1.5f, 7)).primitive == 7);
}

TEST_CASE("merge: distance and barycentrics are brute force's bits", "[emulation][merge]") {
    const Scene scene = scotty::reference::test::soup(50, 0.8f, 3);
    const std::vector<Ray> rays = scotty::reference::test::random_rays(300, 1.5f, 4);
    std::vector<Hit> exact(rays.size());
    brute_force_closest(scene, rays, exact);
    std::vector<std::uint32_t> counts(rays.size());
    std::vector<HitCandidate> candidates(rays.size(), {-1.0f, 0});
    for (std::size_t i = 0; i < rays.size(); ++i) {
        counts[i] = is_hit(exact[i]) ? 1 : 0;
        if (is_hit(exact[i])) candidates[i] = {exact[i].t, exact[i].primitive};
    }
    HitView hits{};
    hits.mode = HitMode::buffer;
    hits.capacity = 1;
    hits.counts = counts.data();
    hits.candidates = candidates.data();
    std::vector<Hit> merged(rays.size());
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        merge_intersections(i, view_of(scene), rays.data(), hits, merged.data());
    }
    CHECK(std::memcmp(merged.data(), exact.data(), merged.size() * sizeof(Hit)) == 0);
    CHECK(std::count(counts.begin(), counts.end(), 1u) > 50);
    CHECK(std::count(counts.begin(), counts.end(), 0u) > 5);
}

TEST_CASE("publish_minimum: what was lowered becomes what is read", "[emulation][merge]") {
    const std::vector<float> lowered{1.0f, kDone, kInfinity};
    std::vector<float> minimum{2.0f, 3.0f, 4.0f};
    publish_minimum(1, lowered.data(), minimum.data());
    CHECK(minimum == std::vector<float>{2.0f, kDone, 4.0f});
}
