#include "verify/capture/capture_writer.h"

#include <algorithm>
#include <set>
#include <utility>

#include "verify/capture/canonical.h"
#include "verify/capture/failure.h"
#include "verify/capture/layout.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using reference::BufferView;
using reference::StageKind;
using reference::StageView;
namespace fs = std::filesystem;

CaptureWriter::CaptureWriter(const fs::path& directory, CaptureHeader header,
                             std::vector<std::string> patterns)
    : target_(directory),
      directory_(as_bad_input([&] { return std::make_unique<capture::Directory>(directory); })) {
    index_.header = std::move(header);
    index_.header.patterns = std::move(patterns);
    fs::create_directories(directory_->path() / "buffers");
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
    record.file = capture::file_of(layout_buffer(record));
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
    const fs::path file = directory_->path() / name;
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
    for (const auto& entry : fs::directory_iterator(directory_->path() / "buffers")) {
        if (!used.contains("buffers/" + entry.path().filename().string())) {
            fs::remove(entry.path());
        }
    }
}

void CaptureWriter::finish() {
    remove_unreferenced();
    as_bad_input([&] {
        capture::write_file(directory_->path() / kIndexFile, text_of(index_));
        directory_->finish();
    });
}

Capture CaptureWriter::finish_here() {
    as_bad_input([&] { directory_->finish(); });
    return {target_, std::move(index_), std::move(kept_)};
}

}  // namespace scotty::verify
