/// Folders for a while, which go even where a signal ends the program.
#pragma once

#include <filesystem>

namespace scotty::verify {

/// A name in the system's temporary folder that nobody else has; what lies there, if anything was
/// put there, goes with this object, or when SIGINT or SIGTERM ends the program. At most 64 at once
/// are seen to by signals.
class ScratchFolder {
 public:
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
    int slot_ = -1;
};

/// From now on SIGINT and SIGTERM remove what there is of these before they end the program, unless
/// somebody has asked for them or they are ignored (nohup).
void remove_scratch_folders_on_signals();

}  // namespace scotty::verify
