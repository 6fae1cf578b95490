#include "verify/commands/help.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <sstream>
#include <utility>

namespace scotty::verify {

namespace {

constexpr std::size_t kColumns = 80;
constexpr std::size_t kHelpColumn = 28;

/// CLI11 appends ":UINT in [0 - 4096]" to the name of a type, which may have colons of its own.
std::pair<std::string, std::string> type_and_range(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos) return {text, ""};
    const std::string type = text.substr(0, colon);
    const std::string check = text.substr(colon + 1);
    if (check == "POSITIVE") return {type, "more than 0"};
    if (check == "NONNEGATIVE") return {type, "0 or more"};
    const std::size_t begin = check.find(" in [");
    const std::size_t dash = check.find(" - ");
    if (begin == std::string::npos || dash == std::string::npos || check.back() != ']') {
        return {text, ""};
    }
    return {type, check.substr(begin + 5, dash - begin - 5) + ".." +
                      check.substr(dash + 3, check.size() - dash - 4)};
}

std::string value_word(const std::string& type) {
    if (type == "UINT" || type == "INT") return "N";
    if (type == "FLOAT") return "X";
    return type;
}

void add_remark(std::string& help, const std::string& remark) {
    help += fmt::format("{}({})", help.empty() ? "" : " ", remark);
}

std::string names_of(const std::set<CLI::Option*>& options) {
    std::vector<std::string> names;
    names.reserve(options.size());
    for (const CLI::Option* option : options) names.push_back(option->get_name());
    std::sort(names.begin(), names.end());
    return fmt::format("{}", fmt::join(names, ", "));
}

class HelpFormatter : public CLI::Formatter {
 public:
    std::string make_option(const CLI::Option* option, bool is_positional) const override {
        const OptionWords words = words_of(*option);
        std::string name = is_positional ? option->get_name(true)
                                         : fmt::format("{}", fmt::join(words.names, ", "));
        if (!words.value.empty() && !is_positional) name += " " + words.value;
        if (words.many) name += " ...";
        return entry(name, words.help);
    }
    std::string make_subcommand(const CLI::App* sub) const override {
        return entry(sub->get_name(), sub->get_description());
    }
    std::string make_description(const CLI::App* app) const override {
        return wrapped(app->get_description(), 0, kColumns) + "\n";
    }
    std::string make_footer(const CLI::App* app) const override {
        return wrapped(app->get_footer(), 0, kColumns) + "\n";
    }

 private:
    static std::string entry(const std::string& name, const std::string& help) {
        std::string line = "  " + name;
        if (help.empty()) return line + "\n";
        if (line.size() + 1 > kHelpColumn) {
            line += "\n" + std::string(kHelpColumn, ' ');
        } else {
            line.resize(kHelpColumn, ' ');
        }
        return line + wrapped(help, kHelpColumn, kColumns) + "\n";
    }
};

std::size_t edits(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

}  // namespace

std::vector<std::string> OptionWords::choices() const {
    std::vector<std::string> words;
    if (value.find('|') == std::string::npos) return words;
    std::istringstream split(value);
    for (std::string word; std::getline(split, word, '|');) words.push_back(word);
    return words;
}

OptionWords words_of(const CLI::Option& option) {
    OptionWords words;
    for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
    if (option.get_positional()) words.names = {option.get_name(true)};
    words.help = option.get_description();
    words.required = option.get_required();
    if (option.get_type_size() != 0) {
        const auto [type, range] = type_and_range(option.get_type_name());
        words.value = value_word(type);
        words.many = option.get_expected_max() == CLI::detail::expected_max_vector_size;
        if (!range.empty()) add_remark(words.help, range);
        const std::string standard = option.get_default_str();
        if (!standard.empty() && words.help.find('[') == std::string::npos) {
            words.help += fmt::format(" [{}]", standard);
        }
    }
    if (words.required) add_remark(words.help, "required");
    if (!option.get_needs().empty()) add_remark(words.help, "with " + names_of(option.get_needs()));
    if (!option.get_excludes().empty()) {
        add_remark(words.help, "not with " + names_of(option.get_excludes()));
    }
    return words;
}

std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional) {
    return command.get_options([&](const CLI::Option* option) {
        return !option->get_group().empty() && option->get_positional() == positional;
    });
}

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
    std::string best;
    std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& one : known) {
        const bool begins = word.size() >= 3 && one.starts_with(word);
        const std::size_t distance = begins ? 1 : edits(word, one);
        if (distance >= least || distance >= one.size()) continue;
        least = distance;
        best = one;
    }
    return best;
}

std::string did_you_mean(const CLI::App& command, const std::string& word) {
    std::vector<std::string> known;
    if (word.starts_with("-")) {
        for (const CLI::App* app = &command; app != nullptr; app = app->get_parent()) {
            for (const CLI::Option* option : options_of(*app, false)) {
                for (const std::string& name : words_of(*option).names) known.push_back(name);
            }
        }
    } else {
        for (const CLI::App* sub : command.get_subcommands(nullptr))
            known.push_back(sub->get_name());
    }
    const std::string meant = nearest(word.substr(0, word.find('=')), known);
    return meant.empty() ? "" : fmt::format("; did you mean {}?", meant);
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns) {
    const std::string margin(indent, ' ');
    std::string out;
    std::istringstream lines(text);
    bool is_first = true;
    for (std::string line; std::getline(lines, line);) {
        if (!is_first) out += "\n" + (line.empty() ? "" : margin);
        is_first = false;
        while (!line.starts_with(' ') && indent + line.size() > columns) {
            std::size_t blank = line.rfind(' ', columns - indent);
            if (blank == std::string::npos) blank = line.find(' ');
            if (blank == std::string::npos) break;
            out += line.substr(0, blank) + "\n" + margin;
            line = line.substr(line.find_first_not_of(' ', blank));
        }
        out += line;
    }
    return out;
}

}  // namespace scotty::verify
