#include "verify/analysis/analysis_catalog.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "reference/base/error.h"

namespace scotty::verify {
namespace {

// The sources of the values given here.
constexpr const char* kReport = "paper, GTX 1080 Ti";
constexpr const char* kReportCode = "paper's code, H100";
constexpr const char* kFigure =
    "the 2018 paper's figure: CBcoil, 256x256, 4 samples, a GTX 1080 Ti";
constexpr const char* kProfile =
    "the 2018 paper's kernel table: 65,536 rays, 256 a block, a tree of 8 levels, scene not named, "
    "a GTX 1080 Ti";
constexpr const char* kCode256 =
    "the 2018 paper's published code on an H100: CBcoil, 256x256, 4 samples, leaves of 32";
constexpr const char* kCode1024 =
    "the 2018 paper's published code on an H100: CBcoil, 1024x1024, width 4, leaves of 32";

AnalysisPoint at(double x, double y) { return {x, "", y, y, y}; }
AnalysisPoint of(const char* label, double y) { return {0.0, label, y, y, y}; }

/// Places the values at 0, 1, 2, ...
std::vector<AnalysisPoint> by_level(const std::vector<double>& values) {
    std::vector<AnalysisPoint> points;
    points.reserve(values.size());
    for (const double value : values)
        points.push_back(at(static_cast<double>(points.size()), value));
    return points;
}

const ChartAxis kLevel{"level of the tree, 0 is the root"};

AnalysisDefinition rays() {
    return {
        "rays",
        "Total rays per traversal",
        "Time grows less than in proportion: four times the rays take about three times as long "
        "(a slope of 0.79 where 1 is proportional).",
        "Whole renders of 1 to 16 samples per pixel (64 on a device), all rays of a render in one "
        "traversal. Both axes are logarithmic.",
        {{false,
          {"rays of a traversal: width x height x samples", Scale::log2},
          {"ms a render", Scale::log10},
          Relative::none,
          "ms a render"}},
        {},
        {{0, "in proportion", {}, 1.0}, {0, "paper: slope 0.79", {}, 0.7925}}};
}

AnalysisDefinition width() {
    return {"width",
            "Tree width",
            "8 children a node are fastest (its design section says 4): wider means fewer levels, "
            "but more queues, scans and atomics a node.",
            "Whole renders, which take turns; each series over its own fastest, so that the shapes "
            "can be compared.",
            {{false,
              {"children a node", Scale::log2},
              {"time, 1 is the fastest width"},
              Relative::to_least,
              "ms a render"}},
            {{0, kReport, kFigure, {at(2, 61), at(4, 34), at(8, 28), at(16, 36)}},
             {0, kReportCode, kCode256, {at(2, 11.4), at(4, 7.0), at(8, 6.2), at(16, 6.1)}}},
            {}};
}

AnalysisDefinition rays_per_block() {
    return {"rays-per-block",
            "Rays per block",
            "64 rays per block are fastest, and the code is bound by computation, since a "
            "multiprocessor runs 64 threads at a time.",
            "Whole renders, which take turns; each series over its own fastest.",
            {{false,
              {"rays per block", Scale::log2},
              {"time, 1 is the fastest"},
              Relative::to_least,
              "ms a render"}},
            {{0, kReport, kFigure, {at(32, 31), at(64, 25), at(128, 28), at(256, 29), at(512, 31)}},
             {0,
              kReportCode,
              kCode256,
              {at(32, 6.24), at(64, 6.20), at(128, 6.12), at(256, 6.41), at(512, 6.76)}}},
            {}};
}

AnalysisDefinition bounces() {
    return {"bounces",
            "Primary against secondary bounces",
            "Secondary rays are traced nearly as fast as primary ones, because rays are sorted by "
            "node at every step. Its pie chart gives no numbers; its kernel table has the first "
            "three queries.",
            "Scans, intersections and merge of each query, over its living rays; and its part of "
            "the time of all queries. Direct light n is all light samples of a path's n-th vertex. "
            "Dead rays are in the root's queue too.",
            {{true, {}, {"time a ray, % of a primary ray's"}, Relative::to_first, "ns a ray"},
             {true, {}, {"% of the time of all queries"}, Relative::share, "ms"}},
            {{0, kReport, kProfile, {of("primary", 19.24), of("direct light 1", 18.89)}}},
            {}};
}

AnalysisDefinition levels() {
    return {
        "levels",
        "Time by level",
        "The top three levels take most of the time, since blocks contend for few nodes; below, "
        "there are fewer rays and more nodes, and time falls off quickly.",
        "Intersection kernels of the primary traversal, with the 2018 paper's tree: width 4, "
        "leaves of up to 32. Each series as percent of its own sum.",
        {{false,
          kLevel,
          {"% of the intersection time", Scale::linear, true},
          Relative::share,
          "ms"}},
        {{0, kReport, kProfile,
          by_level(
              {0.313441, 0.208256, 0.132608, 0.050688, 0.054145, 0.103392, 0.079585, 0.02336})},
         {0, kReportCode, kCode1024, by_level({1.97, 3.27, 2.82, 2.57, 0.58, 0.32, 0.14})}},
        {}};
}

AnalysisDefinition stages() {
    return {"stages",
            "Time by stage",
            "Traversal takes most of the time, and merging about half as much as traversal (its "
            "kernel table has a quarter).",
            "Kernels of a whole render, each stage's part of their sum.",
            {{true, {}, {"% of the time of all kernels"}, Relative::share, "ms"}},
            {{0,
              kReport,
              kProfile,
              {of("traversal", 2.861768), of("scans", 0.202113), of("merge", 0.673059),
               of("direct-light rays", 0.333248), of("primary rays", 0.194849)}},
             {0,
              kReportCode,
              "the 2018 paper's published code on an H100: CBcoil, 1024x1024, 4 samples, width 8",
              {of("traversal", 62), of("scans", 1), of("merge", 11), of("direct-light rays", 11),
               of("primary rays", 4), of("scene rays", 4), of("clearing", 6)},
              "%"}},
            {}};
}

AnalysisDefinition early_out() {
    return {"early-out",
            "Early-out",
            "Rays stop being pushed on behind the nearest hit so far. It saves work, in a way that "
            "depends on which block comes first; how much is not said.",
            "Whole renders without, by the minimum as of the level before, and by the minimum at "
            "this moment (the 2018 paper's). Queue entries are exact counts of one more render.",
            {{true, {}, {"time, % of off"}, Relative::to_first, "ms a render"},
             {true, {}, {"queue entries, % of off"}, Relative::to_first, "queue entries"}},
            {},
            {}};
}

AnalysisDefinition strided() {
    return {"strided",
            "Strided against linear blocks",
            "Neighbouring blocks on different nodes reduce the intersection time by nearly 25 %, "
            "most of it at levels 1 and 2; level 0 is unaffected.",
            "Intersection kernels of all traversals by level. Renders of both take turns; a ratio "
            "is of two that came after each other.",
            {{false, kLevel, {"ms", Scale::log10}, Relative::none, "ms"},
             {false, kLevel, {"strided over linear", Scale::linear}, Relative::none, "ratio"}},
            {},
            {{1, "no change", 1.0, {}}, {1, "paper, all levels: 0.75", 0.75, {}}}};
}

AnalysisDefinition limited_blocks() {
    return {
        "limited-blocks",
        "Limited blocks",
        "A block for every part of every queue that could hold all rays would be several million "
        "blocks, where a couple of hundred have work.",
        "Blocks of the primary traversal, counted exactly from its queues: as the scan of "
        "ceil(count / rays per block) gives them, and nodes x ceil(all rays / rays per block). The "
        "second is not implemented, so no time is given for it.",
        {{false, kLevel, {"blocks", Scale::log10}, Relative::none, "blocks"}},
        {{0, kReport, kProfile, by_level({256, 306, 323, 110, 210, 675, 756, 224})}},
        {}};
}

AnalysisDefinition memory() {
    return {"memory",
            "Memory against rays",
            "Memory grows in proportion to rays: 6 GB for a million at width 4, or for half a "
            "million at width 8. More memory means more rays in flight, and more speed.",
            "Bytes in device buffers (rays, queues, hits, path state) over the rays in flight, "
            "after a render.",
            {{false,
              {"rays in flight", Scale::log2},
              {"bytes a ray", Scale::log10},
              Relative::none,
              "bytes a ray"}},
            {},
            {{0, "paper's code, width 8: 10 kB", 10000.0, {}},
             {0, "paper's code, width 4: 5.9 kB", 5900.0, {}}}};
}

}  // namespace

const std::vector<AnalysisDefinition>& analysis_catalog() {
    static const std::vector<AnalysisDefinition> catalog{
        rays(),   width(),     rays_per_block(), bounces(),        levels(),
        stages(), early_out(), strided(),        limited_blocks(), memory()};
    return catalog;
}

const AnalysisDefinition& analysis_named(const std::string& where, const std::string& name) {
    std::vector<std::string> names;
    for (const AnalysisDefinition& definition : analysis_catalog()) {
        if (definition.name == name) return definition;
        names.push_back(definition.name);
    }
    throw reference::Error::bad_input(
        where, fmt::format("'{}' is no analysis; there are {}", name, fmt::join(names, ", ")));
}

}  // namespace scotty::verify
