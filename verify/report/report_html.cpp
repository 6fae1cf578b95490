/// The report page: what went wrong first, then scenes, images and runs. verify/pages/web/ has how
/// it looks and what it does.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "verify/pages/page.h"
#include "verify/report/failure_groups.h"
#include "verify/report/report.h"

namespace scotty::verify {
namespace {

/// Beyond these a table says first what there is.
constexpr std::size_t kOpenFailures = 8;

std::string verdict(bool passed) {
    return passed ? "passed" : R"(<span class="fault">failed</span>)";
}

std::string counted(std::size_t count, const std::string& what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// The twin of house.js's command().
std::string command(const std::string& text, const char* what) {
    return fmt::format(R"(<div class="command"><code>{}</code><button type="button" class="copy" )"
                       "aria-label=\"Copy the command to {}\">Copy</button></div>\n",
                       html_text(text), what);
}

/// A name as a value in the page's own address (#case=...).
std::string in_address(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
            out += c;
        } else {
            out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
        }
    }
    return out;
}

std::string place_text(const Failure& failure) {
    std::string place;
    const auto add = [&](const char* what, std::uint32_t number) {
        if (number == reference::kNotApplicable) return;
        place += fmt::format("{}{} {}", place.empty() ? "" : ", ", what, number);
    };
    add("launch", failure.launch);
    if (!failure.stage.empty()) place += (place.empty() ? "" : " ") + failure.stage;
    add("node", failure.node);
    add("block", failure.block);
    add("ray", failure.ray);
    return place;
}

std::string finding(const PlacedFailure& placed) {
    const Failure& failure = placed.failure;
    std::string out =
        fmt::format("<div class=\"finding\">\n<h3><span class=\"fault\">{}</span> in {}</h3>\n",
                    html_text(failure.invariant), html_text(placed.scene));
    if (placed.approve.empty()) {
        out += fmt::format("<p class=\"where quiet\">{}</p>\n<p class=\"where number\">{}</p>\n",
                           html_text(placed.configuration), html_text(place_text(failure)));
    }
    out += fmt::format("<p class=\"what\">{}</p>\n", html_text(failure.sentence));
    if (!failure.expected.empty() || !failure.found.empty()) {
        out += fmt::format(
            "<dl><dt>{} expected</dt><dd class=\"number\">{}</dd><dt>found</dt>"
            "<dd class=\"number\">{}</dd></dl>\n",
            html_text(failure.field.empty() ? "value" : failure.field), html_text(failure.expected),
            html_text(failure.found));
    }
    return out + "</div>\n";
}

std::string what_to_do(const PlacedFailure& placed) {
    std::string out;
    if (!placed.replay.empty()) {
        out +=
            "<p class=\"todo quiet\">Show it again</p>\n" + command(placed.replay, "show it again");
    }
    if (!placed.approve.empty()) {
        out += "<p class=\"todo quiet\">If the new image is right, make it the golden one</p>\n" +
               command(placed.approve, "approve the new image");
        out += fmt::format("<p class=\"todo\"><a href=\"#case={}\">Look at the image</a></p>\n",
                           in_address(placed.scene));
    }
    return out;
}

/// Several gates of one image are one affair.
bool same_image(const PlacedFailure& a, const PlacedFailure& b) {
    return !a.approve.empty() && a.approve == b.approve && a.replay == b.replay &&
           a.scene == b.scene;
}

/// How many there are of each kind, where that is not seen at a glance.
std::string groups_table(const std::vector<FailureGroup>& groups) {
    std::string out =
        "<div class=\"wide\" role=\"region\" aria-label=\"Failures by kind\" tabindex=\"0\">"
        "<table id=\"failure-groups\">\n<thead><tr><th scope=\"col\">invariant</th>"
        "<th scope=\"col\">stage</th><th scope=\"col\">failures</th>"
        "<th scope=\"col\">runs</th><th scope=\"col\">scenes</th></tr></thead>\n<tbody>\n";
    for (const FailureGroup& group : groups) {
        out += fmt::format(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            html_text(group.invariant), html_text(group.stage), group.members.size(),
            group.configurations, html_text(fmt::format("{}", fmt::join(group.scenes, ", "))));
    }
    return out + "</tbody></table></div>\n";
}

/// The first of a kind, and the others folded below it.
std::string group_item(const FailureGroup& group, const std::vector<PlacedFailure>& failures) {
    const PlacedFailure& first = failures[group.members.front()];
    std::string out = "<li>\n" + finding(first) + what_to_do(first);
    if (group.members.size() > 1) {
        out += fmt::format("<details><summary>{} more of {}{}</summary><ol class=\"failures\">\n",
                           group.members.size() - 1, html_text(group.invariant),
                           group.stage.empty() ? "" : " in " + html_text(group.stage));
        for (std::size_t i = 1; i < group.members.size(); ++i) {
            const PlacedFailure& placed = failures[group.members[i]];
            out += "<li>\n" + finding(placed) + what_to_do(placed) + "</li>\n";
        }
        out += "</ol></details>\n";
    }
    return out + "</li>\n";
}

/// Each image is an affair of its own, whichever gates it failed.
std::string image_items(const std::vector<PlacedFailure>& failures) {
    std::string out;
    for (std::size_t i = 0; i < failures.size(); ++i) {
        if (failures[i].approve.empty()) continue;
        if (i == 0 || !same_image(failures[i - 1], failures[i])) out += "<li>\n";
        out += finding(failures[i]);
        if (i + 1 == failures.size() || !same_image(failures[i], failures[i + 1])) {
            out += what_to_do(failures[i]) + "</li>\n";
        }
    }
    return out;
}

std::string failures_part(const std::vector<PlacedFailure>& failures) {
    if (failures.empty()) return "";
    std::string out =
        "<section id=\"failures\" aria-labelledby=\"failures-title\">\n<h2 "
        "id=\"failures-title\">Failures, the one to mend first at the top</h2>\n";
    const std::vector<FailureGroup> groups = failure_groups(failures);
    if (failures.size() > groups.size() || groups.size() > kOpenFailures) {
        out += groups_table(groups);
    }
    out += "<ol class=\"failures\">\n";
    for (const FailureGroup& group : groups) {
        if (failures[group.members.front()].approve.empty()) out += group_item(group, failures);
    }
    return out + image_items(failures) + "</ol>\n</section>\n";
}

/// "scotty verify", or "scotty diff": who makes such pages.
std::string made_by(const Report& report) {
    return report.command.starts_with("scotty diff") ? "scotty diff" : "scotty verify";
}

std::string verdict_part(const Report& report, std::size_t failures) {
    std::size_t runs = 0;
    std::uint64_t rays = 0;
    for (const SceneReport& scene : report.scenes) {
        runs += scene.configurations.size();
        rays += scene.rays();
    }
    std::vector<std::string> looked_at;
    if (!report.scenes.empty()) {
        looked_at.push_back(fmt::format("{} in {}, {} rays", counted(report.scenes.size(), "scene"),
                                        counted(runs, "run"), rays));
    }
    if (!report.images.empty()) {
        looked_at.push_back(counted(report.images.size(), "golden image"));
    }
    std::string out = fmt::format(
        "<p class=\"quiet\">{}</p>\n<h1{}</h1>\n<p class=\"lead\">{}.</p>\n",
        html_text(made_by(report)),
        report.passed() ? ">Passed"
        : failures == 0 ? " class=\"fault\">Not all was judged"
                        : fmt::format(" class=\"fault\">{}", counted(failures, "failure")),
        looked_at.empty() ? "Nothing was looked at"
                          : fmt::format("{}", fmt::join(looked_at, ", ")));
    const auto& p = report.parameters;
    const std::string parameters =
        fmt::format("{} x {} pixels, {} samples per pixel, {} bounces, {} light samples, seed {}; ",
                    p.image_width, p.image_height, p.spp, p.bounces, p.light_samples, p.seed);
    if (report.threads != 0) {
        out += fmt::format("<p class=\"quiet\">{}{}, {}, {:.1f} s</p>\n",
                           report.scenes.empty() ? "" : parameters, html_text(report.backend),
                           counted(report.threads, "thread"), report.seconds);
    }
    if (!report.stopped.empty()) {
        out += fmt::format("<p class=\"fault\">Not all was judged: {}.</p>\n",
                           html_text(report.stopped));
    }
    if (report.coverage) {
        out += fmt::format("<p class=\"quiet\">{}</p>\n", html_text(to_text(*report.coverage)));
    }
    out += command(report.command, "verify all of this again");
    out += "<nav aria-label=\"On this page\">";
    if (failures != 0) out += R"(<a href="#failures">Failures</a>)";
    if (!report.images.empty()) out += R"(<a href="#images">Images</a>)";
    if (!report.scenes.empty()) {
        out += R"(<a href="#scenes">Scenes</a><a href="#runs">Runs</a>)";
    }
    if (report.mutants) out += R"(<a href="#mutants">Planted faults</a>)";
    return out + "</nav>\n";
}

/// Failed ones first, otherwise as they came.
template <typename Item, typename Passed>
std::vector<const Item*> failed_first(const std::vector<Item>& items, const Passed& passed) {
    std::vector<const Item*> sorted;
    sorted.reserve(items.size());
    for (const Item& item : items) sorted.push_back(&item);
    std::stable_partition(sorted.begin(), sorted.end(),
                          [&](const Item* item) { return !passed(*item); });
    return sorted;
}

std::vector<const SceneReport*> ordered_scenes(const Report& report) {
    return failed_first(report.scenes, [](const SceneReport& scene) { return scene.passed(); });
}

std::string scenes_part(const Report& report) {
    std::string out =
        "<section id=\"scenes\" aria-labelledby=\"scenes-title\">\n<h2 "
        "id=\"scenes-title\">Scenes</h2>\n"
        "<div class=\"wide\" role=\"region\" aria-label=\"Scenes\" tabindex=\"0\"><table>\n<thead>"
        "<tr><th scope=\"col\">scene</th><th scope=\"col\">verdict</th>"
        "<th scope=\"col\">triangles</th><th scope=\"col\">runs</th><th scope=\"col\">rays</th>"
        "<th scope=\"col\">brute force</th><th scope=\"col\">Embree</th><th scope=\"col\">ties</th>"
        "<th scope=\"col\">grazing</th><th scope=\"col\">Embree wrong</th>"
        "<th scope=\"col\">ours wrong</th><th scope=\"col\">pixels equal</th>"
        "<th scope=\"col\">excused</th><th scope=\"col\">seconds</th></tr></thead>\n<tbody>\n";
    for (const SceneReport* s : ordered_scenes(report)) {
        const HitCheckResult& hits = s->hits;
        out += fmt::format(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
            "<td>{} of {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
            "<td>{} of {}</td><td>{}</td><td>{:.1f}</td></tr>\n",
            html_text(s->scene), verdict(s->passed()), s->triangles, s->configurations.size(),
            s->rays(), hits.brute_force_rays, hits.rays, hits.embree_rays + hits.occlusion_rays,
            hits.ties, hits.grazing, hits.embree_wrong, hits.ours_wrong, s->image.identical,
            s->image.pixels, s->image.excused, s->seconds);
    }
    return out + "</tbody></table></div>\n</section>\n";
}

std::string runs_of(const SceneReport& scene) {
    std::string out =
        "<div class=\"wide\" role=\"region\" aria-label=\"Runs\" tabindex=\"0\"><table>\n<thead>"
        "<tr><th scope=\"col\">configuration</th><th scope=\"col\">verdict</th>"
        "<th scope=\"col\">stages</th><th scope=\"col\">pushes</th><th scope=\"col\">culled</th>"
        "<th scope=\"col\">hits</th><th scope=\"col\">retries</th><th scope=\"col\">seconds</th>"
        "</tr></thead>\n<tbody>\n";
    const auto passed = [](const ConfigurationReport& c) { return c.failures.empty(); };
    for (const ConfigurationReport* c : failed_first(scene.configurations, passed)) {
        out += fmt::format(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
            "<td>{:.2f}</td></tr>\n",
            html_text(c->label), verdict(passed(*c)), c->counts.stages, c->counts.pushes,
            c->counts.culled, c->counts.leaf_hits, c->counts.retries, c->seconds);
    }
    return out + "</tbody></table></div>\n";
}

std::string runs_part(const Report& report) {
    std::string out =
        "<section id=\"runs\" aria-labelledby=\"runs-title\">\n<h2 id=\"runs-title\">Runs</h2>\n";
    for (const SceneReport* scene : ordered_scenes(report)) {
        const auto failed =
            std::count_if(scene->configurations.begin(), scene->configurations.end(),
                          [](const ConfigurationReport& c) { return !c.failures.empty(); });
        out += fmt::format(
            "<details{}><summary>{}<span class=\"number quiet\">{}</span>{}</summary>\n{}"
            "</details>\n",
            failed != 0 ? " open" : "", html_text(scene->scene),
            counted(scene->configurations.size(), "configuration"),
            failed != 0 ? fmt::format("<span class=\"fault\">{} failed</span>", failed) : "",
            runs_of(*scene));
    }
    return out + "</section>\n";
}

std::string mutants_part(const MutantReport& mutants) {
    std::string out = fmt::format(
        "<section id=\"mutants\" aria-labelledby=\"mutants-title\">\n<h2 "
        "id=\"mutants-title\">Planted faults</h2>\n<p class=\"lead\">{}</p>\n"
        "<div class=\"wide\" role=\"region\" aria-label=\"Planted faults\" tabindex=\"0\"><table>\n"
        "<thead><tr><th scope=\"col\">planted</th><th scope=\"col\">verdict</th><th "
        "scope=\"col\">in"
        "</th><th scope=\"col\">found by</th><th scope=\"col\">launch</th><th scope=\"col\">stage"
        "</th><th scope=\"col\">place</th><th scope=\"col\">seconds</th></tr></thead>\n<tbody>\n",
        html_text(score(mutants)));
    const auto caught = [](const MutantResult& result) { return result.caught(); };
    for (const MutantResult* result : failed_first(mutants.faults, caught)) {
        const MutantCatch& found = result->found;
        out += fmt::format(
            "<tr><th scope=\"row\" title=\"{}\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
            "<td>{}</td><td>{}</td><td>{:.1f}</td></tr>\n",
            html_text(result->fault.what), html_text(result->fault.name),
            result->caught() ? "caught" : R"(<span class="fault">escaped</span>)",
            html_text(result->fault.file), html_text(found.check),
            found.launch == reference::kNotApplicable ? "" : fmt::format("{}", found.launch),
            html_text(found.stage), html_text(found.place), result->seconds);
    }
    return out + "</tbody></table></div>\n</section>\n";
}

std::string image_data(const Report& report) {
    nlohmann::json data = nlohmann::json::array();
    const auto passed = [](const ImageCase& image) { return image.passed(); };
    for (const ImageCase* image : failed_first(report.images, passed)) {
        data.push_back(page_data(*image));
    }
    return fmt::format("<script type=\"application/json\" id=\"image-data\">{}</script>",
                       json_for_script(data));
}

}  // namespace

std::string to_html(const Report& report) {
    const auto failures = placed_failures(report);
    const bool images = !report.images.empty();
    return filled_page(
        "report.html",
        {// Nothing may be fetched, whatever a name from a file tries.
         {"policy",
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
          "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">"},
         {"title", fmt::format("<title>{}: {}</title>",
                               report.passed()    ? "Passed"
                               : failures.empty() ? "Stopped"
                                                  : counted(failures.size(), "failure"),
                               made_by(report))},
         {"verdict", verdict_part(report, failures.size())},
         {"failures", failures_part(failures)},
         {"images", images ? filled_page("images.html", {}) : ""},
         {"scenes", report.scenes.empty() ? "" : scenes_part(report)},
         {"mutants", report.mutants ? mutants_part(*report.mutants) : ""},
         {"runs", report.scenes.empty() ? "" : runs_part(report)},
         {"data", images ? image_data(report) : ""}});
}

}  // namespace scotty::verify
