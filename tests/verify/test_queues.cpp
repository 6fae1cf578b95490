// scotty queues: the model held to straight loops over a small capture, its views, and its errors.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/verify/command_tools.h"
#include "verify/queues_diff.h"
#include "verify/queues_history.h"
#include "verify/queues_view.h"

using namespace scotty::verify;
using namespace scotty::verify::test;
using scotty::reference::Hit;
using scotty::reference::kNone;

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
