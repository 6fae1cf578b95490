/// What fast arithmetic may change passes; a little more, or anything else, does not.
#include "tests/verify/capture_tools.h"
#include "verify/diff/diff.h"
#include "verify/diff/tolerance.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;
using reference::Hit;
using reference::PipelineParameters;
using reference::Ray;
using reference::Vec3;

constexpr const char* kLevel = "bounce0/level1/intersect";

/// A run of exact arithmetic against one that says it was fast, spoiled: the verdict of one buffer.
/// The emulator computes exactly whatever the parameters say, so that the spoiling is all there is.
Verdict verdict_of(const char* stage, const char* buffer, const Spoil& spoil) {
    const TemporaryFolder folder;
    const Capture exact = make_capture(folder / "a", small_parameters());
    PipelineParameters p = small_parameters();
    p.arithmetic = reference::Arithmetic::fast;
    const Capture fast = make_capture(folder / "b", p, spoil);
    const DiffReport report = diff_captures(exact, fast);
    for (const StageResult& result : report.stages) {
        if (result.name != stage) continue;
        for (const BufferResult& found : result.buffers) {
            if (found.name == buffer && !found.input) return found.verdict;
        }
    }
    FAIL("no output " << buffer << " of " << stage);
    return Verdict::differs;
}

/// Spoils the first `rows` hits of the primary rays that hit something.
template <class Change>
Spoil hits(std::size_t rows, const Change& change) {
    return [=](StageCopies& stages) {
        std::size_t done = 0;
        for (Hit& hit : stages.at("bounce0/merge_intersections").output<Hit>("merged")) {
            if (is_hit(hit) && done < rows) {
                change(hit);
                ++done;
            }
        }
        REQUIRE(done == rows);
    };
}

Verdict of_hits(const Spoil& spoil) {
    return verdict_of("bounce0/merge_intersections", "merged", spoil);
}

}  // namespace

TEST_CASE("tolerance: distances may be off by a thousandth", "[verify][tolerance]") {
    CHECK(of_hits(hits(200, [](Hit& hit) { hit.t *= 1.0005f; })) == Verdict::within_tolerance);
    CHECK(of_hits(hits(200, [](Hit& hit) { hit.t *= 1.01f; })) == Verdict::differs);
    // 286 rays: two and a fiftieth of them may be beyond.
    CHECK(of_hits(hits(7, [](Hit& hit) { hit.t *= 1.01f; })) == Verdict::within_tolerance);
    CHECK(of_hits(hits(8, [](Hit& hit) { hit.t *= 1.01f; })) == Verdict::differs);
}

TEST_CASE("tolerance: of coincident triangles either may be hit, but not nothing",
          "[verify][tolerance]") {
    CHECK(of_hits(hits(200, [](Hit& hit) { ++hit.primitive; })) == Verdict::within_tolerance);
    CHECK(of_hits(hits(200, [](Hit& hit) { hit = reference::no_hit(); })) == Verdict::differs);
}

TEST_CASE("tolerance: queues may differ in few entries", "[verify][tolerance]") {
    const auto lose = [](std::uint32_t entries) {
        return [=](StageCopies& stages) {
            const auto queue = stages.at(kLevel).output<std::uint32_t>("child_queue");
            REQUIRE(queue.size() > entries);
            for (std::uint32_t i = 0; i < entries; ++i) queue[i] = 1000000 + i;
        };
    };
    CHECK(verdict_of(kLevel, "child_queue", lose(1)) == Verdict::within_tolerance);
    CHECK(verdict_of(kLevel, "child_queue", lose(100)) == Verdict::differs);
    const auto count = [](std::uint32_t more) {
        return [=](StageCopies& stages) {
            stages.at(kLevel).output<std::uint32_t>("child_counts")[0] += more;
        };
    };
    CHECK(verdict_of(kLevel, "child_counts", count(1)) == Verdict::within_tolerance);
    CHECK(verdict_of(kLevel, "child_counts", count(1000)) == Verdict::differs);
}

TEST_CASE("tolerance: what is no arithmetic may not change at all", "[verify][tolerance]") {
    CHECK(verdict_of("primary_rays", "pixel", [](StageCopies& stages) {
              ++stages.at("primary_rays").output<std::uint32_t>("pixel")[5];
          }) == Verdict::differs);
}

TEST_CASE("tolerance: a launch that is missing is a failure all the same", "[verify][tolerance]") {
    const TemporaryFolder folder;
    const Capture exact = make_capture(folder / "a", small_parameters());
    PipelineParameters p = small_parameters();
    p.arithmetic = reference::Arithmetic::fast;
    const Capture fast = make_capture(folder / "b", p, [](StageCopies& stages) {
        std::erase_if(stages.all(), [](const auto& copy) { return copy.view.name == kLevel; });
    });
    const DiffReport report = diff_captures(exact, fast);
    CHECK_FALSE(report.passed());
    REQUIRE(report.first() != nullptr);
    CHECK(report.first()->stage == kLevel);
}

TEST_CASE("tolerance: exact runs are held to the bit", "[verify][tolerance]") {
    const TemporaryFolder folder;
    const Capture a = make_capture(folder / "a", small_parameters());
    const Capture b = make_capture(folder / "b", small_parameters(),
                                   hits(1, [](Hit& hit) { hit.t *= 1.0000003f; }));
    CHECK_FALSE(diff_captures(a, b).passed());
}
