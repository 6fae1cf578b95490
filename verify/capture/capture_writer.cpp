#include "verify/capture/capture_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "verify/capture/canonical.h"
#include "verify/capture/failure.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using reference::BufferView;
using reference::Error;
using reference::StageKind;
using reference::StageView;
namespace fs = std::filesystem;

namespace {

/// Beside the target, so that a rename is enough.
fs::path sibling(const fs::path& target, const char* what) {
    return target.parent_path() /
           fmt::format(".{}.{}-{}", target.filename().string(), what, ::getpid());
}

/// "a/b/" is "a/b".
fs::path without_slash(const fs::path& path) {
    fs::path clean = fs::absolute(path).lexically_normal();
    return clean.has_filename() ? clean : clean.parent_path();
}

bool is_capture(const fs::path& directory) {
    try {
        const fs::path index = directory / kIndexFile;
        if (!fs::exists(index)) return false;
        const nlohmann::json json = read_json(index);
        return json.is_object() && json.value("format", nlohmann::json()) == kCaptureFormat;
    } catch (const Error&) {
        return false;
    }
}

}  // namespace

ReplacedDirectory::ReplacedDirectory(const fs::path& target)
    : target_(without_slash(target)), partial_(sibling(target_, "partial")) {
    expect_replaceable();
    std::error_code error;
    fs::remove_all(partial_, error);
    if (!fs::create_directories(partial_, error)) {
        throw Error::bad_input(partial_.string(),
                               "the directory cannot be made: " + error.message());
    }
}

ReplacedDirectory::~ReplacedDirectory() {
    std::error_code ignored;
    if (!finished_) fs::remove_all(partial_, ignored);
}

void ReplacedDirectory::expect_replaceable() const {
    std::error_code error;
    if (!fs::exists(target_, error)) return;
    const bool replaceable =
        fs::is_directory(target_, error) && (fs::is_empty(target_, error) || is_capture(target_));
    if (!replaceable) {
        throw Error::bad_input(target_.string(),
                               "exists and is not a capture, so it is not replaced; name another "
                               "directory or remove it");
    }
}

void ReplacedDirectory::finish() {
    expect_replaceable();
    const fs::path old = sibling(target_, "old");
    std::error_code error;
    const bool replaces = fs::exists(target_, error);
    if (replaces) fs::rename(target_, old, error);
    if (!error) fs::rename(partial_, target_, error);
    if (error) {
        throw Error::bad_input(target_.string(),
                               "the finished capture cannot be moved here: " + error.message());
    }
    finished_ = true;
    if (replaces) fs::remove_all(old, error);
}

CaptureWriter::CaptureWriter(const fs::path& directory, CaptureHeader header,
                             std::vector<std::string> patterns)
    : target_(directory), directory_(directory) {
    index_.header = std::move(header);
    index_.header.patterns = std::move(patterns);
    fs::create_directories(directory_.path() / "buffers");
}

void CaptureWriter::on_stage(const StageView& stage) {
    const auto& patterns = index_.header.patterns;
    if (stage.name.starts_with("batch")) index_.header.several_batches = true;
    if (!patterns.empty() &&
        std::none_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
            return stage_matches(pattern, stage.name);
        })) {
        return;
    }
    StageRecord record;
    record.name = stage.name;
    record.kind = stage.kind;
    record.launch = stage.launch;
    record.batch = stage.batch;
    record.bounce = stage.bounce;
    record.light = stage.light;
    record.level = stage.level;
    record.blocks = stage.blocks;
    record.threads = stage.threads;
    for (const BufferView& buffer : stage.inputs) {
        record.inputs.push_back(store(stage, buffer, false));
    }
    for (const BufferView& buffer : stage.outputs) {
        record.outputs.push_back(store(stage, buffer, true));
    }
    index_.stages.push_back(std::move(record));
}

BufferRecord CaptureWriter::store(const StageView& stage, const BufferView& buffer, bool output) {
    const Regions regions = regions_of(stage, buffer, output);
    // Buffers of fixed order, nearly all, are hashed and written from where they are.
    std::vector<std::byte> cleaned;
    const void* data = buffer.data;
    if (!regions.regions.empty()) {
        cleaned = without_unused(buffer, regions);
        data = cleaned.data();
    }
    BufferRecord record;
    record.name = buffer.name;
    record.type = buffer.type;
    record.shape = buffer.shape;
    record.meaning = buffer.meaning;
    record.order = reference::buffer_info(buffer.name).order;
    record.hash = hash_text(data, buffer.bytes);
    record.canonical_hash = record.hash;
    if (!regions.regions.empty()) {
        const std::vector<std::byte> canonical = canonical_bytes(buffer, regions);
        record.canonical_hash = hash_text(canonical.data(), canonical.size());
    }
    // Equal bytes of another type or shape are another file.
    const std::string address = npy_header(buffer.type, buffer.shape) + record.hash;
    record.file = fmt::format("buffers/{}.npy", hash_text(address.data(), address.size()));
    write(record.file, buffer, data);
    return record;
}

void CaptureWriter::write(const std::string& name, const BufferView& buffer, const void* data) {
    if (kept_.contains(name)) return;
    // An empty buffer needs no memory, but a file where nothing is kept.
    if (memory_left_ != 0 && buffer.bytes <= memory_left_) {
        const auto* first = static_cast<const std::byte*>(data);
        kept_.emplace(name, std::vector<std::byte>(first, first + buffer.bytes));
        memory_left_ -= buffer.bytes;
        return;
    }
    const fs::path file = directory_.path() / name;
    if (!fs::exists(file)) write_npy(file, buffer.type, buffer.shape, data, buffer.bytes);
}

void CaptureWriter::on_retry(std::string_view stage, std::string_view /*reason*/) {
    // "bounce0/merge_intersections": its levels are "bounce0/level...", but not those of
    // "bounce0/light0/...".
    const std::size_t slash = stage.rfind('/');
    const std::string prefix =
        std::string(slash == std::string_view::npos ? "" : stage.substr(0, slash + 1)) + "level";
    auto& stages = index_.stages;
    while (!stages.empty() && is_of_traversal(stages.back().kind) &&
           stages.back().name.starts_with(prefix)) {
        stages.pop_back();
    }
}

void CaptureWriter::remove_unreferenced() const {
    std::set<std::string> used;
    for (const StageRecord& stage : index_.stages) {
        for (const BufferRecord& buffer : stage.inputs) used.insert(buffer.file);
        for (const BufferRecord& buffer : stage.outputs) used.insert(buffer.file);
    }
    for (const auto& entry : fs::directory_iterator(directory_.path() / "buffers")) {
        if (!used.contains("buffers/" + entry.path().filename().string())) {
            fs::remove(entry.path());
        }
    }
}

void CaptureWriter::finish() {
    remove_unreferenced();
    reference::write_file(directory_.path() / kIndexFile, to_json(index_).dump(1) + "\n");
    directory_.finish();
}

Capture CaptureWriter::finish_here() {
    directory_.finish();
    return {target_, std::move(index_), std::move(kept_)};
}

}  // namespace scotty::verify
