/// A run that ends the process is a verdict too: what was under way is said, with the commands that
/// show it again, and the process ends as one whose verification has failed.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace scotty::verify {

/// From now on a bad address, an arithmetic fault, an illegal instruction and abort() are such a
/// verdict, on standard error. What others have installed for a signal (sanitizers, debuggers, test
/// frameworks) stays, and takes precedence. Kernels of the back end simt that reach memory which is
/// not there are still ended by the executor, without the process.
void catch_crashes();

/// From now on it is such a verdict, too, that nothing has ended for so long: no launch, no run, no
/// oracle. The last call counts; zero: patience without end, as before the first.
void catch_hangs(std::chrono::milliseconds patience);
/// Something has ended.
void note_progress();

/// Something that may crash, for as long as this lives. Any number may be under way, on any
/// threads; the first 64 are named.
class UnderWay {
 public:
    /// `what` in words, and the command that does it again.
    UnderWay(const std::string& what, const std::string& command);
    ~UnderWay();
    UnderWay(const UnderWay&) = delete;
    UnderWay& operator=(const UnderWay&) = delete;

 private:
    std::string text_;
    std::size_t slot_;
};

}  // namespace scotty::verify
