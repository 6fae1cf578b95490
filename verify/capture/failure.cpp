#include "verify/capture/failure.h"

#include <fmt/format.h>

#include <string_view>

namespace scotty::verify {
namespace {

using reference::kNotApplicable;

/// Whole-string match of * and ?; backtracks to the last star only, so it is linear in practice.
bool glob(std::string_view pattern, std::string_view text) {
    std::size_t p = 0;
    std::size_t t = 0;
    std::size_t star = std::string_view::npos;
    std::size_t resume = 0;
    while (t < text.size()) {
        if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
            ++p;
            ++t;
        } else if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            resume = t;
        } else if (star != std::string_view::npos) {
            p = star + 1;
            t = ++resume;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

}  // namespace

std::string exact(float value) { return fmt::format("{:a} ({:g})", value, value); }

std::string exact(const reference::Vec3& value) {
    return fmt::format("({}, {}, {})", exact(value.x), exact(value.y), exact(value.z));
}

std::string exact(const reference::Hit& hit) {
    if (!reference::is_hit(hit)) return "no hit";
    return fmt::format("primitive {} at t {}, u {}, v {}", hit.primitive, exact(hit.t),
                       exact(hit.u), exact(hit.v));
}

std::string exact(const reference::Ray& ray) {
    return fmt::format("origin {}, direction {}, t in [{}, {})", exact(ray.origin),
                       exact(ray.direction), exact(ray.t_min), exact(ray.t_max));
}

std::string to_string(const Failure& failure) {
    std::string place;
    if (failure.launch != kNotApplicable) place += fmt::format("launch {} ", failure.launch);
    place += failure.stage;
    if (failure.node != kNotApplicable) place += fmt::format(", node {}", failure.node);
    if (failure.block != kNotApplicable) place += fmt::format(", block {}", failure.block);
    if (failure.thread != kNotApplicable) place += fmt::format(", thread {}", failure.thread);
    if (failure.ray != kNotApplicable) place += fmt::format(", ray {}", failure.ray);
    std::string values;
    if (!failure.expected.empty() || !failure.found.empty()) {
        values = fmt::format(" ({}: expected {}, found {})",
                             failure.field.empty() ? "value" : failure.field, failure.expected,
                             failure.found);
    }
    if (!failure.written_by.empty()) values += "; written by " + failure.written_by;
    return fmt::format("[{}] {}: {}{}", failure.invariant, place, failure.sentence, values);
}

bool stage_matches(const std::string& pattern, const std::string& name) {
    if (pattern.empty()) return true;
    if (pattern.find_first_of("*?") == std::string::npos) {
        return name.find(pattern) != std::string::npos;
    }
    return glob(pattern, name);
}

}  // namespace scotty::verify
