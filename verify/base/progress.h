/// A line on the terminal that says what a long run is doing; nothing where stderr is
/// no terminal, or with -q.
#pragma once

#include <chrono>
#include <string>

namespace scotty::verify {

/// "12 s", "3 min 05 s", "1 h 02 min".
std::string short_duration(double seconds);

class Progress {
 public:
    Progress();
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Rewrites the line, cut to the terminal's width as it is then, at most ten times a second,
    /// and not within the first second.
    void show(const std::string& text);
    /// Removes the line, so that something else can be printed.
    void clear();

 private:
    bool terminal_;
    bool shown_ = false;
    std::chrono::steady_clock::time_point started_, last_;
};

}  // namespace scotty::verify
