/// Commands of this program in processes of their own, beside a view.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace scotty::verify {

struct JobResult {
    int exit_code = 0;     ///< of the first command that failed, else of the last
    int signal = 0;        ///< that ended it; 0: none
    bool stopped = false;  ///< by stop()
    std::string output;    ///< of both streams of all commands, in order; at most its last 64 KiB
};

/// Runs command lines one after the other ("verify", "coil", ...; without the program's name) until
/// one fails with a code above 1. `done` is called once, by a thread of this object.
class Job {
 public:
    Job(std::vector<std::vector<std::string>> commands, const std::filesystem::path& folder,
        std::function<void(const JobResult&)> done);
    /// Ends what runs, and waits for it.
    ~Job();
    Job(const Job&) = delete;
    Job& operator=(const Job&) = delete;

    void stop() { stop_ = true; }
    /// Set before `done` is called.
    bool is_done() const { return is_done_; }

 private:
    void run(const std::vector<std::vector<std::string>>& commands);
    int run_one(const std::vector<std::string>& words, JobResult& result) const;

    std::filesystem::path output_;
    std::function<void(const JobResult&)> done_;
    std::atomic<bool> stop_{false}, is_done_{false};
    std::thread thread_;
};

}  // namespace scotty::verify
