/// A verdict page that opens from disk: one file, no scripts, no network.
#include <fmt/format.h>

#include "verify/report.h"

namespace scotty::verify {
namespace {

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>scotty verify</title><style>
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em;
       color: #222; background: #fff }
table { border-collapse: collapse; margin: 1em 0 }
th, td { padding: .25em .8em; border-bottom: 1px solid #ddd; text-align: right }
th:first-child, td:first-child { text-align: left }
.passed { color: #176b2c } .failed { color: #a40e26; font-weight: bold }
code { background: #f2f2f2; padding: .1em .3em; overflow-wrap: anywhere }
@media (prefers-color-scheme: dark) {
  body { color: #ddd; background: #161616 } th, td { border-color: #444 }
  .passed { color: #6fcf85 } .failed { color: #ff8793 } code { background: #2a2a2a } }
</style></head><body>
)";

const char* verdict(bool passed) {
    return passed ? R"(<span class="passed">passed</span>)"
                  : R"(<span class="failed">FAILED</span>)";
}

}  // namespace

std::string to_html(const Report& report) {
    const auto& p = report.parameters;
    std::string out = kHead;
    out += fmt::format("<h1>scotty verify: {}</h1>\n", verdict(report.passed()));
    out += fmt::format(
        "<p>{} x {} pixels, {} samples a pixel, {} bounces, {} light samples, seed {}, {} threads, "
        "{:.1f} s. <code>{}</code></p>\n",
        p.image_width, p.image_height, p.spp, p.bounces, p.light_samples, p.seed, report.threads,
        report.seconds, escaped(report.command));
    const auto failures = placed_failures(report);
    if (!failures.empty()) {
        out += "<h2>Failures, the first one first</h2>\n<ol>\n";
        for (const PlacedFailure& failure : failures) {
            out += fmt::format("<li>{}, {}<br>{}<br><code>{}</code></li>\n", escaped(failure.scene),
                               escaped(failure.configuration), escaped(to_string(failure.failure)),
                               escaped(failure.replay));
        }
        out += "</ol>\n";
    }
    out +=
        "<h2>Scenes</h2>\n<table><tr><th>scene</th><th>triangles</th><th>configurations</th>"
        "<th>rays</th><th>against brute force</th><th>against Embree</th><th>ties</th>"
        "<th>grazing</th><th>Embree wrong</th><th>ours wrong</th><th>pixels equal</th>"
        "<th>pixels excused</th><th>seconds</th><th>verdict</th></tr>\n";
    for (const SceneReport& s : report.scenes) {
        out += fmt::format(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{} of "
            "{}</td><td>{}</td><td>{}</td>"
            "<td>{}</td><td>{}</td><td>{}</td><td>{} of {}</td><td>{}</td><td>{:.1f}</td>"
            "<td>{}</td></tr>\n",
            escaped(s.scene), s.triangles, s.configurations.size(), s.rays(),
            s.hits.brute_force_rays, s.hits.rays, s.hits.embree_rays + s.hits.occlusion_rays,
            s.hits.ties, s.hits.grazing, s.hits.embree_wrong, s.hits.ours_wrong, s.image.identical,
            s.image.pixels, s.image.excused, s.seconds, verdict(s.passed()));
    }
    out +=
        "</table>\n<h2>Runs</h2>\n<table><tr><th>scene</th><th>configuration</th><th>stages</th>"
        "<th>pushes</th><th>culled</th><th>hits</th><th>retries</th><th>seconds</th>"
        "<th>verdict</th></tr>\n";
    for (const SceneReport& s : report.scenes) {
        for (const ConfigurationReport& c : s.configurations) {
            out += fmt::format(
                "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
                "<td>{:.2f}</td><td>{}</td></tr>\n",
                escaped(s.scene), escaped(c.label), c.counts.stages, c.counts.pushes,
                c.counts.culled, c.counts.leaf_hits, c.counts.retries, c.seconds,
                verdict(c.failures.empty()));
        }
    }
    return out + "</table>\n</body></html>\n";
}

}  // namespace scotty::verify
