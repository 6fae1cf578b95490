#include "verify/queues/queues_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verify/base/json_number.h"

namespace scotty::verify {

using nlohmann::ordered_json;
using reference::kNotApplicable;

namespace {

using Cells = std::vector<ordered_json>;

std::string cell_text(const ordered_json& cell, const char* nothing) {
    if (cell.is_null()) return nothing;
    if (cell.is_string()) return cell.get<std::string>();
    if (cell.is_number_float()) return fmt::format("{:.9g}", cell.get<double>());
    return cell.dump();
}

void add(Cells& row, const Cells& more) { row.insert(row.end(), more.begin(), more.end()); }

std::string range_text(const std::vector<std::uint32_t>& ids,
                       const std::vector<std::uint32_t>& counts) {
    std::string text;
    for (std::size_t i = 0; i < ids.size(); ++i) {
        text += fmt::format("{}{}:{}", i == 0 ? "" : " ", ids[i], counts[i]);
    }
    return text;
}

const std::vector<std::string>& entry_columns() {
    static const std::vector<std::string> columns{
        "position",    "block",    "thread",   "ray",      "pixel_x",     "pixel_y",
        "sample",      "origin.x", "origin.y", "origin.z", "direction.x", "direction.y",
        "direction.z", "t_min",    "t_max",    "minimum"};
    return columns;
}

Cells entry_cells(const Entry& entry) {
    Cells row{entry.position, entry.block, entry.thread, json_id(entry.ray)};
    if (entry.from) {
        add(row, {entry.from->pixel_x, entry.from->pixel_y, entry.from->sample});
    } else {
        add(row, {nullptr, nullptr, nullptr});
    }
    if (entry.record) {
        const reference::Ray& ray = *entry.record;
        add(row, {json_number(ray.origin.x), json_number(ray.origin.y), json_number(ray.origin.z),
                  json_number(ray.direction.x), json_number(ray.direction.y),
                  json_number(ray.direction.z), json_number(ray.t_min), json_number(ray.t_max)});
    } else {
        row.resize(row.size() + 8);
    }
    row.push_back(json_number(entry.minimum));
    return row;
}

}  // namespace

std::string to_text(const Table& table, std::size_t limit) {
    const std::size_t shown = limit == 0 ? table.rows.size() : std::min(limit, table.rows.size());
    std::vector<std::size_t> widths;
    for (const std::string& column : table.columns) widths.push_back(column.size());
    for (std::size_t r = 0; r < shown; ++r) {
        for (std::size_t c = 0; c < widths.size(); ++c) {
            widths[c] = std::max(widths[c], cell_text(table.rows[r][c], "-").size());
        }
    }
    std::string text = table.title + "\n";
    const auto line = [&](const auto& cell, std::size_t r) {
        std::string out;
        for (std::size_t c = 0; c < widths.size(); ++c) {
            const bool left =
                !table.rows.empty() && r < table.rows.size() && table.rows[r][c].is_string();
            out += left ? fmt::format("{:<{}}", cell(c), widths[c])
                        : fmt::format("{:>{}}", cell(c), widths[c]);
            if (c + 1 < widths.size()) out += "  ";
        }
        out.erase(out.find_last_not_of(' ') + 1);
        text += out + "\n";
    };
    line([&](std::size_t c) { return table.columns[c]; }, 0);
    for (std::size_t r = 0; r < shown; ++r) {
        line([&](std::size_t c) { return cell_text(table.rows[r][c], "-"); }, r);
    }
    if (shown < table.rows.size()) {
        text += fmt::format("... {} more rows; --all shows them\n", table.rows.size() - shown);
    }
    return text;
}

std::string to_csv(const Table& table) {
    std::string text;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
        text += (c == 0 ? "" : ",") + table.columns[c];
    }
    text += "\n";
    for (const Cells& row : table.rows) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::string cell = cell_text(row[c], "");
            text += c == 0 ? "" : ",";
            text += cell.find(',') == std::string::npos ? cell : "\"" + cell + "\"";
        }
        text += "\n";
    }
    return text;
}

ordered_json to_json(const Table& table) {
    ordered_json rows = ordered_json::array();
    for (const Cells& row : table.rows) {
        ordered_json object;
        for (std::size_t c = 0; c < row.size(); ++c) object[table.columns[c]] = row[c];
        rows.push_back(std::move(object));
    }
    return {{"title", table.title}, {"rows", std::move(rows)}};
}

Table launch_table(const std::string& title, const std::vector<LaunchRow>& rows) {
    Table table{title,
                {"launch", "stage", "level", "nodes", "with_work", "entries", "longest", "at_node",
                 "blocks", "pushed"},
                {}};
    const bool verdicts = std::any_of(
        rows.begin(), rows.end(), [](const LaunchRow& row) { return row.verdict || row.missing; });
    if (verdicts) table.columns.emplace_back("verdict");
    for (const LaunchRow& launch : rows) {
        Cells row{launch.stage->launch, launch.stage->name, json_id(launch.stage->level)};
        if (launch.totals) {
            const LevelTotals& t = *launch.totals;
            add(row, {t.nodes, t.with_work, t.entries, t.longest, json_id(t.longest_node), t.blocks,
                      t.pushed});
        } else {
            add(row, {nullptr, nullptr, nullptr, nullptr, nullptr, launch.stage->blocks, nullptr});
        }
        if (verdicts) {
            row.emplace_back(launch.missing   ? "missing"
                             : launch.verdict ? to_string(*launch.verdict)
                                              : "not compared");
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

namespace {

const char* kind_of(const NodeRow& node) {
    return !node.leaf ? "inner" : node.triangles == 0 ? "subtree" : "leaf";
}

}  // namespace

Table node_table(const std::string& title, const std::vector<NodeRow>& rows) {
    Table table{title,
                {"node", "parent", "kind", "count", "offset", "first_block", "blocks", "triangles",
                 "children"},
                {}};
    for (const NodeRow& node : rows) {
        table.rows.push_back({node.node, json_id(node.parent), kind_of(node), node.claimed,
                              node.offset, node.first_block, node.blocks,
                              node.triangles != 0 ? ordered_json(node.triangles) : ordered_json(),
                              range_text(node.children, node.pushed)});
    }
    return table;
}

Table node_table(const std::string& title, const std::vector<NodePair>& rows) {
    Table table{
        title, {"node", "kind", "count_a", "count_b", "moved", "changed", "missing", "extra"}, {}};
    for (const NodePair& node : rows) {
        table.rows.push_back({node.a.node, kind_of(node.a), node.a.claimed, node.b.claimed,
                              node.moved, node.changed, node.missing, node.extra});
    }
    return table;
}

Table entry_table(const std::string& title, const std::vector<Entry>& rows) {
    Table table{title, entry_columns(), {}};
    for (const Entry& entry : rows) table.rows.push_back(entry_cells(entry));
    return table;
}

Table entry_table(const std::string& title, const std::vector<EntryPair>& rows) {
    Table table{title, {"change", "what", "position_b"}, {}};
    table.columns.insert(table.columns.end(), entry_columns().begin(), entry_columns().end());
    for (const EntryPair& pair : rows) {
        Cells row{to_string(pair.change), pair.what,
                  pair.b ? ordered_json(pair.b->position) : ordered_json()};
        add(row, entry_cells(pair.a ? *pair.a : *pair.b));
        if (!pair.a) row[3] = nullptr;  // the position is A's
        table.rows.push_back(std::move(row));
    }
    return table;
}

}  // namespace scotty::verify
