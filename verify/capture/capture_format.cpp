#include "verify/capture/capture_format.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "reference/base/error.h"
#include "verify/capture/layout.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using nlohmann::json;
using nlohmann::ordered_json;
using reference::ElementType;
using reference::Error;
using reference::kNotApplicable;
using reference::StageKind;

namespace {

/// The value that goes by that word; throws where there is none.
template <class Value, class Range>
Value value_of(const std::string& where, const char* name, const std::string& word,
               const Range& values) {
    std::string known;
    for (const Value value : values) {
        if (word == to_string(value)) return value;
        known += (known.empty() ? "" : ", ") + std::string(to_string(value));
    }
    throw Error::bad_input(where,
                           fmt::format("'{}': expected one of {}, found '{}'", name, known, word));
}

constexpr std::array kElementTypes{ElementType::uint8, ElementType::uint32, ElementType::uint64,
                                   ElementType::float32};
constexpr std::array<StageKind, reference::kStageKinds> kKinds = [] {
    std::array<StageKind, reference::kStageKinds> kinds{};
    for (std::size_t i = 0; i < kinds.size(); ++i) kinds[i] = reference::kStages[i].kind;
    return kinds;
}();
constexpr std::array kOrders{BufferOrder::ordered, BufferOrder::queue, BufferOrder::hit_list,
                             BufferOrder::set};

std::uint32_t number_member(const std::string& where, const json& object, const char* name) {
    return static_cast<std::uint32_t>(unsigned_member(where, object, name, 0xffffffffu));
}

std::uint32_t place_member(const std::string& where, const json& object, const char* name) {
    return member(where, object, name).is_null() ? kNotApplicable
                                                 : number_member(where, object, name);
}

const json& array_member(const std::string& where, const json& object, const char* name) {
    const json& value = member(where, object, name);
    if (!value.is_array()) {
        throw Error::bad_input(where, fmt::format("'{}': expected a list", name));
    }
    return value;
}

BufferRecord parse_buffer(const std::string& where, const json& object) {
    BufferRecord buffer;
    buffer.name = text_member(where, object, "name");
    buffer.type =
        value_of<ElementType>(where, "type", text_member(where, object, "type"), kElementTypes);
    for (const json& size : array_member(where, object, "shape")) {
        if (!size.is_number_unsigned()) {
            throw Error::bad_input(where, "'shape': expected whole numbers");
        }
        buffer.shape.push_back(size.get<std::size_t>());
    }
    buffer.meaning = text_member(where, object, "meaning");
    buffer.order =
        value_of<BufferOrder>(where, "order", text_member(where, object, "order"), kOrders);
    buffer.file = text_member(where, object, "file");
    // Never a path that leads out of the capture.
    const std::string_view file = buffer.file;
    if (!file.starts_with("buffers/") || !file.ends_with(".npy") ||
        file.find('/', 8) != std::string_view::npos) {
        throw Error::bad_input(
            where, fmt::format("'file': expected buffers/NAME.npy, found '{}'", buffer.file));
    }
    hex_member(where, object, "hash");
    buffer.hash = text_member(where, object, "hash");
    hex_member(where, object, "canonical_hash");
    buffer.canonical_hash = text_member(where, object, "canonical_hash");
    return buffer;
}

bool boolean_member(const std::string& where, const json& object, const char* name) {
    const json& value = member(where, object, name);
    if (!value.is_boolean()) {
        throw Error::bad_input(where, fmt::format("'{}': expected true or false", name));
    }
    return value.get<bool>();
}

std::vector<BufferRecord> parse_buffers(const std::string& where, const json& stage,
                                        const char* name) {
    std::vector<BufferRecord> buffers;
    for (const json& buffer : array_member(where, stage, name)) {
        buffers.push_back(
            parse_buffer(fmt::format("{}, {}[{}]", where, name, buffers.size()), buffer));
    }
    return buffers;
}

StageRecord parse_stage(const std::string& file, std::size_t index, const json& object) {
    StageRecord stage;
    const std::string number = fmt::format("{}: stages[{}]", file, index);
    stage.name = text_member(number, object, "name");
    const std::string where = fmt::format("{} ({})", number, stage.name);
    stage.kind = value_of<StageKind>(where, "kind", text_member(where, object, "kind"), kKinds);
    stage.launch = number_member(where, object, "launch");
    stage.batch = number_member(where, object, "batch");
    stage.bounce = place_member(where, object, "bounce");
    stage.light = place_member(where, object, "light");
    stage.level = place_member(where, object, "level");
    stage.blocks = number_member(where, object, "blocks");
    stage.threads = number_member(where, object, "threads");
    stage.inputs = parse_buffers(where, object, "inputs");
    stage.outputs = parse_buffers(where, object, "outputs");
    return stage;
}

const BufferRecord* find_in(const std::vector<BufferRecord>& buffers, std::string_view name) {
    for (const BufferRecord& buffer : buffers) {
        if (buffer.name == name) return &buffer;
    }
    return nullptr;
}

}  // namespace

const char* to_string(BufferOrder order) {
    switch (order) {
        case BufferOrder::ordered:
            return "ordered";
        case BufferOrder::queue:
            return "queue";
        case BufferOrder::hit_list:
            return "hit_list";
        case BufferOrder::set:
            return "set";
    }
    return "(invalid)";
}

const BufferRecord* StageRecord::input(std::string_view buffer) const {
    return find_in(inputs, buffer);
}
const BufferRecord* StageRecord::output(std::string_view buffer) const {
    return find_in(outputs, buffer);
}

capture::StoredBuffer layout_buffer(const BufferRecord& buffer) {
    return {buffer.name,    layout_type(buffer.type), buffer.shape,
            buffer.meaning, to_string(buffer.order),  buffer.file,
            buffer.hash,    buffer.canonical_hash};
}

std::string text_of(const CaptureIndex& index) {
    capture::Index out = layout_header(index.header);
    const auto buffers_of = [](const std::vector<BufferRecord>& records) {
        std::vector<capture::StoredBuffer> buffers;
        buffers.reserve(records.size());
        for (const BufferRecord& record : records) buffers.push_back(layout_buffer(record));
        return buffers;
    };
    for (const StageRecord& stage : index.stages) {
        out.stages.push_back({stage.name, reference::to_string(stage.kind), stage.launch,
                              stage.batch, stage.bounce, stage.light, stage.level, stage.blocks,
                              stage.threads, buffers_of(stage.inputs), buffers_of(stage.outputs)});
    }
    return capture::text_of(out);
}

capture::Index layout_header(const CaptureHeader& header) {
    capture::Index out;
    out.backend = header.backend;
    const ordered_json parameters = to_json(header.parameters);
    for (const auto& [name, value] : parameters.items()) {
        out.parameters.emplace_back(name, value.dump());
    }
    out.scene = header.scene_name;
    out.source = header.scene_source;
    out.scene_fingerprint = hex_text(header.scene_fingerprint);
    out.bvh_fingerprint = hex_text(header.bvh_fingerprint);
    out.width = header.bvh_width;
    out.levels = header.bvh_levels;
    out.several_batches = header.several_batches;
    out.patterns = header.patterns;
    return out;
}

CaptureIndex parse_index(const std::filesystem::path& file, const json& object) {
    expect_format(file, object, kCaptureFormat);
    const std::string where = file.string();
    CaptureIndex index;
    CaptureHeader& header = index.header;
    header.backend = text_member(where, object, "backend");
    header.foreign = object.contains("foreign");
    if (header.foreign) {
        header.culls = boolean_member(where + ": foreign", object["foreign"], "culls");
    }
    header.parameters = parse_parameters(where + ": parameters",
                                         member(where, object, "parameters"), header.foreign);
    const json& scene = member(where, object, "scene");
    header.scene_name = text_member(where + ": scene", scene, "name");
    header.scene_source = text_member(where + ": scene", scene, "source");
    header.scene_fingerprint = fingerprint_member(where + ": scene", scene).value_or(0);
    const json& bvh = member(where, object, "bvh");
    header.bvh_fingerprint = fingerprint_member(where + ": bvh", bvh).value_or(0);
    header.bvh_width = static_cast<int>(unsigned_member(where + ": bvh", bvh, "width", 16));
    header.bvh_levels = number_member(where + ": bvh", bvh, "levels");
    header.several_batches = boolean_member(where, object, "several_batches");
    for (const json& pattern : array_member(where, object, "patterns")) {
        if (!pattern.is_string()) throw Error::bad_input(where, "'patterns': expected text");
        header.patterns.push_back(pattern.get<std::string>());
    }
    std::set<std::string> names;
    for (const json& stage : array_member(where, object, "stages")) {
        index.stages.push_back(parse_stage(where, index.stages.size(), stage));
        if (!names.insert(index.stages.back().name).second) {
            throw Error::bad_input(
                where, fmt::format("the stage {} is there twice", index.stages.back().name));
        }
    }
    return index;
}

}  // namespace scotty::verify
