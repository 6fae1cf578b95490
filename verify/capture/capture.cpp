#include "verify/capture/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/failure.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using reference::Error;
using reference::OwnedBuffer;

void LoadedStage::add_input(OwnedBuffer buffer) {
    view.inputs.push_back(buffers.emplace_back(std::move(buffer)).view());
}
void LoadedStage::add_output(OwnedBuffer buffer) {
    view.outputs.push_back(buffers.emplace_back(std::move(buffer)).view());
}

Capture Capture::open(const std::filesystem::path& directory) {
    std::error_code error;
    if (!std::filesystem::is_directory(directory, error)) {
        throw Error::bad_input(directory.string(),
                               "expected a capture, which is a directory; there is none (make one "
                               "with: scotty capture SCENE -o DIR)");
    }
    const std::filesystem::path index = directory / kIndexFile;
    if (!std::filesystem::exists(index, error)) {
        throw Error::bad_input(directory.string(),
                               fmt::format("expected a capture, but it holds no {}", kIndexFile));
    }
    Capture capture;
    capture.directory_ = directory;
    capture.index_ = parse_index(index, read_json(index));
    return capture;
}

Capture::Capture(std::filesystem::path directory, CaptureIndex index, KeptBuffers kept)
    : directory_(std::move(directory)),
      index_(std::move(index)),
      kept_(std::make_shared<const KeptBuffers>(std::move(kept))) {}

const StageRecord* Capture::find(std::string_view name) const {
    for (const StageRecord& stage : index_.stages) {
        if (stage.name == name) return &stage;
    }
    return nullptr;
}

bool Capture::has_buffers() const {
    if (kept_) return true;
    std::error_code error;
    return std::filesystem::is_directory(directory_ / "buffers", error);
}

bool Capture::covers(std::string_view name) const {
    const auto& patterns = index_.header.patterns;
    return patterns.empty() ||
           std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
               return stage_matches(pattern, std::string(name));
           });
}

OwnedBuffer Capture::load(const StageRecord& stage, const BufferRecord& buffer) const {
    if (kept_) {
        const auto kept = kept_->find(buffer.file);
        if (kept != kept_->end()) {
            return {buffer.name, buffer.type, buffer.shape, buffer.meaning, kept->second};
        }
    }
    const std::filesystem::path file = directory_ / buffer.file;
    const std::string whose = fmt::format("{} of {}", buffer.name, stage.name);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
        throw Error::bad_input(
            file.string(), fmt::format("the file is missing; the index names it for {}", whose));
    }
    NpyArray array = read_npy(file);
    if (array.type != buffer.type || array.shape != buffer.shape) {
        throw Error::bad_input(
            file.string(), fmt::format("expected {} {} for {}, found {} {}", to_string(buffer.type),
                                       shape_text(buffer.shape), whose, to_string(array.type),
                                       shape_text(array.shape)));
    }
    const std::string hash = hash_text(array.bytes.data(), array.bytes.size());
    if (hash != buffer.hash) {
        throw Error::bad_input(file.string(),
                               fmt::format("expected bytes of hash {} for {}, found {}; the file "
                                           "has been changed",
                                           buffer.hash, whose, hash));
    }
    return {buffer.name, buffer.type, buffer.shape, buffer.meaning, std::move(array.bytes)};
}

LoadedStage Capture::load(const StageRecord& stage) const {
    LoadedStage loaded;
    loaded.view = bare_view(stage);
    for (const BufferRecord& buffer : stage.inputs) loaded.add_input(load(stage, buffer));
    for (const BufferRecord& buffer : stage.outputs) loaded.add_output(load(stage, buffer));
    return loaded;
}

void expect_own(const Capture& capture) {
    if (!capture.header().foreign) return;
    throw Error::bad_input(capture.directory().string(),
                           fmt::format("holds the run of another program, which is judged by: "
                                       "scotty diff {}",
                                       capture.directory().string()));
}

reference::StageView bare_view(const StageRecord& stage) {
    reference::StageView view;
    view.name = stage.name;
    view.kind = stage.kind;
    view.launch = stage.launch;
    view.batch = stage.batch;
    view.bounce = stage.bounce;
    view.light = stage.light;
    view.level = stage.level;
    view.blocks = stage.blocks;
    view.threads = stage.threads;
    return view;
}

}  // namespace scotty::verify
