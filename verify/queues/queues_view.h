/// What `scotty queues` shows: tables of the model as text, CSV and JSON, and histories.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "verify/queues/queues.h"
#include "verify/queues/queues_diff.h"
#include "verify/queues/queues_history.h"

namespace scotty::verify {

struct Table {
    std::string title;
    std::vector<std::string> columns;
    /// Words, numbers, null where there is nothing. Floats have nine digits: exact.
    std::vector<std::vector<nlohmann::ordered_json>> rows;
};
/// Columns aligned. `limit`: rows at most, 0 for all; a last line says how to see the rest.
std::string to_text(const Table& table, std::size_t limit);
std::string to_csv(const Table& table);
/// {"title": .., "rows": [{column: value}]}
nlohmann::ordered_json to_json(const Table& table);

Table launch_table(const std::string& title, const std::vector<LaunchRow>& rows);
Table node_table(const std::string& title, const std::vector<NodeRow>& rows);
Table node_table(const std::string& title, const std::vector<NodePair>& rows);
Table entry_table(const std::string& title, const std::vector<Entry>& rows);
Table entry_table(const std::string& title, const std::vector<EntryPair>& rows);
/// A row for each child, hit or leaf that a ray came to.
Table history_table(const std::string& title, const RayHistory& history);
/// A row for each node that the ray was in, in either run.
Table history_table(const std::string& title, const RayHistory& a, const RayHistory& b);
/// The story for people: traversal by traversal, floats as hexadecimal and decimal.
std::string to_text(const RayHistory& history);

}  // namespace scotty::verify
