#include "verify/queues/queues_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

namespace scotty::verify {

using nlohmann::ordered_json;

namespace {

constexpr int kProcess = 1;
constexpr int kLaunches = 1;  ///< track; histories come behind it

ordered_json name_of(const char* what, int track, const std::string& name) {
    return {
        {"name", what}, {"ph", "M"}, {"pid", kProcess}, {"tid", track}, {"args", {{"name", name}}}};
}

struct Slice {
    std::uint64_t begin = 0, length = 1;
};

/// A slice for each visit, tied together by a flow.
void add_history(ordered_json& events, const Queues& queues, const RayHistory& history,
                 const std::map<std::uint32_t, Slice>& launches, int track) {
    events.push_back(name_of("thread_name", track,
                             fmt::format("ray {} of batch {}", history.ray, history.batch)));
    struct Stop {
        std::uint64_t time;
        ordered_json slice;
    };
    std::vector<Stop> stops;
    const auto add_traversal = [&](const TraversalHistory& traversal) {
        for (const Visit& visit : traversal.visits) {
            const LevelQueues level = queues.queues_of(queues.launch(visit.launch));
            std::uint64_t time = launches.at(visit.launch).begin + visit.position;
            for (std::uint32_t n = 0; n < visit.node - level.first_node; ++n) {
                time += level.regions.regions[n].count;
            }
            stops.push_back({time,
                             {{"name", fmt::format("node {}", visit.node)},
                              {"cat", "ray"},
                              {"ph", "X"},
                              {"pid", kProcess},
                              {"tid", track},
                              {"ts", time},
                              {"dur", 1},
                              {"args",
                               {{"launch", visit.launch},
                                {"stage", visit.stage},
                                {"position", visit.position},
                                {"block", visit.block},
                                {"thread", visit.thread}}}}});
        }
    };
    for (const BounceHistory& bounce : history.bounces) {
        add_traversal(bounce.traversal);
        for (const LightHistory& light : bounce.lights) add_traversal(light.traversal);
    }
    std::stable_sort(stops.begin(), stops.end(),
                     [](const Stop& a, const Stop& b) { return a.time < b.time; });
    for (std::size_t i = 0; i < stops.size(); ++i) {
        events.push_back(stops[i].slice);
        if (stops.size() < 2) break;
        ordered_json flow{{"name", "ray"},   {"cat", "ray"}, {"ph", "t"},          {"id", track},
                          {"pid", kProcess}, {"tid", track}, {"ts", stops[i].time}};
        if (i == 0) flow["ph"] = "s";
        if (i + 1 == stops.size()) {
            flow["ph"] = "f";
            flow["bp"] = "e";
        }
        events.push_back(std::move(flow));
    }
}

}  // namespace

ordered_json to_trace(const Queues& queues, const std::vector<RayHistory>& histories) {
    ordered_json events = ordered_json::array();
    events.push_back(name_of("process_name", 0,
                             fmt::format("{}, {}", queues.capture().header().scene_name,
                                         queues.capture().header().backend)));
    events.push_back(name_of("thread_name", kLaunches, "launches"));
    std::map<std::uint32_t, Slice> launches;
    std::uint64_t now = 0;
    for (const LaunchRow& row : queues.launches()) {
        Slice slice{
            now, std::max<std::uint64_t>(1, row.totals ? row.totals->entries : row.stage->blocks)};
        launches[row.stage->launch] = slice;
        ordered_json arguments{{"launch", row.stage->launch}, {"blocks", row.stage->blocks}};
        if (row.totals) {
            arguments["entries"] = row.totals->entries;
            arguments["nodes_with_work"] = row.totals->with_work;
            arguments["longest_node"] = row.totals->longest_node;
            events.push_back({{"name", "queue entries"},
                              {"ph", "C"},
                              {"pid", kProcess},
                              {"ts", now},
                              {"args", {{"entries", row.totals->entries}}}});
            events.push_back({{"name", "longest queue"},
                              {"ph", "C"},
                              {"pid", kProcess},
                              {"ts", now},
                              {"args", {{"entries", row.totals->longest}}}});
        }
        events.push_back({{"name", row.stage->name},
                          {"cat", to_string(row.stage->kind)},
                          {"ph", "X"},
                          {"pid", kProcess},
                          {"tid", kLaunches},
                          {"ts", slice.begin},
                          {"dur", slice.length},
                          {"args", std::move(arguments)}});
        now += slice.length;
    }
    int track = kLaunches;
    for (const RayHistory& history : histories) {
        add_history(events, queues, history, launches, ++track);
    }
    return {{"displayTimeUnit", "ns"},
            {"otherData", {{"time", "logical: one unit a queue entry, or a block"}}},
            {"traceEvents", std::move(events)}};
}

}  // namespace scotty::verify
