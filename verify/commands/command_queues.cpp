/// scotty queues: what was in the queues of a captured run, and how a ray went through them.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "verify/base/output_path.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/queues/queues_json.h"
#include "verify/queues/queues_page.h"
#include "verify/queues/queues_trace.h"
#include "verify/queues/queues_view.h"
#include "verify/report/report.h"

namespace scotty::verify {
namespace {

using reference::Error;

/// Rows and histories that text shows unless --all was said.
constexpr std::size_t kRows = 100;
constexpr std::size_t kHistories = 4;

struct QueuesCommand {
    std::string capture, other, stage, pixel, trace, html;
    std::optional<std::uint32_t> launch, level, node, ray;
    std::uint32_t batch = 0;
    bool csv = false, all = false;
    JsonOutput json;
};

class QueuesQuestion {
 public:
    explicit QueuesQuestion(const QueuesCommand& options)
        : options_(options), capture_(Capture::open(options.capture)), queues_(capture_) {
        if (!options_.other.empty()) {
            other_capture_.emplace(Capture::open(options_.other));
            expect_comparable(capture_, *other_capture_);
            other_.emplace(*other_capture_);
        }
        if (options_.node && options_.level &&
            queues_.level_of(*options_.node) != *options_.level) {
            throw Error::bad_input("--node",
                                   fmt::format("node {} is of level {}, not {}", *options_.node,
                                               queues_.level_of(*options_.node), *options_.level));
        }
        if (options_.level && *options_.level >= queues_.bvh().level_count()) {
            throw Error::bad_input("--level",
                                   fmt::format("there is no level {}; the tree has "
                                               "levels 0 to {}",
                                               *options_.level, queues_.bvh().level_count() - 1));
        }
    }

    void answer() {
        if (!options_.trace.empty()) {
            const auto rays = asked_rays();
            reference::write_file(options_.trace,
                                  to_trace(queues_, histories_of(queues_, rays)).dump());
            spdlog::info("{}: open it at ui.perfetto.dev, or in chrome://tracing", options_.trace);
            return;
        }
        if (!options_.html.empty()) return write_page();
        if (options_.ray || !options_.pixel.empty()) return answer_rays();
        const std::vector<const StageRecord*> stages = selected();
        const bool one = stages.size() == 1 && is_level_kernel(stages[0]->kind);
        if (one && options_.node) return show(entries(*stages[0]));
        if (one) return show(nodes(*stages[0]));
        if (options_.node) return show(node_everywhere(stages));
        show(overview(stages));
    }

 private:
    using Rays = std::vector<std::pair<std::uint32_t, std::uint32_t>>;  ///< batch and ray

    std::vector<const StageRecord*> selected() const {
        if (options_.launch) queues_.launch(*options_.launch);  // says what there is
        std::optional<std::uint32_t> level = options_.level;
        if (options_.node) level = queues_.level_of(*options_.node);
        const bool levels_only = options_.stage.empty() && !options_.launch;
        std::vector<const StageRecord*> out;
        for (const StageRecord& stage : capture_.stages()) {
            if (options_.launch && stage.launch != *options_.launch) continue;
            if (!stage_matches(options_.stage, stage.name)) continue;
            if (levels_only && !is_level_kernel(stage.kind)) continue;
            // Of a level's launches the one that reads its queues.
            if (level && (stage.level != *level || !is_level_kernel(stage.kind))) continue;
            out.push_back(&stage);
        }
        if (!out.empty()) return out;
        if (options_.launch) {
            const StageRecord& stage = queues_.launch(*options_.launch);
            throw Error::bad_input(
                stage.name, fmt::format("launch {} is not of what else was asked "
                                        "for{}",
                                        stage.launch,
                                        level ? fmt::format(": level {}", *level) : std::string()));
        }
        throw Error::bad_input(options_.capture,
                               "no such launch was captured; scotty queues CAPTURE --stage '*' "
                               "lists what there is");
    }

    Table overview(const std::vector<const StageRecord*>& stages) const {
        std::optional<DiffReport> report;
        if (other_capture_) report = diff_by_hash(capture_, *other_capture_);
        std::vector<LaunchRow> rows = queues_.launches(report ? &*report : nullptr);
        std::erase_if(rows, [&](const LaunchRow& row) {
            return std::find(stages.begin(), stages.end(), row.stage) == stages.end();
        });
        const auto& header = capture_.header();
        return launch_table(
            fmt::format("{}: {} on {}, {} launches, {} nodes in {} levels{}", options_.capture,
                        header.scene_name, header.backend, capture_.stages().size(),
                        queues_.bvh().node_count(), queues_.bvh().level_count(), against()),
            rows);
    }

    Table nodes(const StageRecord& stage) const {
        const std::string title =
            fmt::format("launch {} {}{}", stage.launch, stage.name, against());
        if (!other_) return node_table(title, queues_.nodes(stage));
        return node_table(title, compare_nodes(queues_, stage, *other_, partner(stage)));
    }

    Table entries(const StageRecord& stage) const {
        const std::string title = fmt::format("launch {} {}, node {}{}", stage.launch, stage.name,
                                              *options_.node, against());
        const auto rows = queues_.entries(stage, *options_.node);
        if (!other_) return entry_table(title, rows);
        return entry_table(title, align(rows, other_->entries(partner(stage), *options_.node)));
    }

    /// One node in every traversal.
    Table node_everywhere(const std::vector<const StageRecord*>& stages) const {
        Table out;
        for (const StageRecord* stage : stages) {
            Table table = nodes(*stage);
            out.columns = table.columns;
            for (auto& row : table.rows) {
                if (row[0] != *options_.node) continue;
                row.insert(row.begin(), {stage->launch, stage->name});
                out.rows.push_back(std::move(row));
            }
        }
        out.columns.insert(out.columns.begin(), {"launch", "stage"});
        out.title = fmt::format("node {} in {} traversals{}; --launch K shows its queue in one",
                                *options_.node, stages.size(), against());
        return out;
    }

    const StageRecord& partner(const StageRecord& stage) const {
        const StageRecord* found = other_capture_->find(stage.name);
        if (found != nullptr) return *found;
        throw Error::bad_input(options_.other, fmt::format("holds no {}", stage.name));
    }

    std::string against() const {
        return other_ ? fmt::format("; A is {}, B is {}", options_.capture, options_.other) : "";
    }

    Rays asked_rays() const {
        Rays rays;
        if (options_.ray) rays.emplace_back(options_.batch, *options_.ray);
        if (options_.pixel.empty()) return rays;
        const auto [x, y] = asked_pixel();
        const Rays of_pixel = queues_.rays_of(x, y);
        rays.insert(rays.end(), of_pixel.begin(), of_pixel.end());
        return rays;
    }

    void write_page() const {
        PageRequest request;
        request.launch = options_.launch;
        request.node = options_.node;
        request.ray = options_.ray;
        if (!options_.pixel.empty()) {
            request.pixel = asked_pixel();
            queues_.rays_of(request.pixel->first, request.pixel->second);  // says what there is
        }
        if (options_.ray) histories_of(queues_, {{options_.batch, *options_.ray}});
        const std::string page = queues_page(queues_, other_ ? &*other_ : nullptr, request);
        reference::write_file(options_.html, page);
        spdlog::info("{}: {:.1f} MB, opens in any browser", options_.html,
                     static_cast<double>(page.size()) / 1e6);
    }

    std::pair<std::uint32_t, std::uint32_t> asked_pixel() const {
        unsigned x = 0;
        unsigned y = 0;
        char rest = 0;
        if (std::sscanf(options_.pixel.c_str(), "%u,%u%c", &x, &y, &rest) != 2) {
            throw Error::bad_input(
                "--pixel", fmt::format("expected X,Y such as 12,40, found '{}'", options_.pixel));
        }
        return {x, y};
    }

    /// Every batch is read once.
    std::vector<RayHistory> histories_of(const Queues& queues, const Rays& rays) const {
        std::vector<RayHistory> out;
        for (std::size_t i = 0; i < rays.size();) {
            std::vector<std::uint32_t> of_batch;
            const std::uint32_t batch = rays[i].first;
            for (; i < rays.size() && rays[i].first == batch; ++i) {
                of_batch.push_back(rays[i].second);
            }
            for (RayHistory& history : histories(queues, batch, of_batch)) {
                narrow(history);
                out.push_back(std::move(history));
            }
        }
        return out;
    }

    /// To the launch, level and node that were asked for.
    void narrow(RayHistory& history) const {
        const auto keep = [&](TraversalHistory& traversal) {
            std::erase_if(traversal.visits, [&](const Visit& visit) {
                return (options_.launch && visit.launch != *options_.launch) ||
                       (options_.level && visit.level != *options_.level) ||
                       (options_.node && visit.node != *options_.node) ||
                       !stage_matches(options_.stage, visit.stage);
            });
        };
        for (BounceHistory& bounce : history.bounces) {
            keep(bounce.traversal);
            for (LightHistory& light : bounce.lights) keep(light.traversal);
        }
    }

    void answer_rays() const {
        Rays rays = asked_rays();
        const std::size_t all = rays.size();
        const bool text = !options_.json.in_place() && !options_.csv;
        const bool cut = text && !options_.all && rays.size() > kHistories;
        if (cut && options_.json.file.empty()) rays.resize(kHistories);
        auto of_a = histories_of(queues_, rays);
        std::vector<RayHistory> of_b;
        if (other_) of_b = histories_of(*other_, rays);
        const std::string title = "rays of " + options_.capture + against();
        if (!options_.json.file.empty()) {
            const std::string json = document(title, of_a, of_b);
            if (!text) return print_result(json);
            reference::write_file(options_.json.file, json + "\n");
        }
        if (cut) of_a.resize(kHistories);
        Table table;
        std::string story;
        for (std::size_t i = 0; i < of_a.size(); ++i) {
            Table one =
                other_ ? history_table(title, of_a[i], of_b[i]) : history_table(title, of_a[i]);
            table.title = one.title;
            table.columns = one.columns;
            table.rows.insert(table.rows.end(), one.rows.begin(), one.rows.end());
            if (!other_) story += to_text(of_a[i]);
        }
        if (!text || other_) {
            print_result(text_of(table));
        } else {
            print_result(story);
        }
        if (text && of_a.size() < all) {
            print_result(fmt::format("... {} more rays; --all shows them", all - of_a.size()));
        }
    }

    static std::string document(const std::string& title, const std::vector<RayHistory>& of_a,
                                const std::vector<RayHistory>& of_b) {
        nlohmann::ordered_json rays = nlohmann::ordered_json::array();
        for (std::size_t i = 0; i < of_a.size(); ++i) {
            rays.push_back(of_b.empty() ? to_json(of_a[i]) : to_json(of_a[i], of_b[i]));
        }
        return nlohmann::ordered_json{{"title", title}, {"rays", std::move(rays)}}.dump(2);
    }

    void show(const Table& table) const {
        print_result(options_.json, to_json(table).dump(2), text_of(table));
    }

    std::string text_of(const Table& table) const {
        return options_.csv ? to_csv(table) : to_text(table, options_.all ? 0 : kRows);
    }

    const QueuesCommand& options_;
    Capture capture_;
    Queues queues_;
    std::optional<Capture> other_capture_;
    std::optional<Queues> other_;
};

}  // namespace

void add_queues_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "queues", "Look into the queues of a captured run: levels, nodes, entries, rays.");
    command->footer(
        "Examples:\n"
        "  scotty queues coil.capture                          every level of every traversal\n"
        "  scotty queues coil.capture --stage '*'              all launches\n"
        "  scotty queues coil.capture --launch 8               the nodes of that level\n"
        "  scotty queues coil.capture --launch 8 --node 40     the rays in that node's queue\n"
        "  scotty queues coil.capture --node 40                the node in every traversal\n"
        "  scotty queues coil.capture --ray 1234               where a ray went, and why\n"
        "  scotty queues coil.capture --pixel 12,40            the same of a pixel's rays\n"
        "  scotty queues coil.emulator --diff coil.cuda --launch 8 --node 40\n"
        "  scotty queues coil.capture --html coil.html         all of it as a page\n"
        "  scotty queues coil.capture --trace coil.json --ray 1234   (for ui.perfetto.dev)\n\n"
        "With --diff rays are aligned by id: moved (another position, which is free), changed,\n"
        "missing and extra (in the other capture). It shows, scotty diff judges: the exit code is\n"
        "0. --csv and --json are never cut short. See docs/debugging-queues.md.");
    auto options = std::make_shared<QueuesCommand>();
    command->add_option("capture", options->capture, "a capture")->required();
    command->add_option("--launch", options->launch, "only the launch of that number");
    command->add_option("--stage", options->stage, "only launches of such names")
        ->type_name("PATTERN");
    command->add_option("--level", options->level, "only that level of the tree");
    command->add_option("--node", options->node, "only that node, by its breadth-first id");
    command->add_option("--ray", options->ray, "the history of the ray of that id");
    command->add_option("--batch", options->batch, "the batch of --ray, where there are several")
        ->capture_default_str();
    command->add_option("--pixel", options->pixel, "the histories of a pixel's rays")
        ->type_name("X,Y");
    command->add_option("--diff", options->other, "another capture of the same run, beside it")
        ->type_name("OTHER");
    command->add_option("--trace", options->trace, "write a time line as Chrome trace JSON")
        ->type_name("FILE")
        ->check(output_file());
    command
        ->add_option("--html", options->html,
                     "write all of it as a page, which shows what else was asked for first")
        ->type_name("FILE")
        ->check(output_file());
    auto* csv = command->add_flag("--csv", options->csv, "the rows as CSV");
    add_json_option(*command, options->json);
    command->get_option("--json")->excludes(csv);
    command->add_flag("--all", options->all, "all rows and rays, however many there are");
    command->callback([&action, options] {
        action = [options] {
            QueuesQuestion(*options).answer();
            return kExitPassed;
        };
    });
}

}  // namespace scotty::verify
