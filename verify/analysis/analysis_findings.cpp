#include "verify/analysis/analysis_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "reference/base/error.h"
#include "verify/pages/chart.h"

namespace scotty::verify {

using Points = std::vector<AnalysisPoint>;

namespace {

double sum_of(const Points& points) {
    return std::accumulate(points.begin(), points.end(), 0.0,
                           [](double sum, const AnalysisPoint& p) { return sum + p.y; });
}

const AnalysisPoint* labelled(const Points& points, const std::string& label) {
    for (const AnalysisPoint& p : points) {
        if (p.label == label) return &p;
    }
    return nullptr;
}

double labelled_y(const Points& points, const std::string& label) {
    const AnalysisPoint* point = labelled(points, label);
    return point == nullptr ? 0.0 : point->y;
}

const AnalysisPoint& most(const Points& points) {
    return *std::max_element(points.begin(), points.end(),
                             [](const auto& a, const auto& b) { return a.y < b.y; });
}

std::string on_rays(const AnalysisResult& result) {
    const Points& points = result.named(0, "").points;
    const auto slope = loglog_slope(points);
    if (!slope) return "one size only, which has no slope";
    return fmt::format(
        "a slope of {:.2f} from {} to {} rays, so that four times the rays take {:.1f} times as "
        "long; {}",
        *slope, short_number(points.front().x), short_number(points.back().x),
        std::pow(4.0, *slope),
        *slope < 0.9 ? "less than in proportion, as in the paper (3 times)"
                     : "about in proportion, where the paper has 3 times");
}

/// The fastest of a sweep, and the others that its repeats do not tell from it.
std::string fastest(const Points& points, double reports, const std::string& what) {
    const AnalysisPoint& best = *std::min_element(
        points.begin(), points.end(), [](const auto& a, const auto& b) { return a.y < b.y; });
    std::string text =
        fmt::format("fastest at {:.0f} {} ({} ms)", best.x, what, short_number(best.y));
    std::string equal;
    bool report_equals = best.x == reports;
    double slowest = 1.0;
    for (const AnalysisPoint& p : points) {
        slowest = std::max(slowest, p.y / best.y);
        if (p.x == best.x || p.low > best.high) continue;
        equal += fmt::format("{}{:.0f}", equal.empty() ? "" : ", ", p.x);
        report_equals = report_equals || p.x == reports;
    }
    if (!equal.empty()) text += fmt::format(", which the repeats do not tell from {}", equal);
    return text + fmt::format(
                      "; the slowest takes {:.2f} times as long; the 2018 paper's fastest, "
                      "{:.0f}, is {}",
                      slowest, reports, report_equals ? "as good" : "slower here");
}

std::string on_bounces(const AnalysisResult& result) {
    const Points& points = result.named(0, "").points;
    const double primary = labelled_y(points, "primary");
    double scene = 0.0;
    double scene_rays = 0.0;
    double direct = 0.0;
    double direct_rays = 0.0;
    double entries = 0.0;  // of scattered rays
    for (const AnalysisPoint& p : points) {
        const double rays = p.column("rays");
        if (p.label.starts_with("scene rays")) {
            scene += p.y * rays;
            scene_rays += rays;
            entries += p.column("entries per ray") * rays;
        } else if (p.label.starts_with("direct light")) {
            direct += p.y * rays;
            direct_rays += rays;
        }
    }
    if (primary <= 0.0 || scene_rays <= 0.0 || direct_rays <= 0.0) {
        return "there are not all kinds of rays to compare";
    }
    const double ratio = scene / scene_rays / primary;
    return fmt::format(
        "a primary ray takes {} ns, a scattered one {:.1f} times that (and {:.1f} times the queue "
        "entries), a direct-light one {:.1f} times; {}",
        short_number(primary), ratio,
        entries / scene_rays / labelled(points, "primary")->column("entries per ray"),
        direct / direct_rays / primary,
        ratio < 1.25 ? "nearly as fast, as in the paper"
                     : "the paper has scattered rays nearly as fast as primary ones");
}

std::string on_levels(const AnalysisResult& result) {
    const Points& points = result.named(0, "").points;
    const double all = sum_of(points);
    if (points.size() < 4 || all <= 0.0) return "the tree has no more than three levels";
    const double top = points[0].y + points[1].y + points[2].y;
    const AnalysisPoint& slowest = most(points);
    return fmt::format(
        "level {:.0f} takes most of the intersection time ({:.0f} %), levels 0 to 2 together "
        "{:.0f} %, the last {:.0f} % (the 2018 paper's profile: level 0, 68 %, 2 %){}",
        slowest.x, 100.0 * slowest.y / all, 100.0 * top / all, 100.0 * points.back().y / all,
        top > 0.5 * all ? "" : "; so the top levels are not where the time goes");
}

std::string on_stages(const AnalysisResult& result) {
    const Points& points = result.named(0, "").points;
    const double all = sum_of(points);
    const double traversal = labelled_y(points, "traversal");
    const double merge = labelled_y(points, "merge");
    if (all <= 0.0 || traversal <= 0.0) return "no time was noted";
    return fmt::format(
        "traversal takes {:.0f} %, and merging {:.2f} times as much as traversal, where the paper "
        "says half",
        100.0 * traversal / all, merge / traversal);
}

std::string on_early_out(const AnalysisResult& result) {
    const Points& time = result.named(0, "").points;
    const Points& entries = result.named(1, "").points;
    const auto percent = [](const Points& points, const char* label) {
        return 100.0 * labelled_y(points, label) / labelled_y(points, "off");
    };
    return fmt::format(
        "of the queue entries without early-out, {:.0f} % are left by level and {:.0f} % by "
        "immediate, in {:.0f} % and {:.0f} % of the time",
        percent(entries, "level"), percent(entries, "immediate"), percent(time, "level"),
        percent(time, "immediate"));
}

std::string on_strided(const AnalysisResult& result) {
    const double linear = sum_of(result.named(0, "linear").points);
    const double strided = sum_of(result.named(0, "strided").points);
    if (linear <= 0.0) return "no time was noted";
    const double ratio = strided / linear;
    return fmt::format(
        "strided blocks take {:.2f} times the intersection time of linear ones; {}", ratio,
        ratio < 0.9     ? "they help, as in the paper (0.75)"
        : ratio <= 1.05 ? "they change next to nothing, where the paper gains a quarter"
                        : "they cost time, where the paper gains a quarter");
}

std::string on_limited_blocks(const AnalysisResult& result) {
    const double limited = sum_of(result.named(0, "limited").points);
    const Points& every = result.named(0, "a block for every slot").points;
    const double unlimited = sum_of(every);
    if (limited <= 0.0) return "there were no blocks";
    return fmt::format(
        "{} blocks have rays, where a block for every slot would be {}, {} times as many, most of "
        "them at level {:.0f}",
        short_number(limited), short_number(unlimited), short_number(unlimited / limited),
        most(every).x);
}

std::string on_memory(const AnalysisResult& result) {
    const double narrow = result.named(0, "width 4").points.back().y;
    const double wide = result.named(0, "width 8").points.back().y;
    return fmt::format(
        "{} bytes a ray at width 4 and {} at width 8, {:.0f} and {:.0f} times less than the "
        "paper's code (5.9 and 10 kB)",
        short_number(narrow), short_number(wide), 5900.0 / narrow, 10000.0 / wide);
}

using Finder = std::string (*)(const AnalysisResult&);
const std::map<std::string, Finder>& finders() {
    static const std::map<std::string, Finder> all{
        {"rays", on_rays},
        {"width",
         [](const AnalysisResult& r) {
             return fastest(r.named(0, "").points, 8.0, "children a node");
         }},
        {"rays-per-block",
         [](const AnalysisResult& r) {
             return fastest(r.named(0, "").points, 64.0, "rays per block");
         }},
        {"bounces", on_bounces},
        {"levels", on_levels},
        {"stages", on_stages},
        {"early-out", on_early_out},
        {"strided", on_strided},
        {"limited-blocks", on_limited_blocks},
        {"memory", on_memory}};
    return all;
}

}  // namespace

std::optional<double> loglog_slope(const Points& points) {
    double n = 0.0;
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    for (const AnalysisPoint& p : points) {
        if (!(p.x > 0.0 && p.y > 0.0 && std::isfinite(p.x) && std::isfinite(p.y))) {
            throw reference::Error::bad_input(
                "slope", fmt::format("expected positive numbers, found {} at {}", p.y, p.x));
        }
        const double u = std::log(p.x);
        const double v = std::log(p.y);
        n += 1.0;
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
    }
    const double spread = n * xx - x * x;
    if (n < 2.0 || spread <= 1e-12 * n * xx) return {};
    return (n * xy - x * y) / spread;
}

std::string finding(const AnalysisRun& run, const AnalysisResult& result) {
    const auto found = finders().find(result.name);
    if (found == finders().end()) {
        throw reference::Error::internal("nothing is said about " + result.name);
    }
    for (const AnalysisSeries& one : result.series) {
        if (one.points.empty()) return run.label + ": a series is empty.";
    }
    if (result.series.empty()) return run.label + ": nothing was measured.";
    return run.label + ": " + found->second(result) + ".";
}

}  // namespace scotty::verify
