/// The tables of docs/captures.md are those of the contract.
#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "reference/contract/buffers.h"
#include "reference/contract/stages.h"
#include "tests/catch.h"
#include "tests/temporary_folder.h"

namespace {

using namespace scotty::reference;
using scotty::tests::slurp;
using scotty::tests::spill;

const std::string kPage = std::string(SCOTTY_SOURCE_DIR) + "/docs/captures.md";

std::string code(std::string_view word) { return fmt::format("`{}`", word); }

const char* rows_of(const BufferInfo& info) {
    switch (info.row) {
        case Row::ray:
            return "ray";
        case Row::pixel:
            return "pixel";
        case Row::node:
            return "node";
        case Row::child_node:
            return "child node";
        case Row::pair:
            return "pair";
        case Row::child_pair:
            return "pair of the next level";
        case Row::none:
            break;
    }
    return "";
}

std::string equal_when(const BufferInfo& info) {
    switch (info.order) {
        case BufferOrder::queue:
            return fmt::format("queue: per node, the same set of the first `{}` entries",
                               info.lengths->name);
        case BufferOrder::hit_list:
            return fmt::format("hit_list: per ray, the same set of the first `{}` hits",
                               info.lengths->name);
        case BufferOrder::set:
            return "set: the same rows in any order";
        case BufferOrder::ordered:
            break;
    }
    return "ordered: bit for bit";
}

std::string infinite_fields(const BufferInfo& info) {
    std::string text;
    for (const Field& field : info.fields) {
        if (!field.may_be_infinite && field.blank != buffers::kInfinityBits) continue;
        text += (text.empty() ? "" : ", ") + (field.name.empty() ? "yes" : code(field.name));
    }
    return text.empty() ? "no" : text;
}

std::string tolerance_of(const BufferInfo& info) {
    const Tolerance& tolerance = info.tolerance;
    std::string text = tolerance.relative == 0.0 ? "none" : fmt::format("{:g}", tolerance.relative);
    if (!tolerance.only.empty()) text += fmt::format(" of {}", code(tolerance.only));
    if (tolerance.share == 0.0) return text;
    return text + fmt::format(", {:g} % of rows beyond", 100.0 * tolerance.share);
}

std::string buffer_table() {
    std::string text =
        "| buffer | a row is a | meaning | equal when | may be infinite | tolerance of fast |\n"
        "|---|---|---|---|---|---|\n";
    for (const BufferInfo* info : kBuffers) {
        text += fmt::format("| {} | {} | {} | {} | {} | {} |\n", code(info->name), rows_of(*info),
                            info->meaning, equal_when(*info), infinite_fields(*info),
                            tolerance_of(*info));
    }
    // A bar would end the cell.
    for (std::size_t at = 0; (at = text.find("<< 32 | ", at)) != std::string::npos; at += 9) {
        text.replace(at, 8, "<< 32 \\| ");
    }
    return text;
}

const char* where(When when) {
    switch (when) {
        case When::always:
            return "";
        case When::below_root:
            return " (below the root)";
        case When::culling:
            return " (with an early-out)";
        case When::level:
            return " (early-out `level`)";
        case When::immediate:
            return " (early-out `immediate`)";
        case When::hit_lists:
            return " (hit mode `buffer`)";
        case When::packed_hits:
            return " (hit mode `packed`)";
        case When::nodes:
            return " (queues of `nodes`)";
        case When::pairs:
            return " (queues of `pairs`)";
    }
    return "";
}

const char* from(Source source) {
    switch (source) {
        case Source::blank:
            return "blank: nothing is known yet";
        case Source::minimum:
            return "the stage's own `minimum`";
        case Source::level_before:
            return "the level before";
        case Source::primary_rays:
            return "`primary_rays`";
        case Source::vertex_before:
            return "`scene_rays` of the bounce before, else `primary_rays`";
        case Source::light_before:
            return "the light sample before, else the vertex before";
        case Source::last_light:
            return "the last `resolve_light` of the bounce, else the vertex before";
        case Source::batch_before:
            return "the batch before, else zeros";
    }
    return "";
}

template <class List>
std::string names(const List& list) {
    std::string text;
    for (const auto& each : list) {
        text += (text.empty() ? "" : ", ") + code(each.buffer->name) + where(each.when);
    }
    return text;
}

const char* thread_of(const StageInfo& stage) {
    if (is_level_kernel(stage.kind)) return "queue entry";
    if (stage.kind == StageKind::scan_counts) return "node";
    return stage.thread == Row::pixel ? "pixel" : "ray";
}

std::string stage_table() {
    std::string text =
        "| stage | a thread per | inputs | outputs | lowers besides |\n|---|---|---|---|---|\n";
    for (const StageInfo& stage : kStages) {
        text += fmt::format("| {} | {} | {} | {} | {} |\n", code(stage.name), thread_of(stage),
                            names(stage.inputs), names(stage.outputs), names(stage.lowers));
    }
    return text;
}

std::string need_table() {
    std::string text = "| stage | besides its inputs | from |\n|---|---|---|\n";
    for (const StageInfo& stage : kStages) {
        for (const StageNeed& need : stage.needs) {
            text += fmt::format("| {} | {}{} | {} |\n", code(stage.name), code(need.buffer->name),
                                where(need.when), from(need.source));
        }
    }
    return text;
}

/// The page with what stands between the marks of that name replaced.
std::string with_table(const std::string& page, const std::string& name, const std::string& table) {
    const std::string begin = "<!-- contract: " + name + " -->\n";
    const std::string end = "<!-- end -->\n";
    const std::size_t first = page.find(begin);
    INFO(begin);
    REQUIRE(first != std::string::npos);
    const std::size_t last = page.find(end, first);
    REQUIRE(last != std::string::npos);
    return page.substr(0, first) + begin + "\n" + table + "\n" + page.substr(last);
}

}  // namespace

TEST_CASE("contract: the tables of docs/captures.md are those of the contract",
          "[verify][capture][docs]") {
    const std::string page = slurp(kPage);
    std::string printed = with_table(page, "buffers", buffer_table());
    printed = with_table(printed, "stages", stage_table());
    printed = with_table(printed, "needs", need_table());
    if (std::getenv("SCOTTY_PRINT_DOCS") != nullptr) spill(kPage, printed);
    INFO(
        "after a change of the contract: SCOTTY_PRINT_DOCS=1 in the environment of this test "
        "prints the tables into "
        << kPage);
    CHECK((printed == page || std::getenv("SCOTTY_PRINT_DOCS") != nullptr));
}
