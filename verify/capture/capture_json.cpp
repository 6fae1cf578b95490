/// JSON that other people may have written: read with messages that name file and element.
#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "reference/base/error.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

using nlohmann::json;
using nlohmann::ordered_json;
using reference::Error;
using reference::PipelineParameters;

namespace {

std::string shown(const json& value) {
    std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return text;
}

/// Calls visit(name, field) for every parameter: one list for writing and reading.
template <class Parameters, class Visit>
void for_each_parameter(Parameters& p, Visit&& visit) {
    visit("image_width", p.image_width);
    visit("image_height", p.image_height);
    visit("spp", p.spp);
    visit("bounces", p.bounces);
    visit("light_samples", p.light_samples);
    visit("seed", p.seed);
    visit("width", p.width);
    visit("rays_per_block", p.rays_per_block);
    visit("max_leaf_size", p.max_leaf_size);
    visit("queue_levels", p.queue_levels);
    visit("early_out", p.early_out);
    visit("block_order", p.block_order);
    visit("hit_mode", p.hit_mode);
    visit("shadow_query", p.shadow_query);
    visit("hit_capacity", p.hit_capacity);
    visit("batch_rays", p.batch_rays);
    visit("samples_per_pass", p.samples_per_pass);
    visit("filter", p.filter);
    visit("filter_threshold", p.filter_threshold);
    visit("arithmetic", p.arithmetic);
}

void parse_word(const std::string& word, reference::EarlyOut& value) {
    value = reference::parse_early_out(word);
}
void parse_word(const std::string& word, reference::BlockOrder& value) {
    value = reference::parse_block_order(word);
}
void parse_word(const std::string& word, reference::HitMode& value) {
    value = reference::parse_hit_mode(word);
}
void parse_word(const std::string& word, reference::ShadowQuery& value) {
    value = reference::parse_shadow_query(word);
}
void parse_word(const std::string& word, reference::Filter& value) {
    value = reference::parse_filter(word);
}
void parse_word(const std::string& word, reference::Arithmetic& value) {
    value = reference::parse_arithmetic(word);
}

/// Not in files of before, and left out where it is 0: they stay as they are, byte for byte.
bool was_added_later(std::string_view name) {
    return name == "queue_levels" || name == "samples_per_pass";
}

/// Reads parameters and remembers which members were used.
class ParameterReader {
 public:
    ParameterReader(const std::string& where, const json& object)
        : where_(where), object_(object) {}

    template <class T>
    void operator()(const char* name, T& value) {
        known_.insert(name);
        if (was_added_later(name) && !object_.contains(name)) return;
        if constexpr (std::is_enum_v<T>) {
            try {
                parse_word(text_member(where_, object_, name), value);
            } catch (const Error& error) {
                throw Error::bad_input(where_, error.what());
            }
        } else {
            value = static_cast<T>(unsigned_member(where_, object_, name,
                                                   std::uint64_t{std::numeric_limits<T>::max()}));
        }
    }
    /// A parameter that we do not know may change what the numbers mean.
    void expect_no_others() const {
        for (const auto& item : object_.items()) {
            if (!known_.contains(item.key())) {
                throw Error::bad_input(
                    where_, fmt::format("the parameter '{}' is not known here; the file was "
                                        "written by another version",
                                        item.key()));
            }
        }
    }

 private:
    const std::string& where_;
    const json& object_;
    std::set<std::string> known_;
};

}  // namespace

ordered_json to_json(const PipelineParameters& parameters) {
    ordered_json out = ordered_json::object();
    for_each_parameter(parameters, [&](const char* name, const auto& value) {
        if constexpr (std::is_enum_v<std::decay_t<decltype(value)>>) {
            out[name] = reference::to_string(value);
        } else {
            if (was_added_later(name) && value == 0) return;
            out[name] = value;
        }
    });
    return out;
}

PipelineParameters parse_parameters(const std::string& where, const json& object) {
    PipelineParameters parameters;
    ParameterReader reader(where, object);
    for_each_parameter(parameters, reader);
    reader.expect_no_others();
    try {
        reference::validate(parameters);
    } catch (const Error& error) {
        throw Error::bad_input(where, error.what());
    }
    return parameters;
}

json read_json(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Error::bad_input(file.string(), "cannot be read");
    try {
        return json::parse(in);
    } catch (const json::exception& error) {
        throw Error::bad_input(file.string(),
                               fmt::format("expected JSON; it has been cut short or is another "
                                           "kind of file ({})",
                                           error.what()));
    }
}

void expect_format(const std::filesystem::path& file, const json& object, const char* format,
                   int expected_version) {
    const std::string where = file.string();
    const bool ours = object.is_object() && object.contains("format") &&
                      object["format"].is_string() && object["format"] == format;
    if (!ours) {
        throw Error::bad_input(where, fmt::format("expected \"format\": \"{}\", found {}", format,
                                                  object.is_object() && object.contains("format")
                                                      ? shown(object["format"])
                                                      : std::string("none")));
    }
    const json& version = member(where, object, "version");
    if (!version.is_number_integer() || version != expected_version) {
        throw Error::bad_input(where, fmt::format("expected version {}, found {}; make it again "
                                                  "with this build of scotty",
                                                  expected_version, shown(version)));
    }
}

const json& member(const std::string& where, const json& object, const char* name) {
    if (!object.is_object()) {
        throw Error::bad_input(where, "expected a JSON object, found " + shown(object));
    }
    const auto found = object.find(name);
    if (found == object.end()) {
        throw Error::bad_input(where, fmt::format("'{}' is missing", name));
    }
    return *found;
}

std::uint64_t unsigned_member(const std::string& where, const json& object, const char* name,
                              std::uint64_t most) {
    const json& value = member(where, object, name);
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > most) {
        throw Error::bad_input(where, fmt::format("'{}': expected a whole number from 0 to {}, "
                                                  "found {}",
                                                  name, most, shown(value)));
    }
    return value.get<std::uint64_t>();
}

std::string text_member(const std::string& where, const json& object, const char* name) {
    const json& value = member(where, object, name);
    if (!value.is_string()) {
        throw Error::bad_input(where,
                               fmt::format("'{}': expected text, found {}", name, shown(value)));
    }
    return value.get<std::string>();
}

std::uint64_t hex_member(const std::string& where, const json& object, const char* name) {
    const std::string text = text_member(where, object, name);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
    if (text.size() != 16 || error != std::errc() || end != text.data() + text.size()) {
        throw Error::bad_input(
            where, fmt::format("'{}': expected 16 hexadecimal digits, found '{}'", name, text));
    }
    return value;
}

}  // namespace scotty::verify
