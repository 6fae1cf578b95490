/// A capture's index: what its JSON says about parameters, scene and stages (docs/captures.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_observer.h"
#include "verify/capture/include/scotty/capture_layout.h"

namespace scotty::verify {

using capture::kCaptureFormat;
using capture::kInputFormat;
inline constexpr int kCaptureVersion = capture::kVersion;
inline constexpr const char* kIndexFile = "index.json";
inline constexpr const char* kInputFolder = "input";

using reference::BufferOrder;
const char* to_string(BufferOrder order);

struct BufferRecord {
    std::string name;
    reference::ElementType type = reference::ElementType::uint32;
    std::vector<std::size_t> shape;
    std::string meaning;
    BufferOrder order = BufferOrder::ordered;
    std::string file;            ///< within the capture: "buffers/0123456789abcdef.npy"
    std::string hash;            ///< XXH64 of the bytes
    std::string canonical_hash;  ///< of the canonical form: equal where the order was free
};

struct StageRecord {
    std::string name;
    reference::StageKind kind = reference::StageKind::primary_rays;
    std::uint32_t launch = 0;
    std::uint32_t batch = 0;
    std::uint32_t bounce = reference::kNotApplicable;
    std::uint32_t light = reference::kNotApplicable;
    std::uint32_t level = reference::kNotApplicable;
    std::uint32_t blocks = 0;
    std::uint32_t threads = 0;
    std::vector<BufferRecord> inputs;
    std::vector<BufferRecord> outputs;

    /// Null where there is no such buffer.
    const BufferRecord* input(std::string_view buffer) const;
    const BufferRecord* output(std::string_view buffer) const;
};

/// What a capture is of. Whoever runs a pipeline fills it in.
struct CaptureHeader {
    std::string backend;  ///< "emulator", "simt", "cuda"; "none": only an input
    reference::PipelineParameters parameters;
    std::string scene_name;
    std::string scene_source;
    std::uint64_t scene_fingerprint = 0;
    std::uint64_t bvh_fingerprint = 0;
    int bvh_width = 0;
    std::uint32_t bvh_levels = 0;
    bool several_batches = false;       ///< the writer sets it from the stages' names
    std::vector<std::string> patterns;  ///< which stages were asked for; empty: all
    /// Written by another program, through capture_writer.h: its ids and its arithmetic.
    bool foreign = false;
    bool culls = false;  ///< of a foreign one: rays need not be pushed on behind a hit
};

struct CaptureIndex {
    CaptureHeader header;
    std::vector<StageRecord> stages;
};

/// The buffer, and the text of index.json, as capture_layout.h writes them.
capture::StoredBuffer layout_buffer(const BufferRecord& buffer);
std::string text_of(const CaptureIndex& index);
/// What of it is known before there are stages.
capture::Index layout_header(const CaptureHeader& header);
/// Throws bad_input naming `file` and the element.
CaptureIndex parse_index(const std::filesystem::path& file, const nlohmann::json& object);

/// Every field by its name; enumerations as their words.
nlohmann::ordered_json to_json(const reference::PipelineParameters& parameters);
/// Throws bad_input naming `where` and the field; the result has been validated. `some`: those
/// that are missing are as they are by default.
reference::PipelineParameters parse_parameters(const std::string& where,
                                               const nlohmann::json& object, bool some = false);

/// The whole file as JSON; throws bad_input naming it.
nlohmann::json read_json(const std::filesystem::path& file);
/// Throws bad_input unless `object` says that format and version.
void expect_format(const std::filesystem::path& file, const nlohmann::json& object,
                   const char* format, int expected_version = kCaptureVersion);

/// A member of a JSON object; throws bad_input naming `where` and the member.
const nlohmann::json& member(const std::string& where, const nlohmann::json& object,
                             const char* name);
std::uint64_t unsigned_member(const std::string& where, const nlohmann::json& object,
                              const char* name, std::uint64_t most);
std::string text_member(const std::string& where, const nlohmann::json& object, const char* name);
/// 16 hexadecimal digits.
std::uint64_t hex_member(const std::string& where, const nlohmann::json& object, const char* name);
/// The member "fingerprint"; none where it is null, as in captures of other programs.
std::optional<std::uint64_t> fingerprint_member(const std::string& where,
                                                const nlohmann::json& object);

}  // namespace scotty::verify
