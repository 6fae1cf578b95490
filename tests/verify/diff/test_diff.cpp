/// The diff: passes what is equal, and names the right place where one thing was spoiled.
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/diff/diff.h"
#include "verify/diff/diff_parts.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

constexpr emulation::DeviceOptions kSerial{.schedule = emulation::ScheduleKind::linear};
constexpr const char* kLevel = "bounce0/level1/intersect";

void one_ulp(float& value) {
    value = std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) + 1);
}

/// A run as it was (A) against the same run spoiled (B).
struct Spoiled {
    TemporaryFolder folder;
    DiffReport report;

    explicit Spoiled(const Spoil& spoil, PipelineParameters p = small_parameters(),
                     const emulation::DeviceOptions& device = kSerial) {
        const Capture a = make_capture(folder / "a", p, {}, kSerial);
        const Capture b = make_capture(folder / "b", p, spoil, device);
        report = diff_captures(a, b);
        INFO(to_text(report));
    }
    const Divergence& first() const {
        REQUIRE_FALSE(report.passed());
        REQUIRE(report.first() != nullptr);
        return *report.first();
    }
};

const StageResult& stage(const DiffReport& report, std::string_view name) {
    for (const StageResult& result : report.stages) {
        if (result.name == name) return result;
    }
    FAIL("no stage " << name);
    return report.stages.front();
}

Verdict verdict(const DiffReport& report, std::string_view name, std::string_view buffer) {
    for (const BufferResult& result : stage(report, name).buffers) {
        if (result.name == buffer && !result.input) return result.verdict;
    }
    FAIL("no output " << buffer << " of " << name);
    return Verdict::differs;
}

/// Two children of the stage with at least `least` rays each: positions in the next level.
std::pair<std::uint32_t, std::uint32_t> two_children(StageCopy& copy, std::uint32_t least = 2) {
    const auto counts = copy.output<std::uint32_t>("child_counts");
    std::vector<std::uint32_t> found;
    for (std::uint32_t child = 0; child < counts.size(); ++child) {
        if (counts[child] >= least) found.push_back(child);
    }
    REQUIRE(found.size() >= 2);
    return {found[0], found[1]};
}

std::uint32_t level_begin(std::uint32_t level) {
    return spheres_input(small_parameters()).bvh.level_begins[level];
}

TEST_CASE("diff: a run against itself in another order of blocks is identical or reordered",
          "[verify][diff]") {
    PipelineParameters p = small_parameters();
    p.hit_mode = GENERATE(HitMode::buffer, HitMode::packed);
    p.early_out = GENERATE(EarlyOut::off, EarlyOut::level);
    const Spoiled run({}, p, {.schedule = emulation::ScheduleKind::reversed});
    INFO(to_text(run.report));
    CHECK(run.report.passed());
    CHECK(run.report.first() == nullptr);
    std::size_t reordered = 0;
    for (const StageResult& result : run.report.stages) {
        CHECK(result.verdict <= Verdict::reordered);
        reordered += result.verdict == Verdict::reordered ? 1 : 0;
    }
    CHECK(reordered > 0);
    CHECK(verdict(run.report, "bounce0/merge_intersections", "merged") == Verdict::identical);
    CHECK(verdict(run.report, "reconstruct_image", "image") == Verdict::identical);
}

TEST_CASE("diff: one ulp in one ray is found, with ray, field, ulps and pixel", "[verify][diff]") {
    const Spoiled run([](StageCopies& stages) {
        one_ulp(stages.at("primary_rays").output<Ray>("rays")[41].direction.y);
    });
    const Divergence& first = run.first();
    CHECK(first.stage == "primary_rays");
    CHECK(first.launch == 0);
    CHECK(first.buffer == "rays");
    CHECK(first.field == "direction.y");
    CHECK(first.ray == 41);
    CHECK(first.ulps == 1);
    CHECK(first.pixel_x == 20 % 13);
    CHECK(first.pixel_y == 20 / 13);
    CHECK(first.sample == 1);
    CHECK_FALSE(first.input);
    CHECK_THAT(first.a, ContainsSubstring("0x"));
    CHECK(first.a != first.b);
    CHECK_THAT(first.replay, ContainsSubstring("scotty replay") &&
                                 ContainsSubstring("--stage primary_rays") &&
                                 ContainsSubstring("--backend emulator"));
    CHECK(stage(run.report, "primary_rays").buffers[0].different == 1);
}

TEST_CASE("diff: two ids swapped between two nodes", "[verify][diff]") {
    std::uint32_t node = 0;
    const Spoiled run([&](StageCopies& stages) {
        StageCopy& copy = stages.at(kLevel);
        const auto [one, other] = two_children(copy);
        const auto queue = copy.output<std::uint32_t>("child_queue");
        const auto offsets = copy.input<std::uint32_t>("child_offsets");
        const auto counts = copy.output<std::uint32_t>("child_counts");
        // Rays that the other node does not have: a swap of one ray with itself is none.
        for (std::uint32_t i = 0; i < counts[one]; ++i) {
            for (std::uint32_t j = 0; j < counts[other]; ++j) {
                std::uint32_t& a = queue[offsets[one] + i];
                std::uint32_t& b = queue[offsets[other] + j];
                const auto in = [&](std::uint32_t ray, std::uint32_t child) {
                    const auto region = queue.subspan(offsets[child], counts[child]);
                    return std::find(region.begin(), region.end(), ray) != region.end();
                };
                if (in(a, other) || in(b, one)) continue;
                std::swap(a, b);
                node = level_begin(2) + one;
                return;
            }
        }
        FAIL("no two rays to swap");
    });
    const Divergence& first = run.first();
    CHECK(first.stage == kLevel);
    CHECK(first.level == 1);
    CHECK(first.buffer == "child_queue");
    CHECK(first.node == node);
    CHECK(first.ray != kNotApplicable);
    CHECK(first.block != kNotApplicable);
    CHECK(first.pixel_x != kNotApplicable);
    CHECK_THAT(first.sentence, ContainsSubstring("holds another ray"));
    CHECK(verdict(run.report, kLevel, "child_counts") == Verdict::identical);
}

TEST_CASE("diff: a lost ray", "[verify][diff]") {
    std::uint32_t node = 0, ray = 0;
    const Spoiled run([&](StageCopies& stages) {
        StageCopy& copy = stages.at(kLevel);
        const auto [child, other] = two_children(copy);
        std::uint32_t& count = copy.output<std::uint32_t>("child_counts")[child];
        --count;
        node = level_begin(2) + child;
        ray = copy.output<std::uint32_t>(
            "child_queue")[copy.input<std::uint32_t>("child_offsets")[child] + count];
    });
    const Divergence& first = run.first();
    CHECK(first.stage == kLevel);
    CHECK(first.buffer == "child_queue");
    CHECK(first.node == node);
    CHECK(first.ray == ray);
    CHECK(first.block != kNotApplicable);
    CHECK_THAT(first.sentence, ContainsSubstring("the ray is missing from the node's queue"));
    CHECK(verdict(run.report, kLevel, "child_counts") == Verdict::differs);
}

TEST_CASE("diff: a ray that is in a queue twice", "[verify][diff]") {
    std::uint32_t ray = 0;
    const Spoiled run([&](StageCopies& stages) {
        StageCopy& copy = stages.at(kLevel);
        const auto [child, other] = two_children(copy);
        const auto queue = copy.output<std::uint32_t>("child_queue");
        const std::uint32_t begin = copy.input<std::uint32_t>("child_offsets")[child];
        ray = queue[begin];
        queue[begin + 1] = queue[begin];
    });
    const Divergence& first = run.first();
    CHECK(first.stage == kLevel);
    CHECK(first.buffer == "child_queue");
    CHECK_THAT(first.sentence, ContainsSubstring("twice"));
    CHECK_THAT(first.b, ContainsSubstring(std::to_string(ray)));
}

TEST_CASE("diff: a queue in another order is reordered, not different", "[verify][diff]") {
    const Spoiled run([&](StageCopies& stages) {
        StageCopy& copy = stages.at(kLevel);
        const auto [child, other] = two_children(copy);
        const auto queue = copy.output<std::uint32_t>("child_queue");
        const std::uint32_t begin = copy.input<std::uint32_t>("child_offsets")[child];
        std::swap(queue[begin], queue[begin + 1]);
    });
    INFO(to_text(run.report));
    CHECK(run.report.passed());
    CHECK(verdict(run.report, kLevel, "child_queue") == Verdict::reordered);
    CHECK(stage(run.report, kLevel).verdict == Verdict::reordered);
}

/// A leaf launch in which some ray has gathered at least `least` hits: stage and ray.
std::pair<StageCopy*, std::uint32_t> with_hits(StageCopies& stages, std::uint32_t least) {
    for (StageCopy& copy : stages.all()) {
        if (copy.view.kind != StageKind::intersect) continue;
        const auto counts = copy.output<std::uint32_t>("hit_counts");
        for (std::uint32_t ray = 0; ray < counts.size(); ++ray) {
            if (counts[ray] >= least) return {&copy, ray};
        }
    }
    FAIL("no ray with so many hits");
    return {nullptr, 0};
}

PipelineParameters without_early_out() {
    PipelineParameters p = small_parameters();
    p.early_out = EarlyOut::off;
    return p;
}

TEST_CASE("diff: one ulp in one gathered hit is found, with the leaf and its block",
          "[verify][diff]") {
    std::string name;
    std::uint32_t ray = 0;
    const Spoiled run([&](StageCopies& stages) {
        const auto [copy, of] = with_hits(stages, 1);
        name = copy->view.name;
        ray = of;
        const auto hits = copy->output<HitCandidate>("hits");
        one_ulp(hits[of * (hits.size() / copy->output<std::uint32_t>("hit_counts").size())].t);
    });
    const Divergence& first = run.first();
    CHECK(first.stage == name);
    CHECK(first.buffer == "hits");
    CHECK(first.field == "t");
    CHECK(first.ray == ray);
    CHECK(first.ulps == 1);
    CHECK(first.node != kNotApplicable);
    CHECK(first.block != kNotApplicable);
    CHECK(first.pixel_x != kNotApplicable);
}

TEST_CASE("diff: a lost hit, and hits in another order", "[verify][diff]") {
    std::string name;
    std::uint32_t ray = 0;
    const Spoiled lost(
        [&](StageCopies& stages) {
            const auto [copy, of] = with_hits(stages, 2);
            name = copy->view.name;
            ray = of;
            --copy->output<std::uint32_t>("hit_counts")[of];
        },
        without_early_out());
    CHECK(lost.first().stage == name);
    CHECK(lost.first().buffer == "hits");
    CHECK(lost.first().ray == ray);
    CHECK_THAT(lost.first().sentence, ContainsSubstring("a hit of the ray is missing"));
    CHECK_THAT(lost.first().b, ContainsSubstring("no such hit"));

    const Spoiled swapped(
        [&](StageCopies& stages) {
            const auto [copy, of] = with_hits(stages, 2);
            const auto hits = copy->output<HitCandidate>("hits");
            const std::size_t slots =
                hits.size() / copy->output<std::uint32_t>("hit_counts").size();
            std::swap(hits[of * slots], hits[of * slots + 1]);
        },
        without_early_out());
    CHECK(swapped.report.passed());
    CHECK(verdict(swapped.report, name, "hits") == Verdict::reordered);
}

TEST_CASE("diff: a packed hit names t before the primitive", "[verify][diff]") {
    PipelineParameters p = small_parameters();
    p.hit_mode = HitMode::packed;
    const auto spoiled_by = [&](std::uint64_t change) {
        return Spoiled(
            [&](StageCopies& stages) {
                for (std::uint64_t& hit :
                     stages.at("bounce0/merge_intersections").input<std::uint64_t>("packed_hits")) {
                    if (hit == ~std::uint64_t{0}) continue;
                    hit += change;
                    return;
                }
            },
            p);
    };
    const Divergence first = spoiled_by(std::uint64_t{1} << 32 | 1).first();
    CHECK(first.stage == "bounce0/merge_intersections");
    CHECK(first.buffer == "packed_hits");
    CHECK(first.field == "t");
    CHECK(first.ulps == 1);
    CHECK(first.input);
    CHECK(spoiled_by(1).first().field == "primitive");
}

TEST_CASE("diff: a wrong scan names the node", "[verify][diff]") {
    const Spoiled run([](StageCopies& stages) {
        ++stages.at("bounce0/level1/scan_counts").output<std::uint32_t>("child_offsets")[2];
    });
    CHECK(run.first().stage == "bounce0/level1/scan_counts");
    CHECK(run.first().buffer == "child_offsets");
    CHECK(run.first().node == level_begin(2) + 2);
}

TEST_CASE("diff: what a stage was handed wrong is told from what it did wrong", "[verify][diff]") {
    const Spoiled run([](StageCopies& stages) {
        one_ulp(stages.at("bounce0/light0/resolve_light").input<Vec3>("potential")[3].y);
        one_ulp(stages.at("bounce0/light0/resolve_light").output<Vec3>("radiance")[3].y);
    });
    CHECK(run.first().input);
    CHECK(run.first().buffer == "potential");
    CHECK(run.first().field == "g");
    CHECK_THAT(run.first().sentence, ContainsSubstring("handed"));
}

TEST_CASE("diff: a value that is not finite is counted and named before all else",
          "[verify][diff]") {
    const Spoiled run([](StageCopies& stages) {
        stages.at("bounce0/scene_rays").output<Vec3>("radiance")[17].g = std::nanf("");
        stages.at("bounce0/scene_rays").output<Vec3>("radiance")[18].b = -kInfinity;
    });
    CHECK_FALSE(run.report.passed());
    CHECK(run.report.non_finite_values() == 2);
    const NonFinite* found = run.report.first_non_finite();
    REQUIRE(found != nullptr);
    CHECK(found->in_b);
    CHECK(found->stage == "bounce0/scene_rays");
    CHECK(found->buffer == "radiance");
    CHECK(found->first_row == 17);
    CHECK(found->field == "g");
    const std::string text = to_text(run.report);
    CHECK(text.find("2 values are not finite") < text.find("first divergence"));
}

TEST_CASE("diff: the same NaN on both sides fails all the same", "[verify][diff]") {
    const TemporaryFolder folder;
    const Spoil nan = [](StageCopies& stages) {
        stages.at("reconstruct_image").output<Vec3>("image")[5].r = std::nanf("");
    };
    const Capture a = make_capture(folder / "a", small_parameters(), nan, kSerial);
    const DiffReport report = diff_captures(a, a);
    CHECK_FALSE(report.passed());
    CHECK(report.first() == nullptr);
    CHECK(report.non_finite_values() == 2);  // one on each side
}

TEST_CASE("diff: +infinity is allowed where it says something, and NaN nowhere", "[verify][diff]") {
    const auto found = [](const char* name, auto values, std::size_t row, auto change) {
        using T = typename decltype(values)::value_type;
        change(values[row]);
        StageView view;
        view.outputs = {buffer_view(name, std::span<const T>(values), "")};
        return find_non_finite(view, view.outputs[0]).has_value();
    };
    const std::vector<Ray> rays(3, Ray{Vec3(0.0f), 0.0f, Vec3(1.0f), kInfinity});
    CHECK_FALSE(found("rays", rays, 1, [](Ray&) {}));
    CHECK(found("rays", rays, 1, [](Ray& r) { r.t_max = std::nanf(""); }));
    CHECK(found("rays", rays, 1, [](Ray& r) { r.t_max = -kInfinity; }));
    CHECK(found("rays", rays, 1, [](Ray& r) { r.t_min = kInfinity; }));
    CHECK(found("shadow_rays", rays, 1, [](Ray& r) { r.origin.z = kInfinity; }));
    const std::vector<Hit> hits(3, no_hit());
    CHECK_FALSE(found("merged", hits, 1, [](Hit&) {}));
    CHECK(found("merged", hits, 1, [](Hit& h) { h.primitive = 4; }));
    CHECK(found("merged", hits, 1, [](Hit& h) { h.u = kInfinity; }));
    const std::vector<float> minimum(3, kInfinity);
    CHECK_FALSE(found("minimum", minimum, 1, [](float&) {}));
    CHECK(found("minimum", minimum, 1, [](float& t) { t = -kInfinity; }));
    const std::vector<std::uint64_t> packed(3, ~std::uint64_t{0});
    CHECK_FALSE(found("packed_hits", packed, 1, [](std::uint64_t&) {}));
    CHECK(found("packed_hits", packed, 1,
                [](std::uint64_t& hit) { hit = std::uint64_t{0x7f800000u} << 32 | 5; }));
    const std::vector<Vec3> radiance(3, Vec3(1.0f));
    CHECK(found("radiance", radiance, 1, [](Vec3& v) { v.r = kInfinity; }));
    const std::vector<std::uint32_t> flags(3, 0x7fc00000u);
    CHECK_FALSE(found("flags", flags, 1, [](std::uint32_t&) {}));
}

TEST_CASE("diff: a missing stage is a failure at its place", "[verify][diff]") {
    const TemporaryFolder folder;
    const Capture whole = make_capture(folder / "a", small_parameters(), {}, kSerial);
    const Spoil drop = [](StageCopies& stages) {
        std::erase_if(stages.all(), [](const StageCopy& copy) { return copy.view.name == kLevel; });
    };
    const Capture short_one = make_capture(folder / "b", small_parameters(), drop, kSerial);
    for (const bool in_b : {true, false}) {
        const DiffReport report =
            in_b ? diff_captures(whole, short_one) : diff_captures(short_one, whole);
        CHECK_FALSE(report.passed());
        REQUIRE(report.first() != nullptr);
        CHECK(report.first()->stage == kLevel);
        CHECK_THAT(report.first()->sentence,
                   ContainsSubstring(in_b ? "missing in B" : "missing in A"));
        CHECK(stage(report, kLevel).missing);
        CHECK(report.stages.size() == whole.stages().size());
    }
}

TEST_CASE("diff: a missing buffer is a failure", "[verify][diff]") {
    const Spoiled run(
        [](StageCopies& stages) { stages.at("bounce0/scene_rays").view.outputs.pop_back(); });
    CHECK(run.first().stage == "bounce0/scene_rays");
    CHECK(run.first().buffer == "depth");
    CHECK_THAT(run.first().sentence, ContainsSubstring("missing in B"));
}

TEST_CASE("diff: stages that only one side was asked for are counted, not failed",
          "[verify][diff]") {
    const TemporaryFolder folder;
    const Capture a = make_capture(folder / "a", small_parameters(), {}, kSerial);
    const Capture b =
        make_capture(folder / "b", small_parameters(), {}, kSerial, {"*/merge_intersections"});
    const DiffReport report = diff_captures(a, b);
    CHECK(report.passed());
    CHECK(report.stages.size() == b.stages().size());
    CHECK(report.not_compared == a.stages().size() - b.stages().size());
    DiffOptions options;
    options.patterns = {"primary_rays"};
    const DiffReport chosen = diff_captures(a, a, std::move(options));
    CHECK(chosen.stages.size() == 1);
}

TEST_CASE("diff: hit buffers of different capacity compare by what is in them", "[verify][diff]") {
    const TemporaryFolder folder;
    PipelineParameters p = small_parameters();
    const Capture a = make_capture(folder / "a", p, {}, kSerial);
    p.hit_capacity = 57;
    const Capture b = make_capture(folder / "b", p, {}, kSerial);
    const DiffReport report = diff_captures(a, b);
    INFO(to_text(report));
    CHECK(report.passed());
}

TEST_CASE("diff: captures of different things are not compared", "[verify][diff][errors]") {
    const TemporaryFolder folder;
    PipelineParameters p = small_parameters();
    const Capture a = make_capture(folder / "a", p, {}, kSerial, {"primary_rays"});
    p.seed = 5;
    const Capture b = make_capture(folder / "b", p, {}, kSerial, {"primary_rays"});
    CHECK_THAT(error_of([&] { diff_captures(a, b); }),
               ContainsSubstring("cannot be compared: the parameter seed is 5 there and 0 in"));
    spill(folder / "a" / "index.json",
          replaced(slurp(folder / "a" / "index.json"), a.header().scene_name + "\",",
                   a.header().scene_name + "\", \"other\": 1,"));
    std::string index = slurp(folder / "a" / "index.json");
    index =
        replaced(index, "\"fingerprint\": \"", "\"fingerprint\": \"0000000000000000\", \"x\": \"");
    spill(folder / "a" / "index.json", index);
    CHECK_THAT(error_of([&] { diff_captures(Capture::open(folder / "a"), a); }),
               ContainsSubstring("the scene's fingerprint"));
}

PipelineParameters immediate() {
    PipelineParameters p = small_parameters();
    p.early_out = EarlyOut::immediate;
    return p;
}

TEST_CASE("diff: early-out immediate passes by the set bounds, hits and radiance bit for bit",
          "[verify][diff][immediate]") {
    PipelineParameters p = immediate();
    p.hit_mode = GENERATE(HitMode::buffer, HitMode::packed);
    const Spoiled run({}, p, {.schedule = emulation::ScheduleKind::reversed});
    INFO(to_text(run.report));
    CHECK(run.report.passed());
    CHECK(verdict(run.report, "bounce0/merge_intersections", "merged") == Verdict::identical);
    CHECK(verdict(run.report, "bounce0/scene_rays", "radiance") == Verdict::identical);
    std::size_t bounded = 0;
    for (const StageResult& result : run.report.stages) {
        bounded += result.verdict == Verdict::within_bounds ? 1 : 0;
        CHECK(result.verdict != Verdict::not_comparable);
    }
    CHECK(bounded > 0);
}

TEST_CASE("diff: early-out immediate: a lost ray that was needed is out of bounds",
          "[verify][diff][immediate]") {
    const Spoiled run(
        [&](StageCopies& stages) {
            StageCopy& copy = stages.at("bounce0/level0/intersect_root");
            const auto counts = copy.output<std::uint32_t>("child_counts");
            const auto queue = copy.output<std::uint32_t>("child_queue");
            const auto offsets = copy.input<std::uint32_t>("child_offsets");
            // Nothing is known yet at the root: every ray that enters a child is needed there.
            for (std::size_t child = 0; child < counts.size(); ++child) {
                if (counts[child] == 0) continue;
                queue[offsets[child]] = queue[offsets[child] + counts[child] - 1];
                --counts[child];
                return;
            }
        },
        immediate());
    CHECK(run.first().stage == "bounce0/level0/intersect_root");
    CHECK_THAT(run.first().sentence, ContainsSubstring("B is out of bounds"));
    CHECK(run.first().ray != kNotApplicable);
}

TEST_CASE("diff: early-out immediate: of a part of a run, what depends on timing is not comparable",
          "[verify][diff][immediate]") {
    const TemporaryFolder folder;
    const Capture a = make_capture(folder / "a", immediate(), {}, kSerial, {"bounce0/*"});
    const Capture b = make_capture(folder / "b", immediate(), {},
                                   {.schedule = emulation::ScheduleKind::reversed}, {"bounce0/*"});
    const DiffReport report = diff_captures(a, b);
    INFO(to_text(report));
    CHECK(report.passed());
    std::size_t not_comparable = 0;
    for (const StageResult& result : report.stages) {
        not_comparable += result.verdict == Verdict::not_comparable ? 1 : 0;
    }
    CHECK(not_comparable > 0);
}

TEST_CASE("diff: early-out immediate: a wrong shadow answer differs, another blocker does not",
          "[verify][diff][immediate]") {
    const char* const merge = "bounce0/light0/merge_intersections";
    const auto hit_of = [&](StageCopies& stages) -> Hit& {
        for (Hit& hit : stages.at(merge).output<Hit>("merged")) {
            if (is_hit(hit)) return hit;
        }
        FAIL("no shadow");
        return stages.at(merge).output<Hit>("merged")[0];
    };
    const TemporaryFolder folder;
    const auto partial = [&](const char* name, const Spoil& spoil) {
        return make_capture(folder / name, immediate(), spoil, kSerial, {merge});
    };
    const Capture a = partial("a", {});
    const Capture other = partial("b", [&](StageCopies& s) { one_ulp(hit_of(s).t); });
    CHECK(diff_captures(a, other).passed());
    const Capture wrong = partial("c", [&](StageCopies& s) { hit_of(s) = no_hit(); });
    const DiffReport report = diff_captures(a, wrong);
    REQUIRE_FALSE(report.passed());
    CHECK(report.first()->stage == merge);
    CHECK(report.first()->b == "nothing is hit");
}

TEST_CASE("diff: without a pipeline input, nodes go by their position in the level",
          "[verify][diff]") {
    const TemporaryFolder folder;
    const Capture a = make_capture(folder / "a", small_parameters(), {}, kSerial);
    const Capture b = make_capture(
        folder / "b", small_parameters(),
        [](StageCopies& stages) {
            ++stages.at("bounce0/level1/scan_counts").output<std::uint32_t>("child_offsets")[2];
        },
        kSerial);
    std::filesystem::remove_all(folder / "a" / "input");
    CHECK(diff_captures(a, b).first()->node == 2);
}

TEST_CASE("diff: captures without their buffers are compared by hash", "[verify][diff]") {
    const TemporaryFolder folder;
    const Capture a = make_capture(folder / "a", small_parameters(), {}, kSerial);
    const auto hashes_of = [&](const char* name, const Spoil& spoil) {
        make_capture(folder / name, small_parameters(), spoil,
                     {.schedule = emulation::ScheduleKind::reversed});
        std::filesystem::remove_all(folder / name / "buffers");
        return Capture::open(folder / name);
    };
    const DiffReport same = diff_captures(a, hashes_of("b", {}));
    INFO(to_text(same));
    CHECK(same.passed());
    CHECK(stage(same, kLevel).verdict == Verdict::reordered);
    const DiffReport other =
        diff_captures(a, hashes_of("c", [](StageCopies& stages) {
                          one_ulp(stages.at("bounce0/scene_rays").output<Vec3>("throughput")[3].y);
                      }));
    REQUIRE_FALSE(other.passed());
    CHECK(other.first()->stage == "bounce0/scene_rays");
    CHECK(other.first()->buffer == "throughput");
    CHECK_THAT(other.first()->sentence, ContainsSubstring("without its buffers"));
}

TEST_CASE("diff: the report as JSON has the place of the first divergence", "[verify][diff]") {
    const Spoiled run([](StageCopies& stages) {
        one_ulp(stages.at("bounce1/merge_intersections").output<Hit>("merged")[0].u);
    });
    const auto json = nlohmann::json::parse(to_json(run.report).dump());
    CHECK(json["passed"] == false);
    CHECK(json["first_divergence"]["stage"] == "bounce1/merge_intersections");
    CHECK(json["first_divergence"]["field"] == "u");
    CHECK(json["first_divergence"]["ulps"] == 1);
    CHECK(json["first_divergence"]["ray"] == 0);
    CHECK(json["kinds"]["merge_intersections"]["differs"] == 1);
    CHECK(json["stages"].size() == run.report.stages.size());
    CHECK_THAT(to_text(run.report), ContainsSubstring("first divergence: launch") &&
                                        ContainsSubstring("1 ulps apart") &&
                                        ContainsSubstring("merge_intersections"));
}

TEST_CASE("diff: ulps count floats between, across zero too, and NaN has none", "[verify][diff]") {
    const auto ulps = [](float a, float b) {
        return ulps_between(std::bit_cast<std::uint32_t>(a), std::bit_cast<std::uint32_t>(b));
    };
    CHECK(ulps(1.0f, 1.0f) == 0);
    CHECK(ulps(1.0f, std::nextafter(1.0f, 2.0f)) == 1);
    CHECK(ulps(-1.0f, std::nextafter(-1.0f, -2.0f)) == 1);
    CHECK(ulps(0.0f, -0.0f) == 1);
    CHECK(ulps(std::nextafter(0.0f, -1.0f), std::nextafter(0.0f, 1.0f)) == 3);
    CHECK_FALSE(ulps(1.0f, std::nanf("")).has_value());
}

}  // namespace
