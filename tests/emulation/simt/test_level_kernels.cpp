/// The kernels of a traversal alone, on handmade levels.
#include <bit>
#include <numeric>

#include "gpu/kernels/clear_traversal.h"
#include "gpu/kernels/intersect.h"
#include "gpu/kernels/intersect_root.h"
#include "gpu/kernels/merge_intersections.h"
#include "gpu/kernels/publish_minimum.h"
#include "gpu/kernels/scan_counts.h"
#include "reference/truth/tracers.h"
#include "tests/emulation/one_level.h"
#include "tests/emulation/simt/executor_tools.h"

namespace {

using namespace scotty::simt::test;
using scotty::emulation::test::kPoison;
using scotty::emulation::test::OneLevel;
using scotty::emulation::test::sorted;
using scotty::gpu::simt::FaultView;
using scotty::gpu::simt::HitView;
using scotty::gpu::simt::LevelView;
using scotty::gpu::simt::MinimumView;
using scotty::reference::Hit;
using scotty::reference::HitCandidate;
using scotty::reference::kInfinity;
using scotty::reference::kNone;
using scotty::reference::Ray;
namespace simt = scotty::gpu::simt;

using Words = std::vector<std::uint32_t>;

/// A level of inner nodes for the CUDA kernels, which also scan it.
template <int Width>
struct Level : OneLevel<Width> {
    Level(const Words& queue_lengths, std::uint32_t seed) : OneLevel<Width>(queue_lengths, seed) {}

    std::vector<std::uint64_t> tiles;

    std::uint32_t scan_blocks() const {
        return simt::scan_blocks(static_cast<std::uint32_t>(this->inner.size()),
                                 static_cast<std::uint32_t>(this->parents.size()));
    }
    LevelView cuda_view(FaultView& faults) {
        tiles.assign(1 + scan_blocks(), 0);
        return {1,
                static_cast<std::uint32_t>(this->inner.size()),
                this->first_child(),
                static_cast<std::uint32_t>(this->parents.size()),
                static_cast<std::uint32_t>(this->child_queue.size()),
                this->parents.data(),
                this->node_counts.data(),
                this->queue_offsets.data(),
                this->queue.data(),
                this->block_offsets.data(),
                this->child_counts.data(),
                this->child_offsets.data(),
                this->child_queue.data(),
                reinterpret_cast<std::uint32_t*>(tiles.data()),
                tiles.data() + 1,
                &faults};
    }

    /// Scans and runs the level kernel with the executor; `blocks` are resident.
    FaultView run_cuda(Executor& executor, std::uint32_t threads, std::uint32_t blocks,
                       bool culls = false, bool strided = false) {
        this->scan(threads);
        const Words expected_blocks =
            std::exchange(this->block_offsets, Words(this->block_offsets.size(), kPoison));
        const Words expected_children =
            std::exchange(this->child_offsets, Words(this->child_offsets.size(), kPoison));
        FaultView faults{};
        executor.launch("scan_counts", scan_blocks(), simt::kScanThreads, simt::scan_counts,
                        cuda_view(faults), threads);
        CHECK(this->block_offsets == expected_blocks);
        CHECK(this->child_offsets == expected_children);
        const simt::BvhView<Width> bvh{this->inner.data(), nullptr, nullptr,
                                       this->node_refs.data()};
        const MinimumView minima{culls ? 1u : 0u, 0, this->minimum.data(), this->minimum.data()};
        executor.launch("intersect", blocks, threads, simt::intersect<Width>, bvh,
                        this->rays.data(), cuda_view(faults), HitView{}, minima, strided);
        return faults;
    }
};

const Words kQueues{0, 1, 31, 300, 0, 64, 65, 500, 3, 0};

template <int Width>
void check_width() {
    std::uint32_t seed = Width;
    for (const std::uint32_t threads : {32u, 64u, 96u, 256u, 1024u}) {
        for (const SimtOptions& options : every_order()) {
            ++seed;
            Level<Width> level(kQueues, seed);
            const bool culls = seed % 2 == 0;
            if (culls) {
                for (float& t : level.minimum) t = static_cast<float>(level.below(300)) * 0.01f;
            }
            Executor executor(options);
            const FaultView faults =
                level.run_cuda(executor, threads, 1 + seed % 5, culls, seed % 3 == 0);
            CHECK(faults.node_overflow == 0);
            const auto pushed = level.pushed();
            for (std::size_t child = 0; child < pushed.size(); ++child) {
                CHECK(sorted(level.queue_of(child)) == sorted(pushed[child]));
            }
            // Nothing was written outside the queues.
            Words outside = level.child_queue;
            for (std::size_t child = 0; child < pushed.size(); ++child) {
                const auto begin = outside.begin() + level.child_offsets[child];
                std::fill(begin, begin + level.child_counts[child], kPoison);
            }
            CHECK(std::count(outside.begin(), outside.end(), kPoison) ==
                  static_cast<std::ptrdiff_t>(outside.size()));
        }
    }
}

TEST_CASE("scan_counts: any number of nodes, against a straight loop", "[simt][kernels]") {
    // The last is more than two windows of 32 tiles.
    for (const std::uint32_t nodes : {1u, 2u, 31u, 1023u, 1024u, 1025u, 40000u, 75000u}) {
        for (const SimtOptions& options : every_order()) {
            scotty::reference::test::Random random(nodes);
            Words counts(nodes);
            for (std::uint32_t& n : counts)
                n = static_cast<std::uint32_t>(random() % 3 == 0 ? 0 : random() % 700);
            Words parents(2 * nodes - 1);
            for (std::uint32_t i = 0; i < parents.size(); ++i) parents[i] = i / 2;
            Words blocks(nodes + 2, kPoison);
            Words children(parents.size() + 2, kPoison);
            FaultView faults{};
            LevelView level{};
            level.node_count = nodes;
            level.child_node_count = static_cast<std::uint32_t>(parents.size());
            level.queue_capacity = 1000;
            level.parents = parents.data();
            level.node_counts = counts.data();
            level.block_offsets = blocks.data();
            level.child_offsets = children.data();
            level.faults = &faults;
            const std::uint32_t tiles = simt::scan_blocks(level.node_count, level.child_node_count);
            std::vector<std::uint64_t> scan(1 + tiles, 0);
            level.scan_ticket = reinterpret_cast<std::uint32_t*>(scan.data());
            level.scan_tiles = scan.data() + 1;
            Executor executor(options);
            executor.launch("scan_counts", tiles, simt::kScanThreads, simt::scan_counts, level,
                            64u);
            // Sums of tiles that are not complete yet were looked at, and added.
            const bool late = options.schedule == ScheduleKind::adversarial ||
                              options.schedule == ScheduleKind::shuffled;
            if (late && nodes == 75000) CHECK(executor.late_loads() > 10 * std::uint64_t{tiles});
            if (!late) CHECK(executor.late_loads() == 0);
            Words expected{0};
            for (std::uint32_t i = 0; i < nodes; ++i) {
                expected.push_back(expected.back() + (counts[i] + 63) / 64);
            }
            expected.push_back(kPoison);  // nothing is written after the total
            CHECK((blocks == expected));  // a failure would print all of them otherwise
            std::uint32_t sum = 0;
            expected = {0};
            for (const std::uint32_t parent : parents) {
                expected.push_back(sum += counts[parent]);
            }
            expected.push_back(kPoison);
            CHECK((children == expected));
            CHECK(faults.queue_needed == (sum > 1000 ? sum : 0));
        }
    }
}

TEST_CASE("intersect: every child's queue is a straight loop's, for widths 2 to 16",
          "[simt][kernels]") {
    SECTION("2") { check_width<2>(); }
    SECTION("4") { check_width<4>(); }
    SECTION("8") { check_width<8>(); }
    SECTION("16") { check_width<16>(); }
}

TEST_CASE(
    "intersect: a child's region that is too small is a fault, and nothing is written past it",
    "[simt][kernels]") {
    Level<4> level({200, 200}, 5);
    level.scan(64);
    const auto pushed = level.pushed();
    // The first child with rays gets a region of one entry less than it needs.
    std::size_t victim = 0;
    while (pushed[victim].size() < 2) ++victim;
    const auto room = static_cast<std::uint32_t>(pushed[victim].size() - 1);
    const std::uint32_t cut = level.child_offsets[victim + 1] - level.child_offsets[victim] - room;
    for (std::size_t i = victim + 1; i < level.child_offsets.size(); ++i) {
        level.child_offsets[i] -= cut;
    }
    FaultView faults{};
    const simt::BvhView<4> bvh{level.inner.data(), nullptr, nullptr, level.node_refs.data()};
    Executor().launch("intersect", 3, 64, simt::intersect<4>, bvh, level.rays.data(),
                      level.cuda_view(faults), HitView{},
                      MinimumView{0, 0, level.minimum.data(), level.minimum.data()}, false);
    CHECK(faults.node_overflow == level.first_child() + victim + 1);
    for (std::size_t child = 0; child < pushed.size(); ++child) {
        if (child != victim) CHECK(sorted(level.queue_of(child)) == sorted(pushed[child]));
    }
}

TEST_CASE("scan_counts: after an overflow no level has blocks, which would read unwritten slots",
          "[simt][kernels]") {
    Level<4> level({200, 200}, 5);
    level.scan(64);
    const Words children = level.child_offsets;
    FaultView faults{};
    faults.node_overflow = 2;
    Executor executor;
    executor.launch("scan_counts", level.scan_blocks(), simt::kScanThreads, simt::scan_counts,
                    level.cuda_view(faults), 64u);
    CHECK(level.block_offsets == Words(level.block_offsets.size(), 0));
    CHECK(level.child_offsets == children);
    const simt::BvhView<4> bvh{level.inner.data(), nullptr, nullptr, level.node_refs.data()};
    executor.launch("intersect", 3, 64, simt::intersect<4>, bvh, nullptr, level.cuda_view(faults),
                    HitView{}, MinimumView{}, false);
    CHECK(level.child_counts == Words(level.child_counts.size(), 0));
}

TEST_CASE("intersect_root: all rays by id, begun, whether or not blocks take several turns",
          "[simt][kernels]") {
    for (const std::uint32_t threads : {32u, 128u, 1024u}) {
        for (const SimtOptions& options : every_order()) {
            Level<8> level({500}, 3);  // as many as it has rays
            std::iota(level.queue.begin(), level.queue.end(), 0u);
            level.scan(threads);
            FaultView faults{};
            Words counts(500, kPoison);
            std::vector<float> minimum(500, -7.0f);
            std::vector<float> lowered(500, -7.0f);
            const HitView hits{0, 1, counts.data(), nullptr, nullptr, nullptr};
            const simt::BvhView<8> bvh{level.inner.data(), nullptr, nullptr, nullptr};
            Executor(options).launch("intersect_root", 2, threads, simt::intersect_root<8>, bvh,
                                     level.rays.data(), 500u, level.cuda_view(faults), hits,
                                     MinimumView{1, 0, minimum.data(), lowered.data()});
            CHECK(counts == Words(500, 0));
            for (std::size_t ray = 0; ray < 500; ++ray) {
                CHECK(minimum[ray] == level.rays[ray].t_max);
                CHECK(lowered[ray] == level.rays[ray].t_max);
            }
            const auto pushed = level.pushed();
            for (std::size_t child = 0; child < pushed.size(); ++child) {
                CHECK(sorted(level.queue_of(child)) == pushed[child]);
            }
        }
    }
}

/// A leaf of many triangles, whose rays' hits are known.
struct OneLeaf {
    explicit OneLeaf(std::uint32_t triangle_count)
        : scene(scotty::reference::test::soup(triangle_count, 0.8f, 3)),
          rays(scotty::reference::test::random_rays(300, 1.5f, 4)),
          exact(rays.size()) {
        for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
            const auto& [a, b, c] = scene.triangles[i];
            triangles.push_back({scene.vertices[a], scene.vertices[b], scene.vertices[c], i});
        }
        leaf = {0, triangle_count};
        brute_force_closest(scene, rays, exact);
        queue.resize(rays.size());
        std::iota(queue.begin(), queue.end(), 0u);
    }

    void run(Executor& executor, const HitView& hits, const MinimumView& minimum,
             std::uint32_t threads) {
        const auto count = static_cast<std::uint32_t>(queue.size());
        const std::uint32_t ref = scotty::reference::kLeafBit;
        const Words queue_offsets{0, count};
        const Words blocks{0, (count + threads - 1) / threads};
        std::vector<simt::TriangleRows> rows;
        for (const auto& triangle : triangles) rows.push_back(simt::rows_of(triangle));
        FaultView faults{};
        LevelView level{};
        level.node_count = 1;
        level.node_counts = &count;
        level.queue_offsets = queue_offsets.data();
        level.queue = queue.data();
        level.block_offsets = const_cast<std::uint32_t*>(blocks.data());
        level.faults = &faults;
        executor.launch("intersect", 4, threads, simt::intersect<8>,
                        simt::BvhView<8>{nullptr, &leaf, rows.data(), &ref}, rays.data(), level,
                        hits, minimum, false);
    }

    scotty::reference::Scene scene;
    std::vector<Ray> rays;
    std::vector<Hit> exact;
    std::vector<scotty::reference::LeafTriangle> triangles;
    scotty::reference::Leaf leaf{};
    Words queue;
};

TEST_CASE("intersect: a leaf's closest hits are brute force's bits, in both hit modes",
          "[simt][kernels]") {
    for (const std::uint32_t triangles : {1u, 63u, 64u, 65u, 200u}) {
        OneLeaf leaf(triangles);
        for (const SimtOptions& options : every_order()) {
            for (const std::uint32_t threads : {32u, 64u, 512u}) {
                Executor executor(options);
                FaultView faults{};
                Words counts(leaf.rays.size(), 0);
                std::vector<HitCandidate> candidates(leaf.rays.size(), {-7.0f, kPoison});
                std::vector<std::uint64_t> packed(leaf.rays.size(), simt::kNoPackedHit);
                std::vector<float> minimum(leaf.rays.size(), kInfinity);
                HitView hits{0, 1, counts.data(), candidates.data(), packed.data(), &faults};
                leaf.run(executor, hits, {1, 0, minimum.data(), minimum.data()}, threads);
                hits.packed_mode = 1;
                leaf.run(executor, hits, {}, threads);
                std::size_t found = 0;
                for (std::size_t i = 0; i < leaf.rays.size(); ++i) {
                    const Hit& exact = leaf.exact[i];
                    const bool hit = is_hit(exact);
                    found += hit ? 1 : 0;
                    CHECK(counts[i] == (hit ? 1 : 0));
                    if (!hit) {
                        CHECK(candidates[i].primitive == kPoison);
                        CHECK(packed[i] == simt::kNoPackedHit);
                        continue;
                    }
                    CHECK(candidates[i].primitive == exact.primitive);
                    CHECK(candidates[i].t == exact.t);
                    CHECK(minimum[i] == exact.t);
                    CHECK(packed[i] == (std::uint64_t{std::bit_cast<std::uint32_t>(exact.t)} << 32 |
                                        exact.primitive));
                }
                CHECK(faults.hits_needed == 0);
                CHECK((triangles < 63 || found > 20));
            }
        }
    }
}

TEST_CASE(
    "intersect: a full hit buffer is a fault that says how much is needed, a ray that is done is "
    "not recorded twice",
    "[simt][kernels]") {
    OneLeaf leaf(65);
    Executor executor;
    FaultView faults{};
    Words counts(leaf.rays.size(), 2);  // two were there before
    std::vector<HitCandidate> candidates(2 * leaf.rays.size(), {-7.0f, kPoison});
    std::vector<float> minimum(leaf.rays.size(), kInfinity);
    const HitView hits{0, 2, counts.data(), candidates.data(), nullptr, &faults};
    leaf.run(executor, hits, {1, 1, minimum.data(), minimum.data()}, 64);
    CHECK(faults.hits_needed == 3);
    for (std::size_t i = 0; i < leaf.rays.size(); ++i) {
        CHECK(candidates[2 * i].primitive == kPoison);
        CHECK(minimum[i] == (is_hit(leaf.exact[i]) ? simt::kDone : kInfinity));
    }
    const Words before = counts;
    leaf.run(executor, hits, {1, 1, minimum.data(), minimum.data()}, 64);
    CHECK(counts == before);
}

TEST_CASE("clear_traversal: all rays at the root, and zeros, as far as they go and no further",
          "[simt][kernels]") {
    for (const SimtOptions& options : every_order()) {
        Words counts(301, kPoison);
        std::vector<std::uint64_t> scans(501, 5);
        FaultView faults{1, 2, 3};
        Executor(options).launch("clear_traversal", 2, 256, simt::clear_traversal, 77u, 300u,
                                 counts.data(), 500u, scans.data(), &faults);
        Words expected(301, 0);
        expected.front() = 77;
        expected.back() = kPoison;
        CHECK(counts == expected);
        std::vector<std::uint64_t> zeros(501, 0);
        zeros.back() = 5;
        CHECK(scans == zeros);
        CHECK(faults.hits_needed + faults.queue_needed + faults.node_overflow == 0);
    }
}

TEST_CASE("publish_minimum: copies what there is and no more", "[simt][kernels]") {
    std::vector<float> lowered(1001);
    std::iota(lowered.begin(), lowered.end(), 0.5f);
    std::vector<float> minimum(1001, -1.0f);
    Executor().launch("publish_minimum", 4, 256, simt::publish_minimum, 1000u, lowered.data(),
                      minimum.data());
    CHECK(minimum[1000] == -1.0f);
    minimum[1000] = lowered[1000];
    CHECK(minimum == lowered);
}

TEST_CASE(
    "merge_intersections: the closest of several hits, ties to the lower primitive, with brute "
    "force's bits",
    "[simt][kernels]") {
    const OneLeaf leaf(50);
    const auto view = scotty::reference::view_of(leaf.scene);
    const auto rays = static_cast<std::uint32_t>(leaf.rays.size());
    Words counts(rays, 0);
    std::vector<HitCandidate> candidates(3 * rays, {0.0f, 0});  // unused slots would win
    std::vector<std::uint64_t> packed(rays, simt::kNoPackedHit);
    for (std::uint32_t i = 0; i < rays; ++i) {
        const Hit& exact = leaf.exact[i];
        if (!is_hit(exact)) continue;
        packed[i] = std::uint64_t{std::bit_cast<std::uint32_t>(exact.t)} << 32 | exact.primitive;
        counts[i] = 1 + i % 3;
        for (std::uint32_t slot = 0; slot < counts[i]; ++slot) {
            const bool tie = exact.primitive < 49 && i % 2 == 0;
            candidates[3 * i + slot] = {tie ? exact.t : 2.0f * exact.t + 1.0f, 49};
        }
        candidates[3 * i + i % counts[i]] = {exact.t, exact.primitive};
        if (counts[i] == 3) counts[i] = 8;  // more than fit: only written slots count
    }
    for (const std::uint32_t packed_mode : {0u, 1u}) {
        for (const SimtOptions& options : every_order()) {
            std::vector<Hit> merged(rays);
            Executor(options).launch(
                "merge_intersections", (rays + 255) / 256, 256, simt::merge_intersections, rays,
                view, leaf.rays.data(),
                HitView{packed_mode, 3, counts.data(), candidates.data(), packed.data(), nullptr},
                merged.data());
            CHECK(std::memcmp(merged.data(), leaf.exact.data(), rays * sizeof(Hit)) == 0);
        }
    }
}

}  // namespace
