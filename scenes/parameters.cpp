#include "scenes/parameters.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "reference/base/assert.h"
#include "reference/base/error.h"

namespace scotty::scenes {

using reference::Error;

namespace {

std::string describe(const std::vector<ParameterRange>& known) {
    if (known.empty()) return "it has no parameters";
    std::string text = "it has";
    const char* separator = " ";
    for (const auto& range : known) {
        text += fmt::format("{}{} ({} to {}{}, {} if not given)", separator, range.name, range.low,
                            range.high, range.integer ? ", whole" : "", range.standard);
        separator = ", ";
    }
    return text;
}

}  // namespace

Parameters::Parameters(std::string scene, const std::string& text,
                       std::vector<ParameterRange> known)
    : scene_(std::move(scene)), known_(std::move(known)), given_(known_.size(), false) {
    for (const auto& range : known_) values_.push_back(range.standard);
    if (text.empty()) return;
    std::size_t begin = 0;
    while (begin <= text.size()) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        set(text.substr(begin, end - begin));
        begin = end + 1;
    }
}

void Parameters::set(const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
        throw Error::bad_input(
            "scene " + scene_,
            fmt::format("'{}' is not of the form key=value; {}", assignment, describe(known_)));
    }
    const std::string name = assignment.substr(0, equals);
    const std::size_t index = index_of(name);
    if (index == known_.size()) {
        throw Error::bad_input("scene " + scene_,
                               fmt::format("no parameter '{}'; {}", name, describe(known_)));
    }
    const ParameterRange& range = known_[index];
    if (given_[index]) {
        throw Error::bad_input("scene " + scene_, fmt::format("'{}' is given twice", name));
    }
    const char* first = assignment.data() + equals + 1;
    const char* last = assignment.data() + assignment.size();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(first, last, value);
    const bool is_number = error == std::errc() && stop == last && std::isfinite(value);
    if (!is_number || value < range.low || value > range.high ||
        (range.integer && value != std::floor(value))) {
        throw Error::bad_input(
            "scene " + scene_,
            fmt::format("{}: expected {} from {} to {}", assignment,
                        range.integer ? "a whole number" : "a number", range.low, range.high));
    }
    values_[index] = value;
    given_[index] = true;
}

std::size_t Parameters::index_of(const std::string& name) const {
    std::size_t index = 0;
    while (index < known_.size() && known_[index].name != name) ++index;
    return index;
}

double Parameters::number(const std::string& name) const {
    const std::size_t index = index_of(name);
    SCOTTY_ASSERT(index, <, known_.size());
    return values_[index];
}

std::uint32_t Parameters::integer(const std::string& name) const {
    return static_cast<std::uint32_t>(number(name));
}

std::string standard_text(const std::vector<ParameterRange>& known) {
    std::string text;
    for (const auto& range : known) {
        text += fmt::format("{}{}={}", text.empty() ? "" : ",", range.name, range.standard);
    }
    return text;
}

}  // namespace scotty::scenes
