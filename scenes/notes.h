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

    /// `failure` with what was noted before it, which often is the reason: "no triangles (noted
    /// before: a skinned mesh is not supported)". At most kMaxReasons of them.
    std::string explain(const std::string& failure) const {
        if (notes_.empty()) return failure;
        std::string reasons;
        for (std::size_t i = 0; i < notes_.size() && i < kMaxReasons; ++i) {
            reasons += (i == 0 ? "" : "; ") + worded(notes_[i]);
        }
        if (notes_.size() > kMaxReasons) {
            reasons += fmt::format("; and {} more", notes_.size() - kMaxReasons);
        }
        return fmt::format("{} (noted before: {})", failure, reasons);
    }

    /// Appends "sentence" or "sentence (7 times)" for each kind, in the order they first came up.
    void write_to(std::vector<std::string>& warnings) const {
        for (const Note& note : notes_) warnings.push_back(worded(note));
    }

 private:
    using Note = std::pair<std::string, std::size_t>;
    static constexpr std::size_t kMaxReasons = 8;

    static std::string worded(const Note& note) {
        const auto& [text, count] = note;
        return count == 1 ? text : fmt::format("{} ({} times)", text, count);
    }

    std::vector<Note> notes_;
};

}  // namespace scotty::scenes
