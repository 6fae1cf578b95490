#include "reference/contract/pipeline_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"

namespace scotty::reference {
namespace {

/// More pixels than this are taken for a slip of the keyboard: the image alone is 3 GiB.
constexpr std::uint64_t kMaxPixels = 1ull << 28;

/// A negative value is printed as it was given.
std::string shown(const ParameterInfo& info, std::uint64_t value) {
    const bool negative = value >> 63 != 0 && info.high < value;
    return negative ? std::to_string(static_cast<std::int64_t>(value)) : std::to_string(value);
}

void expect_valid(const ParameterInfo& info, std::uint64_t value) {
    if (!info.words.empty()) return;
    const bool listed = std::find(info.only.begin(), info.only.end(), value) != info.only.end();
    const bool in_range = info.low <= value && value <= info.high;
    if (info.only.empty() ? in_range && value % info.multiple_of == 0 : listed) return;
    throw Error::bad_input(
        std::string(info.title),
        fmt::format("expected {}, found {}", valid_values(info), shown(info, value)));
}

template <class Enum>
const char* word_of(const ParameterInfo& info, Enum value) {
    const auto index = static_cast<std::size_t>(value);
    return index < info.words.size() ? info.words[index] : "(invalid)";
}

std::uint64_t value_of(const ParameterInfo& info, const std::string& word) {
    for (std::size_t i = 0; i < info.words.size(); ++i) {
        if (word == info.words[i]) return i;
    }
    throw Error::bad_input(std::string(info.title),
                           fmt::format("expected one of {}, found '{}'", valid_values(info), word));
}

std::uint64_t number_of(const ParameterInfo& info, const std::string& text) {
    std::uint64_t value = 0;
    std::int64_t below_zero = 0;
    const bool negative = text.starts_with('-');
    const char* const end = text.data() + text.size();
    const auto [rest, error] = negative ? std::from_chars(text.data(), end, below_zero)
                                        : std::from_chars(text.data(), end, value);
    if (error != std::errc() || rest != end) {
        throw Error::bad_input(
            std::string(info.title),
            fmt::format("expected a number, {}, found '{}'", valid_values(info), text));
    }
    return negative ? static_cast<std::uint64_t>(below_zero) : value;
}

}  // namespace

std::string valid_values(const ParameterInfo& info) {
    if (!info.words.empty()) return fmt::format("{}", fmt::join(info.words, ", "));
    if (!info.only.empty()) {
        return fmt::format("{} or {}", fmt::join(info.only.first(info.only.size() - 1), ", "),
                           info.only.back());
    }
    std::string text = fmt::format("{}..{}", info.low, info.high);
    if (info.multiple_of != 1) text += fmt::format(", a multiple of {}", info.multiple_of);
    if (info.zero_is_all) text += " (0: all)";
    return text;
}

std::string text_of(const ParameterInfo& info, const PipelineParameters& parameters) {
    const std::uint64_t value = info.get(parameters);
    return info.words.empty() ? shown(info, value) : word_of(info, value);
}

void set_from_text(const ParameterInfo& info, PipelineParameters& parameters,
                   const std::string& text) {
    const std::uint64_t value = info.words.empty() ? number_of(info, text) : value_of(info, text);
    expect_valid(info, value);
    info.set(parameters, value);
}

std::string options_of(const PipelineParameters& parameters,
                       std::initializer_list<ParameterGroup> groups) {
    std::string text;
    for (const ParameterInfo& info : kParameters) {
        if (std::find(groups.begin(), groups.end(), info.group) == groups.end()) continue;
        if (info.name == "image_height") continue;  // --size says both
        const std::string value =
            info.name == "image_width"
                ? fmt::format("{}x{}", parameters.image_width, parameters.image_height)
                : text_of(info, parameters);
        text += fmt::format("{}{} {}", text.empty() ? "" : " ", info.option, value);
    }
    return text;
}

void validate(const PipelineParameters& p) {
    for (const ParameterInfo& info : kParameters) {
        expect_valid(info, info.get(p));
        const std::uint64_t pixels = std::uint64_t{p.image_width} * p.image_height;
        if (info.name != "image_height" || pixels <= kMaxPixels) continue;
        throw Error::bad_input(
            "image size", fmt::format("expected at most {} pixels, found {}x{} = {} pixels; render "
                                      "it in parts or smaller",
                                      kMaxPixels, p.image_width, p.image_height, pixels));
    }
}

const char* to_string(QueueKind value) { return word_of(parameter("queues"), value); }
const char* to_string(EarlyOut value) { return word_of(parameter("early_out"), value); }
const char* to_string(BlockOrder value) { return word_of(parameter("block_order"), value); }
const char* to_string(HitMode value) { return word_of(parameter("hit_mode"), value); }
const char* to_string(ShadowQuery value) { return word_of(parameter("shadow_query"), value); }
const char* to_string(Filter value) { return word_of(parameter("filter"), value); }
const char* to_string(Arithmetic value) { return word_of(parameter("arithmetic"), value); }

QueueKind parse_queues(const std::string& word) {
    return static_cast<QueueKind>(value_of(parameter("queues"), word));
}
EarlyOut parse_early_out(const std::string& word) {
    return static_cast<EarlyOut>(value_of(parameter("early_out"), word));
}
BlockOrder parse_block_order(const std::string& word) {
    return static_cast<BlockOrder>(value_of(parameter("block_order"), word));
}
HitMode parse_hit_mode(const std::string& word) {
    return static_cast<HitMode>(value_of(parameter("hit_mode"), word));
}
ShadowQuery parse_shadow_query(const std::string& word) {
    return static_cast<ShadowQuery>(value_of(parameter("shadow_query"), word));
}
Filter parse_filter(const std::string& word) {
    return static_cast<Filter>(value_of(parameter("filter"), word));
}
Arithmetic parse_arithmetic(const std::string& word) {
    return static_cast<Arithmetic>(value_of(parameter("arithmetic"), word));
}

}  // namespace scotty::reference
