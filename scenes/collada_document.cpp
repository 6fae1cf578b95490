#include "scenes/collada_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "scenes/parse_number.h"

namespace scotty::scenes {

using reference::Error;

namespace {

struct IdCollector : pugi::xml_tree_walker {
    using Elements = std::unordered_map<std::string, std::vector<pugi::xml_node>>;
    explicit IdCollector(Elements& target) : by_id(target) {}
    bool for_each(pugi::xml_node& node) override {
        if (const pugi::xml_attribute id = node.attribute("id")) by_id[id.value()].push_back(node);
        return true;
    }
    Elements& by_id;
};

/// The profiles of the extras that Scotty3D and its relatives write: the same elements.
bool is_scotty3d_profile(const char* profile) {
    return std::strcmp(profile, "CMU462") == 0 || std::strcmp(profile, "CGL") == 0;
}

/// "a%20b" as "a b"; what is no escape stays.
std::string unescaped(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        unsigned code = 0;
        const char* digits = text.data() + i + 1;
        if (text[i] == '%' && i + 2 < text.size() &&
            std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
            out += static_cast<char>(code);
            i += 2;
        } else {
            out += text[i];
        }
    }
    return out;
}

/// "<light id="Area">": the element, or the next one around it that can be told apart.
std::string name_of(pugi::xml_node element) {
    std::string inner;
    while (element) {
        for (const char* attribute : {"id", "name", "sid", "symbol"}) {
            if (!element.attribute(attribute)) continue;
            return fmt::format("<{} {}=\"{}\">{}", element.name(), attribute,
                               element.attribute(attribute).value(), inner);
        }
        inner = fmt::format(" <{}>{}", element.name(), inner);
        element = element.parent();
    }
    return inner.empty() ? "document" : inner.substr(1);
}

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

/// All text of an element. A comment inside makes it more than one piece.
std::string text_of(pugi::xml_node element) {
    std::string text;
    for (const pugi::xml_node child : element.children()) text += child.value();
    return text;
}

/// Calls `use(begin, end, index)` for each word of the element's text.
template <class Use>
void for_each_word(pugi::xml_node element, const Use& use) {
    std::string pieces;
    const char* at = element.first_child().value();
    if (element.first_child() != element.last_child()) {
        pieces = text_of(element);
        at = pieces.c_str();
    }
    for (std::size_t index = 0;; ++index) {
        while (is_space(*at)) ++at;
        if (*at == '\0') return;
        const char* begin = at;
        while (*at != '\0' && !is_space(*at)) ++at;
        use(begin, at, index);
    }
}

}  // namespace

ColladaDocument::ColladaDocument(std::string path) : path_(std::move(path)) {
    const pugi::xml_parse_result result = xml_.load_file(path_.c_str());
    if (!result) {
        throw Error::bad_input(path_, fmt::format("not well-formed XML at byte {} ({}); the file "
                                                  "may be truncated",
                                                  result.offset, result.description()));
    }
    root_ = xml_.document_element();
    if (std::strcmp(root_.name(), "COLLADA") != 0) {
        throw Error::bad_input(
            path_, fmt::format("expected a <COLLADA> document, found <{}>", root_.name()));
    }
    const std::string version = root_.attribute("version").value();
    if (version.starts_with("1.0") || version.starts_with("1.1") || version.starts_with("1.2") ||
        version.starts_with("1.3")) {
        throw Error::bad_input(path_, fmt::format("COLLADA {} is not supported; export the scene "
                                                  "as COLLADA 1.4 or 1.5",
                                                  version));
    }
    IdCollector collector(by_id_);
    xml_.traverse(collector);
}

Error ColladaDocument::error(pugi::xml_node element, const std::string& what) const {
    return Error::bad_input(path_ + ": " + name_of(element), what);
}

bool ColladaDocument::made_for_scotty3d() const {
    for (const auto& found : root_.select_nodes("//*[local-name()='technique']")) {
        if (is_scotty3d_profile(found.node().attribute("profile").value())) return true;
    }
    return false;
}

pugi::xml_node ColladaDocument::target(pugi::xml_node user, const char* attribute,
                                       const char* kind) const {
    const std::string url = user.attribute(attribute).value();
    if (url.size() < 2 || url[0] != '#') {
        throw error(user, fmt::format("{}: expected \"#id\" of a <{}> in this file, found \"{}\"",
                                      attribute, kind, url));
    }
    auto found = by_id_.find(url.substr(1));
    if (found == by_id_.end()) found = by_id_.find(unescaped(url.substr(1)));
    if (found == by_id_.end()) {
        throw error(user,
                    fmt::format("{}: there is no <{} id=\"{}\">", attribute, kind, url.substr(1)));
    }
    // Some exporters give a node and its geometry the same id: the kind tells them apart.
    pugi::xml_node result;
    for (const pugi::xml_node element : found->second) {
        if (std::strcmp(element.name(), kind) != 0) continue;
        if (result) {
            throw error(user, fmt::format("{}: \"{}\" could be any of several <{}> elements of "
                                          "this id; ids must be unique",
                                          attribute, url, kind));
        }
        result = element;
    }
    if (!result) {
        throw error(user, fmt::format("{}: expected a <{}>, \"{}\" is a <{}>", attribute, kind, url,
                                      found->second.front().name()));
    }
    return result;
}

bool ColladaDocument::points_to(pugi::xml_node user, const char* attribute,
                                const char* kind) const {
    const std::string url = user.attribute(attribute).value();
    const auto found = by_id_.find(url.empty() ? url : url.substr(1));
    if (found == by_id_.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(), [&](pugi::xml_node element) {
        return std::strcmp(element.name(), kind) == 0;
    });
}

std::string ColladaDocument::word(pugi::xml_node element, const char* standard) const {
    std::string result = element ? "" : standard;
    for_each_word(element, [&](const char* begin, const char* end, std::size_t index) {
        if (index != 0) result += ' ';
        result.append(begin, end);
    });
    return result;
}

std::vector<double> ColladaDocument::numbers(pugi::xml_node element) const {
    std::vector<double> values;
    for_each_word(element, [&](const char* begin, const char* end, std::size_t index) {
        const std::string_view word(begin, static_cast<std::size_t>(end - begin));
        const std::optional<double> value = parse_finite(word);
        if (!value) {
            throw error(element,
                        fmt::format("value {}: expected a finite number, found '{}'", index, word));
        }
        values.push_back(*value);
    });
    return values;
}

std::vector<double> ColladaDocument::numbers(pugi::xml_node element, std::size_t count) const {
    std::vector<double> values = numbers(element);
    if (values.size() != count) {
        throw error(element, fmt::format("expected {} numbers, found {}", count, values.size()));
    }
    return values;
}

double ColladaDocument::number(pugi::xml_node element, double standard) const {
    return element ? numbers(element, 1)[0] : standard;
}

Point ColladaDocument::colour(pugi::xml_node element) const {
    const std::vector<double> values = numbers(element);
    if (values.size() != 3 && values.size() != 4) {
        throw error(element,
                    fmt::format("expected 3 or 4 numbers (a colour), found {}", values.size()));
    }
    return {values[0], values[1], values[2]};
}

std::vector<std::uint32_t> ColladaDocument::indices(pugi::xml_node element) const {
    std::vector<std::uint32_t> values;
    for_each_word(element, [&](const char* begin, const char* end, std::size_t index) {
        std::uint32_t value = 0;
        const auto [stop, status] = std::from_chars(begin, end, value);
        if (status != std::errc() || stop != end) {
            throw error(element, fmt::format("value {}: expected a whole number from 0 on, found "
                                             "'{}'",
                                             index, std::string(begin, end)));
        }
        values.push_back(value);
    });
    return values;
}

std::uint32_t ColladaDocument::count_attribute(pugi::xml_node element, const char* name,
                                               std::uint32_t standard) const {
    const pugi::xml_attribute attribute = element.attribute(name);
    if (!attribute) return standard;
    const char* text = attribute.value();
    const char* end = text + std::strlen(text);
    std::uint32_t value = 0;
    const auto [stop, status] = std::from_chars(text, end, value);
    if (status != std::errc() || stop != end) {
        throw error(element,
                    fmt::format("{}: expected a whole number from 0 on, found '{}'", name, text));
    }
    return value;
}

pugi::xml_node scotty3d_extra(pugi::xml_node element) {
    for (const pugi::xml_node extra : element.children("extra")) {
        for (const pugi::xml_node technique : extra.children("technique")) {
            if (!is_scotty3d_profile(technique.attribute("profile").value())) continue;
            for (const pugi::xml_node child : technique.children()) {
                if (child.type() == pugi::node_element) return child;
            }
        }
    }
    return {};
}

}  // namespace scotty::scenes
