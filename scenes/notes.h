/// Warnings of a loader: each kind once, with how often it came up.
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace scotty::scenes {

class Notes {
 public:
    /// Counts one more occurrence of `sentence`.
    void add(const std::string& sentence, std::size_t times = 1) {
        if (times == 0) return;
        for (auto& [text, count] : notes_) {
            if (text == sentence) {
                count += times;
                return;
            }
        }
        notes_.emplace_back(sentence, times);
    }

    /// Appends "sentence" or "sentence (7 times)" for each kind, in the order they first came up.
    void write_to(std::vector<std::string>& warnings) const {
        for (const auto& [text, count] : notes_) {
            warnings.push_back(count == 1 ? text : fmt::format("{} ({} times)", text, count));
        }
    }

 private:
    std::vector<std::pair<std::string, std::size_t>> notes_;
};

}  // namespace scotty::scenes
