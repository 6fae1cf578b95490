/// Writes the stages of a run as they happen.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "reference/contract/stage_observer.h"
#include "verify/capture/capture.h"
#include "verify/capture/capture_format.h"
#include "verify/capture/include/scotty/capture_layout.h"

namespace scotty::verify {

/// Observer that writes every stage shown to it into a capture.
///
/// Buffers go to disk at once, named by their content, so that the output of one stage and the
/// input of the next are one file and nothing piles up in memory, unless that was asked for.
class CaptureWriter : public reference::StageObserver {
 public:
    /// `patterns`: stages whose name matches one of them (stage_matches); none: all.
    /// Throws bad_input where the directory cannot be made or must not be replaced.
    CaptureWriter(const std::filesystem::path& directory, CaptureHeader header,
                  std::vector<std::string> patterns = {});

    /// Buffers stay in memory up to so many bytes, and only the rest goes to disk: for a capture
    /// that nobody keeps. Ends with finish_here().
    void keep_in_memory(std::size_t most_bytes) { memory_left_ = most_bytes; }

    void on_stage(const reference::StageView& stage) override;
    /// What was recorded of the traversal that is run again is dropped.
    void on_retry(std::string_view stage, std::string_view reason) override;

    /// Where write_pipeline_input() puts what makes the capture replayable.
    std::filesystem::path input_folder() const { return directory_->path() / kInputFolder; }
    std::size_t stage_count() const { return index_.stages.size(); }

    /// Writes the index and moves the capture to its place. Nothing is there before.
    void finish();
    /// The same without an index on disk: the capture is this program's alone.
    Capture finish_here();

 private:
    BufferRecord store(const reference::StageView& stage, const reference::BufferView& buffer,
                       bool output);
    void write(const std::string& name, const reference::BufferView& buffer, const void* data);
    void remove_unreferenced() const;

    std::filesystem::path target_;
    std::unique_ptr<capture::Directory> directory_;
    CaptureIndex index_;
    KeptBuffers kept_;
    std::size_t memory_left_ = 0;
};

}  // namespace scotty::verify
