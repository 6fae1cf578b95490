/// A sweep in parts: what the shards of `scotty verify --shard` leave, and the whole that is made
/// of them.
///
/// A part loses nothing (to_json(Report) in report.h is for reading by others, and has no way
/// back): a number that is not finite is a string that begins with U+0001.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "verify/base/shard.h"
#include "verify/report/report.h"

namespace scotty::verify {

struct ReportPart {
    Shard shard;
    std::size_t units = 0;  ///< runs and golden images of the whole sweep
    /// What the whole sweep was asked for: parts of two sweeps are not joined.
    nlohmann::ordered_json sweep;
    Report report;
};

nlohmann::json part_json(const ReportPart& part);
/// Whether a JSON document says that it is one.
bool is_part(const nlohmann::json& object);
/// Of the content of `path`. Throws bad_input naming file and element.
ReportPart read_part(const std::filesystem::path& path, nlohmann::json object);

/// Every shard is there, and none twice: names[i] is the file of shards[i]. Throws bad_input.
void check_shards(const std::vector<Shard>& shards, const std::vector<std::string>& names);

/// The report of the whole sweep, as a run that was not split gives it but for seconds, which are
/// added up. Throws bad_input: a shard that is missing or there twice, parts of two sweeps, a run
/// that nobody made.
Report join(const std::vector<ReportPart>& parts, const std::vector<std::string>& names);

}  // namespace scotty::verify
