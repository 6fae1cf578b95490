#include "verify/analysis/analysis_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scotty::verify {
namespace {

std::string series_name(const AnalysisRun& run, const AnalysisSeries& series, bool alone) {
    if (series.name.empty()) return run.label;
    return alone ? series.name : run.label + ", " + series.name;
}

/// The divisor of the values.
double unit_of(const std::vector<AnalysisPoint>& points, Relative relative) {
    if (points.empty()) return 1.0;
    double sum = 0.0;
    double least = points.front().y;
    for (const AnalysisPoint& p : points) {
        sum += p.y;
        least = std::min(least, p.y);
    }
    switch (relative) {
        case Relative::none:
            return 1.0;
        case Relative::to_least:
            return least;
        case Relative::to_first:
            return points.front().y / 100.0;
        case Relative::share:
            return sum / 100.0;
    }
    return 1.0;
}

std::vector<ChartSeries> chart_series(const std::vector<FigureSeries>& all, Relative relative) {
    std::vector<ChartSeries> out;
    out.reserve(all.size());
    for (const FigureSeries& one : all) {
        out.push_back({one.name, one.color, one.style, drawn(*one.points, relative)});
    }
    return out;
}

/// Guides go from the least x to the greatest; there are none without two x.
std::vector<ChartSeries> guides(const AnalysisDefinition& definition, std::size_t panel,
                                const std::vector<ChartSeries>& series) {
    std::vector<ChartPoint> all;
    for (const ChartSeries& one : series) {
        all.insert(all.end(), one.points.begin(), one.points.end());
    }
    if (all.empty()) return {};
    const ChartPoint origin = all.front();
    const auto [first, last] = std::minmax_element(
        all.begin(), all.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
    std::vector<ChartSeries> out;
    for (const GuideDefinition& guide : definition.guides) {
        if (guide.panel != panel || first->x == last->x) continue;
        ChartSeries line{guide.name, kGivenColor, LineStyle::guide, {}};
        for (const double x : {first->x, last->x}) {
            const double y = guide.level
                                 ? *guide.level
                                 : origin.y * std::pow(x / origin.x, guide.slope.value_or(0.0));
            line.points.push_back({x, y, y, y, ""});
        }
        out.push_back(std::move(line));
    }
    return out;
}

std::string value_text(const AnalysisPoint& point) {
    std::string text = short_number(point.y);
    if (point.low != point.high) {
        text += fmt::format(" ({} to {})", short_number(point.low), short_number(point.high));
    }
    return text;
}

std::string place_of(const AnalysisPoint& point) {
    return point.label.empty() ? fmt::format("{:.0f}", point.x) : point.label;
}

/// All places of all series: numbers in order, categories in that of their first appearance.
std::vector<std::string> places(const std::vector<FigureSeries>& all) {
    std::vector<std::pair<double, std::string>> found;
    for (const FigureSeries& one : all) {
        for (const AnalysisPoint& point : *one.points) {
            const std::string place = place_of(point);
            const bool seen = std::any_of(found.begin(), found.end(),
                                          [&](const auto& f) { return f.second == place; });
            if (!seen) found.emplace_back(point.label.empty() ? point.x : 0.0, place);
        }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> out;
    out.reserve(found.size());
    for (const auto& each : found) out.push_back(each.second);
    return out;
}

const AnalysisPoint* point_at(const FigureSeries& series, const std::string& place) {
    for (const AnalysisPoint& point : *series.points) {
        if (place_of(point) == place) return &point;
    }
    return nullptr;
}

}  // namespace

std::vector<FigureSeries> series_of(const AnalysisDefinition& definition, std::size_t panel,
                                    const std::vector<AnalysisRun>& runs) {
    std::vector<FigureSeries> out;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const AnalysisResult* result = runs[i].find(definition.name);
        if (result == nullptr) continue;
        LineStyle style = LineStyle::line;
        for (const AnalysisSeries& one : result->series) {
            if (one.panel != panel) continue;
            out.push_back({series_name(runs[i], one, runs.size() == 1), static_cast<int>(i), style,
                           &one.points, definition.panels[panel].column});
            style = LineStyle::dashed;
        }
    }
    LineStyle style = LineStyle::line;
    for (const GivenSeries& one : definition.given) {
        if (one.panel != panel) continue;
        out.push_back({one.name, kGivenColor, style, &one.points,
                       one.column.empty() ? definition.panels[panel].column : one.column});
        style = LineStyle::dashed;
    }
    return out;
}

std::vector<ChartPoint> drawn(const std::vector<AnalysisPoint>& points, Relative relative) {
    const double unit = unit_of(points, relative);
    std::vector<ChartPoint> out;
    out.reserve(points.size());
    for (const AnalysisPoint& p : points) {
        out.push_back({p.x, p.y / unit, p.low / unit, p.high / unit, p.label});
    }
    return out;
}

std::string figure(const AnalysisDefinition& definition, const std::vector<AnalysisRun>& runs) {
    std::vector<ChartPanel> panels;
    for (std::size_t i = 0; i < definition.panels.size(); ++i) {
        const PanelDefinition& panel = definition.panels[i];
        std::vector<ChartSeries> series =
            chart_series(series_of(definition, i, runs), panel.relative);
        if (panel.bars) {
            panels.push_back(draw(BarChart{panel.y.label, std::move(series)}));
            continue;
        }
        for (ChartSeries& guide : guides(definition, i, series)) series.push_back(std::move(guide));
        panels.push_back(draw(LineChart{panel.x, panel.y, std::move(series)}));
    }
    return svg_document(definition.title, panels);
}

std::vector<std::vector<std::string>> numbers(const AnalysisDefinition& definition,
                                              std::size_t panel,
                                              const std::vector<AnalysisRun>& runs) {
    const PanelDefinition& what = definition.panels[panel];
    const std::vector<FigureSeries> all = series_of(definition, panel, runs);
    std::vector<std::vector<std::string>> rows{{what.bars ? "" : what.x.label}};
    for (const FigureSeries& one : all) {
        rows[0].push_back(one.name + ": " + one.column);
        if (one.points->empty()) continue;
        for (const auto& more : one.points->front().more) rows[0].push_back(more.first);
    }
    for (const std::string& place : places(all)) {
        std::vector<std::string> row{place};
        for (const FigureSeries& one : all) {
            const std::size_t columns = one.points->empty() ? 0 : one.points->front().more.size();
            const AnalysisPoint* point = point_at(one, place);
            row.push_back(point == nullptr ? "" : value_text(*point));
            for (std::size_t i = 0; i < columns; ++i) {
                const bool there = point != nullptr && i < point->more.size();
                row.push_back(there ? short_number(point->more[i].second) : "");
            }
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace scotty::verify
