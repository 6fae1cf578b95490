/// JSON that other people may have written: read with messages that name file and element.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
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

/// A parameter that we do not know may change what the numbers mean.
void expect_known(const std::string& where, const json& object) {
    for (const auto& item : object.items()) {
        const bool known = std::any_of(
            reference::kParameters.begin(), reference::kParameters.end(),
            [&](const reference::ParameterInfo& info) { return info.name == item.key(); });
        if (known) continue;
        throw Error::bad_input(
            where, fmt::format("the parameter '{}' is not known here; the file was written by "
                               "another version",
                               item.key()));
    }
}

}  // namespace

ordered_json to_json(const PipelineParameters& parameters) {
    ordered_json out = ordered_json::object();
    for (const reference::ParameterInfo& info : reference::kParameters) {
        const std::uint64_t value = info.get(parameters);
        if (info.added_later && value == 0) continue;
        ordered_json& member = out[std::string(info.name)];
        if (info.words.empty()) {
            member = value;
        } else {
            member = text_of(info, parameters);
        }
    }
    return out;
}

PipelineParameters parse_parameters(const std::string& where, const json& object, bool some) {
    PipelineParameters parameters;
    for (const reference::ParameterInfo& info : reference::kParameters) {
        const std::string name(info.name);
        if ((some || info.added_later) && !object.contains(name)) continue;
        const std::string text =
            info.words.empty()
                ? std::to_string(unsigned_member(where, object, name.c_str(), ~std::uint64_t{0}))
                : text_member(where, object, name.c_str());
        try {
            set_from_text(info, parameters, text);
        } catch (const Error& error) {
            throw Error::bad_input(where, error.what());
        }
    }
    expect_known(where, object);
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

std::optional<std::uint64_t> fingerprint_member(const std::string& where, const json& object) {
    if (member(where, object, "fingerprint").is_null()) return std::nullopt;
    return hex_member(where, object, "fingerprint");
}

}  // namespace scotty::verify
