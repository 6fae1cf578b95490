/// Reads captures: stages of a run with the buffers that went in and came out.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "reference/contract/owned_buffer.h"
#include "reference/contract/stage_observer.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

/// A stage with memory of its own. Movable: the views stay valid.
struct LoadedStage {
    reference::StageView view;
    std::deque<reference::OwnedBuffer> buffers;  ///< what the view's buffers point into

    void add_input(reference::OwnedBuffer buffer);
    void add_output(reference::OwnedBuffer buffer);
};

/// Bytes of buffers that a run of this program has kept, by the name that their file would have.
using KeptBuffers = std::unordered_map<std::string, std::vector<std::byte>>;

class Capture {
 public:
    /// Throws bad_input naming file and element: no such directory, no capture, another version,
    /// an index that is cut short or not as docs/captures.md says. Buffers are read later.
    static Capture open(const std::filesystem::path& directory);

    /// Of a run of this program, which has kept buffers in memory; what it has not kept is read
    /// from the directory.
    Capture(std::filesystem::path directory, CaptureIndex index, KeptBuffers kept);

    const std::filesystem::path& directory() const { return directory_; }
    const CaptureHeader& header() const { return index_.header; }
    const std::vector<StageRecord>& stages() const { return index_.stages; }
    /// Null where there is no such stage.
    const StageRecord* find(std::string_view name) const;
    /// False where only the index is left: enough to compare by hash.
    bool has_buffers() const;
    /// True where a stage of that name was asked for when the capture was made.
    bool covers(std::string_view name) const;

    /// Throws bad_input naming file, stage and buffer: missing, another type, shape or hash than
    /// the index says.
    reference::OwnedBuffer load(const StageRecord& stage, const BufferRecord& buffer) const;
    /// All buffers of a stage.
    LoadedStage load(const StageRecord& stage) const;

 private:
    Capture() = default;

    std::filesystem::path directory_;
    CaptureIndex index_;
    std::shared_ptr<const KeptBuffers> kept_;  ///< null: all are in files
};

/// Throws bad_input where it is of another program: verify/diff/foreign.h judges those.
void expect_own(const Capture& capture);

/// The record's place and sizes as a view without buffers.
reference::StageView bare_view(const StageRecord& stage);

}  // namespace scotty::verify
