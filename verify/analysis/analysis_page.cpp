#include "verify/analysis/analysis_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "verify/analysis/analysis_figures.h"
#include "verify/analysis/analysis_findings.h"
#include "verify/pages/page.h"

namespace scotty::verify {
namespace {

bool any_has(const std::vector<AnalysisRun>& runs, const AnalysisDefinition& definition) {
    return std::any_of(runs.begin(), runs.end(), [&](const AnalysisRun& run) {
        return run.find(definition.name) != nullptr;
    });
}

std::string picture_of(const reference::PipelineParameters& p) {
    return fmt::format(
        "{}x{} pixels, {} spp, width {}, {} rays per block, leaves of {}, early-out {}",
        p.image_width, p.image_height, p.spp, p.width, p.rays_per_block, p.max_leaf_size,
        to_string(p.early_out));
}

std::string heading_of(const AnalysisRun& run) {
    return fmt::format("{} ({} triangles), --backend {}, median of {}; {}", run.scene,
                       run.triangles, run.backend, run.repeats, run.machine);
}

std::string header_part(const std::vector<AnalysisRun>& runs) {
    std::string out =
        "<p class=\"quiet\">scotty analyze</p>\n<h1>The 2018 paper's analyses, again</h1>\n"
        "<p>Coloured: measured here. Grey: what the 2018 paper gives, or its published code. Bars "
        "at a "
        "point reach from the least to the most of the repeats.</p>\n<dl class=\"runs\">\n";
    for (const AnalysisRun& run : runs) {
        out += fmt::format("<dt>{}</dt><dd class=\"quiet\">{}</dd>\n", html_text(run.label),
                           html_text(heading_of(run)));
    }
    out += "</dl>\n<nav aria-label=\"On this page\">";
    for (const AnalysisDefinition& one : analysis_catalog()) {
        if (any_has(runs, one)) {
            out += fmt::format("<a href=\"#{}\">{}</a>", one.name, html_text(one.title));
        }
    }
    return out + "</nav>\n";
}

std::string numbers_part(const AnalysisDefinition& definition,
                         const std::vector<AnalysisRun>& runs) {
    std::string out;
    for (std::size_t panel = 0; panel < definition.panels.size(); ++panel) {
        const auto rows = numbers(definition, panel, runs);
        out += fmt::format(
            "<div class=\"numbers wide\" role=\"region\" aria-label=\"Numbers of {}\" "
            "tabindex=\"0\"><table>\n<thead><tr>",
            html_text(definition.title));
        for (const std::string& cell : rows[0]) {
            out += fmt::format("<th scope=\"col\">{}</th>", html_text(cell));
        }
        out += "</tr></thead>\n<tbody>\n";
        for (std::size_t i = 1; i < rows.size(); ++i) {
            out += fmt::format("<tr><th scope=\"row\">{}</th>", html_text(rows[i][0]));
            for (std::size_t cell = 1; cell < rows[i].size(); ++cell) {
                out += fmt::format("<td>{}</td>", html_text(rows[i][cell]));
            }
            out += "</tr>\n";
        }
        out += "</tbody></table></div>\n";
    }
    return out;
}

std::string analysis_part(const AnalysisDefinition& definition,
                          const std::vector<AnalysisRun>& runs) {
    std::string seen;
    std::string pictures;
    for (const AnalysisRun& run : runs) {
        const AnalysisResult* result = run.find(definition.name);
        if (result == nullptr) continue;
        seen += fmt::format("<p>{}</p>\n", html_text(finding(run, *result)));
        pictures += fmt::format("{}: {}. ", run.label, picture_of(result->parameters));
    }
    for (const GivenSeries& given : definition.given) {
        pictures += fmt::format("{}: {}. ", given.name, given.source);
    }
    return fmt::format(
        "<section id=\"{}\" aria-labelledby=\"{}-title\">\n<h2 id=\"{}-title\">{}</h2>\n"
        "<div class=\"analysis\">\n<figure>\n{}</figure>\n<div class=\"seen\">\n{}"
        "<p class=\"quiet\"><b>The 2018 paper:</b> {}</p>\n<p class=\"quiet\">{}</p>\n"
        "<p class=\"quiet\">{}</p>\n</div>\n{}</div>\n</section>\n",
        definition.name, definition.name, definition.name, html_text(definition.title),
        figure(definition, runs), seen, html_text(definition.report), html_text(definition.how),
        html_text(pictures), numbers_part(definition, runs));
}

/// Columns are as wide as they have to be; the first is left-aligned.
std::string text_table(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> widths(rows[0].size(), 0);
    for (const auto& row : rows) {
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    }
    std::string out;
    for (const auto& row : rows) {
        std::string line = fmt::format("  {:<{}}", row[0], widths[0]);
        for (std::size_t i = 1; i < row.size(); ++i) {
            line += fmt::format("  {:>{}}", row[i], widths[i]);
        }
        out += line + "\n";
    }
    return out;
}

}  // namespace

std::string analysis_page(const std::vector<AnalysisRun>& runs) {
    std::string analyses;
    for (const AnalysisDefinition& one : analysis_catalog()) {
        if (any_has(runs, one)) analyses += analysis_part(one, runs);
    }
    return filled_page(
        "analysis.html",
        {{"policy",
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
          "style-src 'unsafe-inline'\">"},
         {"title", "<title>scotty analyze</title>"},
         {"header", header_part(runs)},
         {"analyses", analyses}});
}

std::string analysis_text(const std::vector<AnalysisRun>& runs) {
    std::string out;
    for (const AnalysisRun& run : runs) {
        out += fmt::format("{}: {}\n", run.label, heading_of(run));
    }
    for (const AnalysisDefinition& one : analysis_catalog()) {
        if (!any_has(runs, one)) continue;
        out += fmt::format("\n{} ({})\n", one.title, one.name);
        for (std::size_t panel = 0; panel < one.panels.size(); ++panel) {
            out += text_table(numbers(one, panel, runs));
        }
        for (const AnalysisRun& run : runs) {
            if (const AnalysisResult* result = run.find(one.name)) {
                out += finding(run, *result) + "\n";
            }
        }
    }
    return out;
}

}  // namespace scotty::verify
