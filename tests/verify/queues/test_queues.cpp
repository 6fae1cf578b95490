// scotty queues: the model held to straight loops over a small capture, its views, and its errors.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "tests/verify/command_tools.h"
#include "verify/queues/queues_diff.h"
#include "verify/queues/queues_history.h"
#include "verify/queues/queues_json.h"
#include "verify/queues/queues_page.h"
#include "verify/queues/queues_view.h"

using namespace scotty::verify;
using namespace scotty::verify::test;
using scotty::reference::EarlyOut;
using scotty::reference::Hit;
using scotty::reference::HitMode;
using scotty::reference::kNone;
using scotty::reference::PipelineParameters;
using scotty::reference::QueueKind;
using scotty::reference::ShadowQuery;
using scotty::reference::StageKind;

namespace {

constexpr const char* kStage = "bounce0/level1/intersect";

/// One capture for all tests that only read.
struct Shared {
    TemporaryFolder folder;
    std::string path = folder.file("small");
    Capture capture = make_capture(path, small_parameters());
    Queues queues{capture};
};
const Shared& shared() {
    static const Shared made;
    return made;
}

std::vector<RayHistory> all_histories() {
    const auto& p = small_parameters();
    std::vector<std::uint32_t> rays(p.image_width * p.image_height * p.spp);
    for (std::uint32_t i = 0; i < rays.size(); ++i) rays[i] = i;
    return histories(shared().queues, 0, rays);
}

std::size_t lines(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("queues: totals, nodes and entries are those of the buffers", "[queues]") {
    const Queues& queues = shared().queues;
    const StageRecord& stage = *shared().capture.find(kStage);
    const LoadedStage loaded = shared().capture.load(stage);
    const auto counts = loaded.view.get<std::uint32_t>("node_counts");
    const auto offsets = loaded.view.get<std::uint32_t>("queue_offsets");
    const auto queue = loaded.view.get<std::uint32_t>("queue");
    const auto minimum = loaded.view.get<float>("minimum");
    const std::uint32_t first = queues.bvh().level_begins[1];

    std::uint64_t entries = 0;
    for (const std::uint32_t count : counts) entries += count;
    const auto launches = queues.launches();
    const auto row = std::find_if(launches.begin(), launches.end(),
                                  [&](const LaunchRow& r) { return r.stage == &stage; });
    REQUIRE(row != launches.end());
    CHECK(row->totals->entries == entries);
    CHECK(row->totals->longest == *std::max_element(counts.begin(), counts.end()));

    const auto nodes = queues.nodes(stage);
    REQUIRE(nodes.size() == counts.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        CHECK(nodes[i].node == first + i);
        CHECK(nodes[i].count == counts[i]);
        CHECK(nodes[i].blocks == (counts[i] + 31) / 32);
        for (const std::uint32_t child : nodes[i].children) {
            CHECK(queues.bvh().parents[child] == nodes[i].node);
        }
        const auto in_queue = queues.entries(stage, nodes[i].node);
        REQUIRE(in_queue.size() == counts[i]);
        for (std::uint32_t p = 0; p < counts[i]; ++p) {
            const std::uint32_t ray = queue[offsets[i] + p];
            CHECK(in_queue[p].ray == ray);
            CHECK(in_queue[p].thread == p % 32);
            CHECK(in_queue[p].minimum == minimum[ray]);
        }
    }
}

TEST_CASE("queues: histories are whole: every entry is a visit, every push is met below",
          "[queues]") {
    const auto all = all_histories();
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> visits;  // launch, node
    bool hit = false;
    bool miss = false;
    bool culled = false;
    bool hidden = false;
    for (const RayHistory& history : all) {
        for (const BounceHistory& bounce : history.bounces) {
            const TraversalHistory& traversal = bounce.traversal;
            REQUIRE(traversal.merged);
            (is_hit(*traversal.merged) ? hit : miss) = true;
            CHECK((traversal.winner_node != kNone) == is_hit(*traversal.merged));
            CHECK(traversal.stray.empty());
            for (const LightHistory& light : bounce.lights) {
                hidden = hidden || (is_alive(light.shadow_ray) && is_hit(*light.traversal.merged));
            }
            for (const Visit& visit : traversal.visits) {
                ++visits[{visit.launch, visit.node}];
                if (visit.leaf) {
                    CHECK(visit.leaf_outcome != LeafOutcome::lost);
                    CHECK(visit.leaf_outcome != LeafOutcome::other);
                }
                for (const ChildVisit& child : visit.children) {
                    CHECK(child.outcome != Outcome::lost);
                    CHECK(child.outcome != Outcome::extra);
                    const bool below = std::any_of(
                        traversal.visits.begin(), traversal.visits.end(), [&](const Visit& v) {
                            return v.node == child.node && v.position == child.position;
                        });
                    CHECK(below == (child.outcome == Outcome::pushed));
                    if (child.outcome != Outcome::culled) continue;
                    culled = true;
                    CHECK(*child.entry > *visit.minimum);
                }
            }
        }
    }
    CHECK((hit && miss && culled && hidden));
    const StageRecord& stage = *shared().capture.find(kStage);
    for (const NodeRow& node : shared().queues.nodes(stage)) {
        CHECK(visits[{stage.launch, node.node}] == node.count);
    }
}

TEST_CASE("queues: a history tells what hit, missed, was culled, and hid a light", "[queues]") {
    std::string all;
    for (const RayHistory& history : all_histories()) all += to_text(history);
    CHECK(all.find(": won") != std::string::npos);
    CHECK(all.find("merged: nothing is hit") != std::string::npos);
    CHECK(all.find("beyond the minimum 0x1.") != std::string::npos);
    CHECK(all.find("the light is hidden") != std::string::npos);
    CHECK(all.find("the light is free") != std::string::npos);
    CHECK(all.find("the path ended") != std::string::npos);
    CHECK(all.find("not captured") == std::string::npos);
}

TEST_CASE("queues: --diff finds the moved, the missing, the extra and the changed entry",
          "[queues]") {
    const TemporaryFolder folder;
    std::uint32_t node = 0;
    std::vector<std::uint32_t> was;
    const Capture b = make_capture(folder.file("b"), small_parameters(), [&](StageCopies& stages) {
        StageCopy& stage = stages.at(kStage);
        const auto counts = stage.input<std::uint32_t>("node_counts");
        const auto offsets = stage.input<std::uint32_t>("queue_offsets");
        const auto queue = stage.input<std::uint32_t>("queue");
        while (counts[node] < 8) ++node;
        was.assign(queue.begin() + offsets[node], queue.begin() + offsets[node] + counts[node]);
        std::swap(queue[offsets[node]], queue[offsets[node] + 1]);  // two moved
        std::uint32_t stranger = 0;
        while (std::find(was.begin(), was.end(), stranger) != was.end()) ++stranger;
        queue[offsets[node] + 2] = stranger;  // one missing, one extra
        stage.input<float>("minimum")[was[3]] = 0.125f;
    });
    const Queues other(b);
    const StageRecord& a_stage = *shared().capture.find(kStage);
    const StageRecord& b_stage = *b.find(kStage);
    node += shared().queues.bvh().level_begins[1];
    const auto pairs = align(shared().queues.entries(a_stage, node), other.entries(b_stage, node));
    REQUIRE(pairs.size() == was.size() + 1);
    CHECK(pairs[0].change == Change::moved);
    CHECK(pairs[1].change == Change::moved);
    CHECK(pairs[2].change == Change::missing);
    CHECK(pairs[3].change == Change::changed);
    CHECK(pairs[3].what == "minimum");
    CHECK(pairs[4].change == Change::same);
    CHECK(pairs.back().change == Change::extra);

    const auto nodes = compare_nodes(shared().queues, a_stage, other, b_stage);
    const auto& found = nodes[node - shared().queues.bvh().level_begins[1]];
    CHECK((found.moved == 2 && found.missing == 1 && found.extra == 1 && found.changed == 1));

    const std::string command = "queues '" + shared().path + "' --diff '" + folder.file("b") + "'";
    CHECK(scotty_here(command).out.find("differs") != std::string::npos);
    const Result ray = scotty_here(command + " --csv --ray " + std::to_string(was[2]));
    CHECK(ray.exit_code == 0);
    CHECK(ray.out.find(",1," + std::to_string(node) + ",missing,") != std::string::npos);
    // The level above pushed it; the one that lost it is named by its own side's history.
    const auto lost = histories(other, 0, {was[2]});
    const auto& visits = lost[0].bounces[0].traversal.visits;
    CHECK(std::none_of(visits.begin(), visits.end(),
                       [&](const Visit& visit) { return visit.node == node; }));
}

TEST_CASE("queues: a ray that is not pushed is lost, one pushed for nothing is extra", "[queues]") {
    const TemporaryFolder folder;
    std::uint32_t ray = 0;
    std::uint32_t stranger = 0;
    const Capture b = make_capture(folder.file("b"), small_parameters(), [&](StageCopies& stages) {
        StageCopy& stage = stages.at("bounce0/level0/intersect_root");
        const auto counts = stage.output<std::uint32_t>("child_counts");
        const auto offsets = stage.input<std::uint32_t>("child_offsets");
        const auto queue = stage.output<std::uint32_t>("child_queue");
        std::uint32_t child = 0;
        while (counts[child] < 2 || counts[child] == 13 * 11 * 2) ++child;
        const auto begin = queue.begin() + offsets[child];
        const std::vector<std::uint32_t> inside(begin, begin + counts[child]);
        while (std::find(inside.begin(), inside.end(), stranger) != inside.end()) ++stranger;
        ray = *begin;
        *begin = stranger;
    });
    const auto told = histories(Queues(b), 0, {ray, stranger});
    CHECK(to_text(told[0]).find("lost   node") != std::string::npos);
    CHECK(to_text(told[1]).find("extra  node") != std::string::npos);
}

TEST_CASE("queues: each view as text, CSV and JSON", "[queues]") {
    const std::string command = "queues '" + shared().path + "'";
    const StageRecord& stage = *shared().capture.find(kStage);
    const auto nodes = shared().queues.nodes(stage);
    const Result overview = scotty_here(command + " --csv");
    CHECK(overview.exit_code == 0);
    std::size_t levels = 0;
    for (const StageRecord& s : shared().capture.stages()) levels += is_level_kernel(s.kind);
    CHECK(lines(overview.out) == levels + 1);

    const std::string launch = command + " --launch " + std::to_string(stage.launch);
    CHECK(lines(scotty_here(launch + " --csv").out) == nodes.size() + 1);
    const std::string node = std::to_string(nodes[0].node);
    const auto json =
        nlohmann::json::parse(scotty_here(launch + " --node " + node + " --json").out);
    CHECK(json["rows"].size() == nodes[0].count);
    const auto entry = shared().queues.entries(stage, nodes[0].node).at(0);
    CHECK(json["rows"][0]["ray"] == entry.ray);
    CHECK(json["rows"][0]["direction.x"].get<float>() == entry.record->direction.x);

    const Result pixel = scotty_here(command + " --pixel 3,4");
    CHECK(pixel.out.find("pixel (3, 4), sample 0") != std::string::npos);
    CHECK(pixel.out.find("pixel (3, 4), sample 1") != std::string::npos);
    const Result root = scotty_here(command + " --stage bounce0/level0/intersect_root --node 0");
    CHECK(root.out.find("186 more rows; --all") != std::string::npos);
    CHECK(lines(scotty_here(command + " --node 0").out) == 6);  // two bounces, each with a light
}

TEST_CASE("queues: what does not exist is said with what there is", "[queues]") {
    const std::string command = "queues '" + shared().path + "'";
    const auto error = [&](const std::string& more) {
        const Result result = scotty_here(command + more);
        CHECK(result.exit_code == kExitUsage);
        return result.err;
    };
    CHECK(error(" --launch 9999").find("of the launches 0 to") != std::string::npos);
    CHECK(error(" --node 99999").find("the tree has nodes 0 to") != std::string::npos);
    CHECK(error(" --level 99").find("levels 0 to") != std::string::npos);
    CHECK(error(" --ray 286").find("it has 286 rays") != std::string::npos);
    CHECK(error(" --ray 1 --batch 3").find("no batch 3") != std::string::npos);
    CHECK(error(" --pixel 13,0").find("the image has 13x11") != std::string::npos);
    CHECK(error(" --pixel 13").find("expected X,Y") != std::string::npos);
    CHECK(error(" --launch 2 --node 3").find("level 1") != std::string::npos);
    CHECK(error(" --stage nothing").find("--stage '*' lists") != std::string::npos);

    const TemporaryFolder folder;
    std::filesystem::copy(shared().path, folder.file("c"),
                          std::filesystem::copy_options::recursive);
    const StageRecord& stage = *shared().capture.find(kStage);
    const std::string file = folder.file("c") + "/" + stage.input("queue")->file;
    std::filesystem::resize_file(file, 40);
    CHECK(scotty_here("queues '" + folder.file("c") + "' --ray 1").err.find(".npy") !=
          std::string::npos);
    std::filesystem::remove_all(folder.file("c") + "/buffers");
    CHECK(scotty_here("queues '" + folder.file("c") + "'").err.find("only the index is left") !=
          std::string::npos);
}

TEST_CASE("queues: the trace has a slice a launch, counters, and a ray's flow", "[queues]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("trace.json");
    REQUIRE(
        scotty_here("queues '" + shared().path + "' --ray 40 --trace '" + file + "'").exit_code ==
        0);
    CHECK_FALSE(std::filesystem::exists(file + ".unfinished"));
    const auto trace = nlohmann::json::parse(slurp(file));
    std::map<std::string, std::size_t> phases;
    std::size_t slices = 0;
    std::uint64_t end = 0;
    for (const auto& event : trace["traceEvents"]) {
        ++phases[event["ph"]];
        if (event["ph"] != "X" || event["tid"] != 1) continue;
        CHECK(event["ts"] == end);  // launches lie end to end, in logical time
        end += event["dur"].get<std::uint64_t>();
        ++slices;
    }
    CHECK(slices == shared().capture.stages().size());
    CHECK(phases["s"] == 1);
    CHECK(phases["f"] == 1);
    std::size_t visits = 0;
    const auto history = histories(shared().queues, 0, {40});
    for (const BounceHistory& bounce : history[0].bounces) {
        visits += bounce.traversal.visits.size();
        for (const LightHistory& light : bounce.lights) visits += light.traversal.visits.size();
    }
    CHECK(phases["X"] == slices + visits);
    CHECK(phases["t"] == visits - 2);
}

TEST_CASE("queues: --json of a ray is a document: bounces, traversals, visits, children and hits",
          "[queues]") {
    const std::string command = "queues '" + shared().path + "' --json --ray 40";
    const auto told = nlohmann::json::parse(scotty_here(command).out);
    const RayHistory history = histories(shared().queues, 0, {40})[0];
    CHECK(told["rays"].size() == 1);
    const auto& ray = told["rays"][0];
    CHECK((ray["ray"] == 40 && ray["pixel"].size() == 2));
    REQUIRE(ray["bounces"].size() == history.bounces.size());
    const auto& visits = ray["bounces"][0]["traversal"]["visits"];
    REQUIRE(visits.size() == history.bounces[0].traversal.visits.size());
    for (std::size_t i = 0; i < visits.size(); ++i) {
        const Visit& visit = history.bounces[0].traversal.visits[i];
        CHECK(visits[i]["node"] == visit.node);
        CHECK(visits[i].contains("leaf") == visit.leaf);
        if (visit.leaf) {
            CHECK(visits[i]["leaf"]["hits"].size() == visit.hits.size());
            continue;
        }
        REQUIRE(visits[i]["children"].size() == visit.children.size());
        CHECK(visits[i]["children"][0]["outcome"] == to_string(visit.children[0].outcome));
    }
    const auto origin = ray["bounces"][0]["traversal"]["ray"]["origin"];
    CHECK(origin[2].get<float>() == history.bounces[0].traversal.ray->origin.z);
}

TEST_CASE("queues: --diff --ray says which child and which hit is not the same", "[queues]") {
    const TemporaryFolder folder;
    std::uint32_t ray = kNone;
    std::uint32_t child = kNone;
    std::string hit;
    make_capture(folder.file("b"), small_parameters(), [&](StageCopies& stages) {
        StageCopy& root = stages.at("bounce0/level0/intersect_root");
        const auto counts = root.output<std::uint32_t>("child_counts");
        const auto offsets = root.input<std::uint32_t>("child_offsets");
        const auto queue = root.output<std::uint32_t>("child_queue");
        const auto merged = stages.at("bounce0/merge_intersections").output<Hit>("merged");
        for (child = 0; ray == kNone; ++child) {  // one that hits something
            for (std::uint32_t p = 0; p + 1 < counts[child] && ray == kNone; ++p) {
                const std::uint32_t id = queue[offsets[child] + p];
                if (!is_hit(merged[id])) continue;
                ray = id;
                queue[offsets[child] + p] = queue[offsets[child] + p + 1];
            }
        }
        const std::uint32_t primitive = merged[ray].primitive;
        hit = "hit " + std::to_string(primitive);
        for (StageCopy& stage : stages.all()) {  // its hit is nearer from the leaf on
            if (stage.view.bounce != 0 || stage.view.light != scotty::reference::kNotApplicable ||
                stage.view.find("hits") == nullptr) {
                continue;
            }
            const auto all = stage.view.kind == scotty::reference::StageKind::merge_intersections
                                 ? stage.input<scotty::reference::HitCandidate>("hits")
                                 : stage.output<scotty::reference::HitCandidate>("hits");
            const std::size_t room = all.size() / (13 * 11 * 2);
            for (std::size_t slot = 0; slot < room; ++slot) {
                if (all[ray * room + slot].primitive == primitive) all[ray * room + slot].t *= 0.5f;
            }
        }
    });
    const std::string command = "queues '" + shared().path + "' --diff '" + folder.file("b") +
                                "' --ray " + std::to_string(ray);
    const std::string csv = scotty_here(command + " --csv").out;
    CHECK(csv.find(",changed,child " + std::to_string(child) + ",,,") != std::string::npos);
    CHECK(csv.find(",lost") != std::string::npos);
    CHECK(csv.find(",missing," + hit + ",") != std::string::npos);
    CHECK(csv.find(",extra," + hit + ",") != std::string::npos);
    const auto told = nlohmann::json::parse(scotty_here(command + " --json").out)["rays"][0];
    CHECK(told["a"]["ray"] == told["b"]["ray"]);
    const auto& first = told["differences"][0];
    CHECK((first["node"] == 0 && first["change"] == "changed"));
    CHECK(first["what"][0]["what"] == "child " + std::to_string(child));
    CHECK(first["what"][0]["b"] == "lost");
}

namespace {

/// What visits did, over all traversals of a capture.
struct Seen {
    std::set<LeafOutcome> leaves, subtrees;
    std::set<Outcome> children;
    bool minimum = false, won = false;
};

/// A traversal in which nothing went wrong.
void expect_sound(const TraversalHistory& traversal, Seen& seen) {
    CHECK(traversal.stray.empty());
    CHECK(traversal.gaps.empty());
    if (!traversal.merged) return;
    CHECK((traversal.winner_node != kNone) == is_hit(*traversal.merged));
    for (const Visit& visit : traversal.visits) {
        (visit.subtree ? seen.subtrees : seen.leaves).insert(visit.leaf_outcome);
        seen.minimum = seen.minimum || visit.minimum.has_value();
        for (const GatheredHit& hit : visit.hits) seen.won = seen.won || hit.won;
        CHECK(visit.leaf_outcome != LeafOutcome::lost);
        CHECK(visit.leaf_outcome != LeafOutcome::other);
        CHECK((visit.leaf || !visit.children.empty()));
        for (const ChildVisit& child : visit.children) {
            seen.children.insert(child.outcome);
            CHECK(child.outcome != Outcome::lost);
            CHECK(child.outcome != Outcome::extra);
            CHECK((child.outcome == Outcome::tested) == child.tested.has_value());
            if (!child.tested) continue;
            seen.leaves.insert(child.tested->leaf_outcome);
            for (const GatheredHit& hit : child.tested->hits) seen.won = seen.won || hit.won;
            CHECK(child.tested->leaf_outcome != LeafOutcome::lost);
            CHECK(child.tested->leaf_outcome != LeafOutcome::other);
        }
    }
}

/// Every entry of every queue is one visit, and every traversal is sound.
Seen expect_whole(const Queues& queues) {
    Seen seen;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> visits;  // launch, node
    const auto take = [&](const TraversalHistory& traversal) {
        expect_sound(traversal, seen);
        for (const Visit& visit : traversal.visits) ++visits[{visit.launch, visit.node}];
    };
    for (std::uint32_t batch = 0; batch < queues.batches(); ++batch) {
        std::vector<std::uint32_t> rays(queues.ray_count(batch));
        std::iota(rays.begin(), rays.end(), 0u);
        for (const RayHistory& history : histories(queues, batch, rays)) {
            CHECK(history.from);
            for (const BounceHistory& bounce : history.bounces) {
                take(bounce.traversal);
                for (const LightHistory& light : bounce.lights) take(light.traversal);
            }
        }
    }
    for (const StageRecord& stage : queues.capture().stages()) {
        if (!is_level_kernel(stage.kind)) continue;
        for (const NodeRow& node : queues.nodes(stage)) {
            INFO(stage.name << ", node " << node.node);
            CHECK(visits[{stage.launch, node.node}] == node.count);
        }
    }
    return seen;
}

/// A mode of the pipeline that changes what the debugger has to read.
struct Mode {
    QueueKind queues;
    std::uint32_t queue_levels;
    HitMode hit_mode;
    EarlyOut early_out;
    bool parts;  ///< several batches and passes, and any-hit shadow rays
};

std::string name_of(const Mode& mode) {
    return fmt::format("{}-{}-levels-{}-{}-{}", to_string(mode.queues), mode.queue_levels,
                       mode.hit_mode == HitMode::packed ? "packed" : "buffer",
                       mode.early_out == EarlyOut::off     ? "off"
                       : mode.early_out == EarlyOut::level ? "level"
                                                           : "immediate",
                       mode.parts ? "parts" : "whole");
}

std::vector<Mode> all_modes() {
    std::vector<Mode> out;
    for (const std::uint32_t queue_levels : {0u, 1u, 3u}) {
        for (const HitMode hit_mode : {HitMode::buffer, HitMode::packed}) {
            for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
                for (const bool parts : {false, true}) {
                    out.push_back({QueueKind::nodes, queue_levels, hit_mode, early_out, parts});
                    if (queue_levels == 1) continue;  // there is no level below the root
                    out.push_back({QueueKind::pairs, queue_levels, hit_mode, early_out, parts});
                }
            }
        }
    }
    return out;
}

PipelineParameters parameters_of(const Mode& mode) {
    auto p = small_parameters();
    p.queues = mode.queues;
    p.queue_levels = mode.queue_levels;
    p.hit_mode = mode.hit_mode;
    p.early_out = mode.early_out;
    if (!mode.parts) return p;
    p.batch_rays = 100;
    p.samples_per_pass = 1;
    p.shadow_query = ShadowQuery::any;
    return p;
}

/// The command's views of one capture, each held to the model.
void expect_views(const Queues& queues, const std::string& path) {
    const std::string command = "queues '" + path + "'";
    const std::uint32_t batch = queues.batches() - 1;
    const auto rays = std::min<std::size_t>(queues.ray_count(batch), 40);
    for (std::uint32_t ray = 0; ray < rays; ray += 13) {
        const std::string one =
            command + fmt::format(" --ray {} --batch {}", ray, queues.batches() - 1);
        const std::string text = scotty_here(one).out;
        CHECK(text.find("from no leaf") == std::string::npos);
        CHECK(text.find("which no leaf of the ray buffered") == std::string::npos);
        const auto told = nlohmann::json::parse(scotty_here(one + " --json").out)["rays"][0];
        CHECK(told == to_json(histories(queues, batch, {ray})[0]));
    }
    for (const StageRecord& stage : queues.capture().stages()) {
        if (!is_level_kernel(stage.kind) || stage.batch != 0 || stage.bounce != 0) continue;
        const std::string launch = command + fmt::format(" --launch {}", stage.launch);
        CHECK(lines(scotty_here(launch + " --csv").out) == queues.nodes(stage).size() + 1);
        for (const NodeRow& node : queues.nodes(stage)) {
            if (node.count == 0) continue;
            const auto of_node = scotty_here(launch + fmt::format(" --node {} --csv", node.node));
            CHECK(lines(of_node.out) == node.count + 1);
            break;
        }
    }
    const TemporaryFolder folder;
    const std::string trace = folder.file("trace.json");
    CHECK(scotty_here(command + " --ray 7 --trace '" + trace + "'").exit_code == kExitPassed);
    CHECK(nlohmann::json::parse(slurp(trace))["traceEvents"].size() >
          queues.capture().stages().size());
    const nlohmann::json page = queues_page_data(queues, nullptr, {});
    CHECK(page["a"]["checked"] == true);
    for (const auto& launch : page["launches"]) CHECK(launch["invariants"]["a"].empty());
}

/// A second run with one hit made nearer: the diff names the ray, and its history the hit.
void expect_diff(const Mode& mode, const std::string& path, const TemporaryFolder& folder) {
    std::uint32_t ray = kNone;
    const std::string other = folder.file("other");
    make_capture(other, parameters_of(mode), [&](StageCopies& stages) {
        for (StageCopy& stage : stages.all()) {
            if (stage.view.kind != StageKind::merge_intersections || ray != kNone) continue;
            const auto merged = stage.output<Hit>("merged");
            for (ray = 0; !is_hit(merged[ray]);) ++ray;
            merged[ray].t *= 0.5f;
        }
    });
    const std::string command = "queues '" + path + "' --diff '" + other + "'";
    const auto told =
        nlohmann::json::parse(scotty_here(command + fmt::format(" --ray {} --json", ray)).out);
    const auto merged = [&](const char* side) {
        return told["rays"][0][side]["bounces"][0]["traversal"]["merged"]["t"].get<float>();
    };
    CHECK(merged("b") == 0.5f * merged("a"));
}

}  // namespace

TEST_CASE("queues: in every mode a sound run is told as sound, in every view", "[queues]") {
    const Mode mode = GENERATE(from_range(all_modes()));
    INFO(name_of(mode));
    const TemporaryFolder folder;
    const std::string path = folder.file("run");
    const Capture capture = make_capture(path, parameters_of(mode));
    const Queues queues(capture);
    const Seen seen = expect_whole(queues);
    CHECK(seen.won);
    CHECK(seen.children.count(Outcome::pushed) == (mode.queue_levels == 1 ? 0 : 1));
    CHECK(seen.children.count(Outcome::tested) == (mode.queues == QueueKind::pairs ? 1 : 0));
    CHECK(seen.subtrees.empty() == (mode.queue_levels == 0));
    CHECK(seen.minimum == (mode.early_out != EarlyOut::off));
    const auto& ends = mode.queue_levels == 0 ? seen.leaves : seen.subtrees;
    CHECK(ends.count(LeafOutcome::buffered) == 1);
    if (mode.hit_mode == HitMode::packed && mode.early_out == EarlyOut::off &&
        mode.queue_levels != 1) {
        CHECK(ends.count(LeafOutcome::passed) == 1);
    }
    if (mode.early_out == EarlyOut::immediate) {
        CHECK(to_text(histories(queues, 0, {7})[0]).find("each launch left behind") !=
              std::string::npos);
    }
    if (mode.parts) CHECK(queues.batches() > 1);
    expect_views(queues, path);
    // Under `immediate` which rays are pushed depends on the order of blocks.
    if (mode.early_out != EarlyOut::immediate && !mode.parts) expect_diff(mode, path, folder);
}

TEST_CASE("queues: a node inside of a subtree has no queue, and its root is named", "[queues]") {
    const TemporaryFolder folder;
    auto parameters = small_parameters();
    parameters.queue_levels = 2;
    const std::string path = folder.file("run");
    const Capture capture = make_capture(path, parameters);
    const Queues queues(capture);
    const std::uint32_t inside = queues.bvh().level_begins.back();
    REQUIRE(inside < queues.bvh().node_count());
    const Result result = scotty_here(fmt::format("queues '{}' --node {}", path, inside));
    CHECK(result.exit_code == kExitUsage);
    CHECK(result.err.find(fmt::format("inside the subtree of node {}",
                                      queues.bvh().parents[inside])) != std::string::npos);
}

TEST_CASE("queues: several batches: ids count within each, a pixel's rays are found in theirs",
          "[queues]") {
    const TemporaryFolder folder;
    auto parameters = small_parameters();
    parameters.batch_rays = 100;
    const Capture capture = make_capture(folder / "batches", parameters);
    const Queues queues(capture);
    REQUIRE(queues.batches() == 3);
    CHECK(queues.ray_count(0) == 100);
    CHECK(queues.ray_count(2) == 86);
    expect_whole(queues);
    std::size_t found = 0;
    for (std::uint32_t y = 0; y < 11; ++y) {
        for (std::uint32_t x = 0; x < 13; ++x) {
            for (const auto& [batch, ray] : queues.rays_of(x, y)) {
                const auto from = queues.origin(batch, ray);
                CHECK((from->pixel_x == x && from->pixel_y == y));
                ++found;
            }
        }
    }
    CHECK(found == 286);
    const std::string path = folder.file("batches");
    CHECK(scotty_here("queues '" + path + "' --ray 99 --batch 2").err.find("has 86 rays") !=
          std::string::npos);
    CHECK(scotty_here("queues '" + path + "' --ray 5 --batch 2").out.find("ray 5 of batch 2") !=
          std::string::npos);
}
