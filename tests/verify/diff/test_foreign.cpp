/// Runs of another program: a small tracer with ids, an order of nodes and float tests of its own
/// writes captures, sound ones and spoiled ones.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/capture/include/scotty/capture_writer.h"
#include "verify/diff/diff.h"
#include "verify/diff/foreign.h"
#include "verify/diff/judge_box.h"
#include "verify/diff/replay.h"
#include "verify/invariants/expected.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using reference::Vec3;
namespace writer = scotty::capture;

writer::Point point(const Vec3& v) { return {v.x, v.y, v.z}; }

/// No padding, as most programs have it.
float enter_box(const writer::Ray& ray, const Vec3& low, const Vec3& high) {
    float near = ray.t_min;
    float far = ray.t_max;
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        const float a = (low[axis] - ray.origin[i]) / ray.direction[i];
        const float b = (high[axis] - ray.origin[i]) / ray.direction[i];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    return near <= far ? near : writer::kInfinity;
}

/// Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
float hit_triangle(const writer::Ray& ray, const reference::LeafTriangle& triangle) {
    const Vec3 from(ray.origin[0], ray.origin[1], ray.origin[2]);
    const Vec3 along(ray.direction[0], ray.direction[1], ray.direction[2]);
    const Vec3 ab = triangle.v1 - triangle.v0;
    const Vec3 ac = triangle.v2 - triangle.v0;
    const Vec3 p = reference::cross(along, ac);
    const float scale = 1.0f / reference::dot(ab, p);
    const Vec3 s = from - triangle.v0;
    const Vec3 q = reference::cross(s, ab);
    const float u = reference::dot(s, p) * scale;
    const float v = reference::dot(along, q) * scale;
    const float t = reference::dot(ac, q) * scale;
    return u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t >= ray.t_min && t < ray.t_max
               ? t
               : writer::kInfinity;
}

/// A traversal of the scene "spheres" by the other program, before it is written.
struct Run {
    PipelineInput input;
    writer::Settings settings;
    std::vector<writer::NodeId> ids;  ///< depth first, with gaps, by our id
    std::vector<writer::Ray> rays;
    std::map<std::uint32_t, std::vector<writer::RayId>> queues;  ///< by our node id
    std::map<std::uint32_t, std::size_t> counts;                 ///< where a counter says otherwise
    std::map<writer::RayId, std::vector<writer::Hit>> hits;
    std::map<writer::RayId, std::size_t> hit_counts;
    std::map<writer::RayId, writer::Hit> closest;

    explicit Run(bool culls) : input(spheres_input(small_parameters())) {
        settings.culls = culls;
        ids.resize(input.bvh.node_count());
        number(0);
        const reference::Camera& camera = input.scene.camera;
        for (int i = 0; i < 300; ++i) {
            const float x = static_cast<float>(i % 20) / 10.0f - 0.97f;
            const float y = static_cast<float>(i / 20) / 7.5f - 0.95f;
            const Vec3 along = camera.forward + camera.right * (x * 0.4f) + camera.up * (y * 0.4f);
            rays.push_back(
                {static_cast<writer::RayId>(9000 - 11 * i), point(camera.position), point(along)});
        }
        for (const writer::Ray& ray : rays) queues[0].push_back(ray.id);
        trace();
    }
    writer::RayId ray_in(std::uint32_t node, std::size_t i) const { return queues.at(node)[i]; }
    const writer::Ray& ray(writer::RayId id) const {
        return rays[static_cast<std::size_t>((9000 - id) / 11)];
    }

    Capture write(const std::filesystem::path& directory) const {
        writer::Writer out(directory, "the other program", settings);
        for (const auto& corners : input.scene.triangles) {
            const auto& v = input.scene.vertices;
            out.triangle(point(v[corners[0]]), point(v[corners[1]]), point(v[corners[2]]));
        }
        for (std::uint32_t node = input.bvh.node_count(); node-- > 0;) {
            if (reference::is_leaf(input.bvh.node_refs[node])) {
                std::vector<std::uint32_t> primitives;
                for (const auto& t : triangles_of(node)) primitives.push_back(t.primitive);
                out.leaf(ids[node], primitives);
                continue;
            }
            std::vector<writer::Child> children;
            each_child(node, [&](std::uint32_t child, const Vec3& low, const Vec3& high) {
                children.push_back({ids[child], point(low), point(high)});
            });
            out.inner(ids[node], children);
        }
        writer::Query& query = out.query();
        query.rays(rays.data(), rays.size(), [](const writer::Ray& ray) { return ray; });
        const auto same = [](const auto& value) { return value; };
        for (const auto& [node, queue] : queues) {
            const auto count = counts.find(node);
            query.queue(ids[node], queue.data(),
                        count == counts.end() ? queue.size() : count->second, same, queue.size());
        }
        for (const auto& [ray, gathered] : hits) {
            const auto count = hit_counts.find(ray);
            query.hits(ray, gathered.data(),
                       count == hit_counts.end() ? gathered.size() : count->second, same,
                       gathered.size());
        }
        for (const auto& [ray, hit] : closest) query.closest(hit);
        out.finish();
        return Capture::open(directory);
    }
    DiffReport judge() const {
        const TemporaryFolder folder;
        const Capture capture = write(folder / "mine.capture");
        DiffReport report = diff_foreign(capture, backend_named("emulator", 2), {});
        UNSCOPED_INFO(to_text(report));
        return report;
    }

    std::span<const reference::LeafTriangle> triangles_of(std::uint32_t node) const {
        const auto& leaf = input.bvh.leaves[reference::ref_index(input.bvh.node_refs[node])];
        return {input.bvh.triangles.data() + leaf.first, leaf.count};
    }
    template <class F>
    void each_child(std::uint32_t node, const F& f) const {
        const NodeBoxes boxes =
            boxes_of(input.bvh, reference::ref_index(input.bvh.node_refs[node]));
        for (std::uint32_t c = 0; c < boxes.width; ++c) {
            if (boxes.child[c] != reference::kNone) f(boxes.child[c], boxes.low[c], boxes.high[c]);
        }
    }

 private:
    writer::NodeId next_ = 40;
    void number(std::uint32_t node) {
        ids[node] = next_;
        next_ += 3;
        if (reference::is_leaf(input.bvh.node_refs[node])) return;
        each_child(node, [&](std::uint32_t child, const Vec3&, const Vec3&) { number(child); });
    }
    void trace() {
        std::map<writer::RayId, float> minimum;
        for (const writer::Ray& ray : rays) {
            minimum[ray.id] = writer::kInfinity;
            hits[ray.id];
        }
        for (std::uint32_t node = 0; node < input.bvh.node_count(); ++node) {
            const std::vector<writer::RayId> queue = queues[node];
            if (reference::is_leaf(input.bvh.node_refs[node])) {
                for (const writer::RayId id : queue) {
                    writer::Hit nearest;
                    for (const auto& triangle : triangles_of(node)) {
                        const float t = hit_triangle(ray(id), triangle);
                        if (t < nearest.t) nearest = {t, triangle.primitive, id};
                    }
                    if (nearest.primitive == writer::kNothing) continue;
                    if (settings.culls && nearest.t > minimum[id]) continue;
                    minimum[id] = std::min(minimum[id], nearest.t);
                    hits[id].push_back(nearest);
                }
                continue;
            }
            each_child(node, [&](std::uint32_t child, const Vec3& low, const Vec3& high) {
                std::vector<writer::RayId>& out = queues[child];
                for (const writer::RayId id : queue) {
                    const float entry = enter_box(ray(id), low, high);
                    const float limit = settings.culls ? minimum[id] : writer::kInfinity;
                    if (entry < writer::kInfinity && entry <= limit) out.push_back(id);
                }
                std::reverse(out.begin(), out.end());
            });
        }
        for (const auto& [id, gathered] : hits) {
            closest[id] = {writer::kInfinity, writer::kNothing, id};
            for (const writer::Hit& hit : gathered) {
                if (hit.t < closest[id].t) closest[id] = hit;
            }
        }
    }
};

/// An inner node of the second level or lower with rays.
std::uint32_t busy_inner_node(const Run& run) {
    for (std::uint32_t node = run.input.bvh.level_begins[2];; ++node) {
        if (!reference::is_leaf(run.input.bvh.node_refs.at(node)) && run.queues.at(node).size() > 4)
            return node;
    }
}
/// A ray that has gathered several hits.
writer::RayId busy_ray(const Run& run) {
    for (const auto& [ray, hits] : run.hits) {
        if (hits.size() > 1 && std::abs(hits[0].t - hits[1].t) > 0.1f * hits[0].t) return ray;
    }
    FAIL("no ray has two hits");
    return 0;
}

const Divergence& first_of(const DiffReport& report) {
    REQUIRE_FALSE(report.passed());
    REQUIRE(report.first() != nullptr);
    return *report.first();
}

TEST_CASE("foreign: another program's sound run passes, with and without culling",
          "[verify][foreign]") {
    for (const bool culls : {false, true}) {
        const DiffReport report = Run(culls).judge();
        CHECK(report.passed());
        CHECK(report.stages.size() > 4);
        CHECK(report.not_given.size() == 6);  // the kinds that are no traversal
        CHECK(report.excused < 200);
    }
}

TEST_CASE("foreign: a lost ray is named by its own id, at its own node", "[verify][foreign]") {
    Run run(false);
    const std::uint32_t node = busy_inner_node(run);
    std::vector<writer::RayId>& queue = run.queues[node];
    const writer::RayId lost = queue[2];
    queue.erase(queue.begin() + 2);
    const DiffReport report = run.judge();
    const Divergence& first = first_of(report);
    CHECK(first.own_node == run.ids[node]);
    CHECK(first.own_ray == lost);
    CHECK(first.node == node);
    CHECK(first.buffer == "child_queue");
    CHECK_THAT(first.sentence, ContainsSubstring("missing from the node's queue"));
    CHECK_THAT(to_text(report),
               ContainsSubstring("FAILED") && ContainsSubstring(std::to_string(lost)));
}

TEST_CASE("foreign: what a queue must not hold is named", "[verify][foreign]") {
    Run run(true);
    const std::uint32_t node = busy_inner_node(run);
    std::vector<writer::RayId>& queue = run.queues[node];
    SECTION("a ray twice") {
        queue.push_back(queue[1]);
        CHECK_THAT(first_of(run.judge()).sentence, ContainsSubstring("twice"));
    }
    SECTION("no ray's id") {
        queue.push_back(77);
        const DiffReport report = run.judge();
        CHECK_THAT(first_of(report).sentence, ContainsSubstring("no ray's id"));
        CHECK(first_of(report).own_ray == 77u);
    }
    SECTION("a ray that its parent has not") {
        const auto& parent = run.queues[run.input.bvh.parents[node]];
        for (const writer::Ray& ray : run.rays) {
            if (std::find(parent.begin(), parent.end(), ray.id) == parent.end()) {
                queue.push_back(ray.id);
                break;
            }
        }
        CHECK_THAT(first_of(run.judge()).sentence, ContainsSubstring("not in its parent's"));
    }
    SECTION("a ray that does not enter its box") {
        for (const writer::RayId ray : run.queues[run.input.bvh.parents[node]]) {
            if (std::find(queue.begin(), queue.end(), ray) == queue.end()) {
                queue.push_back(ray);
                break;
            }
        }
        CHECK_THAT(first_of(run.judge()).sentence,
                   ContainsSubstring("whose box it does not enter"));
    }
    SECTION("more rays than slots") {
        run.counts[node] = queue.size() + 3;
        CHECK_THAT(first_of(run.judge()).sentence, ContainsSubstring("beyond its capacity"));
    }
}

TEST_CASE("foreign: hits and answers are judged", "[verify][foreign]") {
    Run run(false);
    const writer::RayId ray = busy_ray(run);
    std::vector<writer::Hit>& hits = run.hits[ray];
    SECTION("a leaf's hit is lost") {
        hits.erase(hits.begin() + 1);
        CHECK_THAT(first_of(run.judge()).sentence,
                   ContainsSubstring("closest hit of a leaf is missing"));
    }
    SECTION("a hit that is none") {
        hits[0].t *= 0.5f;
        run.closest[ray] = hits[0];
        CHECK_THAT(first_of(run.judge()).sentence, ContainsSubstring("a hit that is none"));
    }
    SECTION("a hit of no primitive") {
        hits.push_back({1e9f, 123456789u, ray});
        CHECK_THAT(first_of(run.judge()).sentence, ContainsSubstring("hit of no primitive"));
    }
    SECTION("more hits than slots") {
        run.hit_counts[ray] = hits.size() + 1;
        CHECK_THAT(first_of(run.judge()).sentence, ContainsSubstring("counter of hits is beyond"));
    }
    SECTION("the answer is another gathered hit") {
        run.closest[ray] = hits[0].t > hits[1].t ? hits[0] : hits[1];
        CHECK_THAT(first_of(run.judge()).sentence,
                   ContainsSubstring("not the nearest of the hits"));
    }
    SECTION("the answer is wrong, and nothing else is known") {
        run.hits.clear();
        run.queues.clear();
        run.closest[ray] = {writer::kInfinity, writer::kNothing, ray};
        const DiffReport report = run.judge();
        CHECK_THAT(first_of(report).sentence, ContainsSubstring("not the closest hit"));
        CHECK(first_of(report).own_ray == ray);
    }
}

TEST_CASE("foreign: what is not given is named, and is no failure", "[verify][foreign]") {
    Run run(true);
    run.hits.clear();
    const std::uint32_t begin = run.input.bvh.level_begins[3];
    run.queues.erase(run.queues.lower_bound(begin), run.queues.end());
    run.queues.erase(run.input.bvh.level_begins[2]);
    const DiffReport report = run.judge();
    CHECK(report.passed());
    const std::string text = to_text(report);
    CHECK_THAT(text,
               ContainsSubstring("not judged") && ContainsSubstring("queues of level 2 (1 of ") &&
                   ContainsSubstring("gathered hits") && ContainsSubstring("direct_light_rays"));
    CHECK(to_json(report)["not_given"].size() == report.not_given.size());
}

TEST_CASE("foreign: a capture with nothing to judge has no stages", "[verify][foreign]") {
    Run run(true);
    run.hits.clear();
    run.queues.clear();
    run.closest.clear();
    CHECK(run.judge().stages.empty());
}

TEST_CASE("foreign: a tree whose box is too small is named", "[verify][foreign]") {
    Run run(false);
    auto& nodes = std::get<std::vector<reference::WideNode<4>>>(run.input.bvh.inner);
    nodes[0].low_y[0] = nodes[0].high_y[0];
    const DiffReport report = run.judge();
    CHECK_FALSE(report.passed());
    CHECK_THAT(to_text(report),
               ContainsSubstring("tree is not sound") && ContainsSubstring("does not contain"));
}

TEST_CASE("foreign: a ray that cannot be traced is named", "[verify][foreign]") {
    Run run(false);
    run.rays[5].direction = {0.0f, std::numeric_limits<float>::quiet_NaN(), 1.0f};
    const DiffReport report = run.judge();
    CHECK_THAT(first_of(report).sentence, ContainsSubstring("cannot be traced"));
    CHECK(first_of(report).own_ray == run.rays[5].id);
}

TEST_CASE("foreign: such a capture is judged and not compared", "[verify][foreign]") {
    const TemporaryFolder folder;
    const Capture capture = Run(false).write(folder / "mine.capture");
    CHECK(capture.header().foreign);
    CHECK(capture.header().backend == "the other program");
    CHECK_THROWS_WITH(diff_captures(capture, capture), ContainsSubstring("judged by: scotty diff"));
    CHECK_THROWS_WITH(
        replay_stage(capture, "bounce0/level1/intersect", backend_named("emulator", 1)),
        ContainsSubstring("judged by: scotty diff"));
    const Capture own = make_capture(folder / "own", small_parameters());
    CHECK_THROWS_AS(diff_foreign(own, backend_named("emulator", 1), {}), reference::Error);
}

TEST_CASE("foreign: the writer refuses what makes no sense", "[verify][foreign]") {
    const TemporaryFolder folder;
    const auto complaint = [&](const std::function<void(writer::Writer&)>& fill) {
        try {
            writer::Writer out(folder / "x", "x");
            out.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
            fill(out);
            out.finish();
        } catch (const writer::Error& error) {
            return std::string(error.what());
        }
        return std::string("nothing");
    };
    const auto tree = [](writer::Writer& out) {
        out.inner(1, {{2, {0, 0, 0}, {1, 1, 0}}});
        out.leaf(2, {0});
    };
    CHECK(complaint(tree) == "nothing");
    CHECK_THAT(complaint([](auto&) {}), ContainsSubstring("no root"));
    CHECK_THAT(complaint([](auto& out) { out.leaf(1, {0}); }), ContainsSubstring("a leaf"));
    CHECK_THAT(complaint([](auto& out) {
                   out.inner(1, {{2, {}, {}}});
               }),
               ContainsSubstring("not given"));
    CHECK_THAT(complaint([&](auto& out) {
                   tree(out);
                   out.leaf(3, {0});
               }),
               ContainsSubstring("nobody's child"));
    CHECK_THAT(complaint([](auto& out) {
                   out.inner(1, {{2, {}, {}}});
                   out.leaf(2, {7});
               }),
               ContainsSubstring("primitive 7 of 1"));
    CHECK_THAT(complaint([](auto& out) {
                   out.leaf(1, {0});
                   out.leaf(1, {0});
               }),
               ContainsSubstring("twice"));
    CHECK_THAT(complaint([&](auto& out) {
                   tree(out);
                   out.query().ray({4, {}, {0, 0, 1}});
                   out.query();
               }),
               ContainsSubstring("has that query already"));
    CHECK_THAT(complaint([&](auto& out) {
                   tree(out);
                   auto& query = out.query();
                   query.ray({4, {}, {0, 0, 1}});
                   query.ray({4, {}, {0, 0, 1}});
               }),
               ContainsSubstring("ray 4: is given twice"));
    CHECK_THAT(complaint([&](auto& out) {
                   tree(out);
                   auto& query = out.query();
                   query.ray({4, {}, {0, 0, 1}});
                   query.closest({1.0f, 0, 5});
               }),
               ContainsSubstring("none of the query's rays"));
    CHECK_THAT(complaint([&](auto& out) {
                   tree(out);
                   auto& query = out.query();
                   query.ray({4, {}, {0, 0, 1}});
                   const int none = 0;
                   query.queue(9, &none, 0, [](int id) { return id; });
               }),
               ContainsSubstring("not in the tree"));
    CHECK_FALSE(std::filesystem::exists(folder / "x" / "buffers" / ".." / ".x.partial"));
}

TEST_CASE("foreign: boxes are judged with room for rounding, flat ones too", "[verify][foreign]") {
    using reference::Verdict;
    const auto judge = [](const Vec3& low, const Vec3& high, const Vec3& from, const Vec3& along) {
        return judge_box(low, high, {from, 0.0f, along, reference::kInfinity}).verdict;
    };
    const Vec3 along(0.1f, 0.2f, 1.0f);
    CHECK(judge({-1, -1, 2}, {1, 1, 3}, {0, 0, 0}, along) == Verdict::hit);
    CHECK(judge({-1, -1, 2}, {1, 1, 2}, {0, 0, 0}, along) == Verdict::hit);  // flat
    CHECK(judge({-1, -1, -3}, {1, 1, -2}, {0, 0, 0}, along) == Verdict::miss);
    CHECK(judge({2, -1, 2}, {3, 1, 3}, {0, 0, 0}, along) == Verdict::miss);
    CHECK(judge({-1, -1, -1}, {1, 1, 1}, {0, 0, 0}, along) == Verdict::hit);  // from within
    CHECK(judge({0.2f, -1, 2}, {1, 1, 2}, {0, 0, 0}, along) == Verdict::grazing);
    CHECK(judge({0, -1, 2}, {1, 1, 3}, {0, 0, 0}, {0, 0, 1}) == Verdict::grazing);  // on a face
    CHECK(judge({0.5f, -1, 2}, {1, 1, 3}, {0, 0, 0}, {0, 0, 1}) == Verdict::miss);
    CHECK(judge({-1, -1, 2}, {1, 1, 3}, {0, 0, 0}, {0, 0, 1}) == Verdict::hit);
}

}  // namespace
