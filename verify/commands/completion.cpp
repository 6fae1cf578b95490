#include "verify/commands/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "reference/base/error.h"
#include "verify/commands/help.h"

namespace scotty::verify {

namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands(nullptr);
}

/// A command and what it inherits, with the choices that some options have.
struct CommandWords {
    std::string path;  ///< "golden check"
    std::string help;
    std::vector<const CLI::App*> subs;
    std::vector<OptionWords> options;
    bool takes_scenes = false;
};

/// The command, its subcommands, theirs, and so on.
void collect(const CLI::App& command, const std::string& path, std::vector<CommandWords>& all) {
    CommandWords words{path, command.get_description(), commands_of(command), {}, false};
    for (const CLI::App* app = &command; app != nullptr; app = app->get_parent()) {
        for (const CLI::Option* option : options_of(*app, false)) {
            if (app != &command && option == app->get_help_ptr()) continue;
            words.options.push_back(words_of(*option));
        }
    }
    for (const CLI::Option* option : options_of(command, true)) {
        words.takes_scenes |= option->get_name(true).starts_with("scene");
    }
    all.push_back(std::move(words));
    for (const CLI::App* sub : commands_of(command)) {
        collect(*sub, path.empty() ? sub->get_name() : path + " " + sub->get_name(), all);
    }
}

std::vector<std::string> names_of(const CommandWords& command) {
    std::vector<std::string> names;
    for (const CLI::App* sub : command.subs) names.push_back(sub->get_name());
    for (const OptionWords& option : command.options) {
        names.insert(names.end(), option.names.begin(), option.names.end());
    }
    return names;
}

/// `case` branches "PATH) ACTION ;;".
template <class Text>
std::string branches(const std::vector<CommandWords>& all, const Text& text) {
    std::string out;
    for (const CommandWords& command : all) {
        const std::string line = text(command);
        if (!line.empty()) out += fmt::format("        '{}') {} ;;\n", command.path, line);
    }
    return out;
}

std::string bash(const std::vector<CommandWords>& all, const std::vector<std::string>& scenes) {
    std::string choices;
    for (const CommandWords& command : all) {
        for (const OptionWords& option : command.options) {
            const auto words = option.choices();
            if (words.empty()) continue;
            for (const std::string& name : option.names) {
                choices += fmt::format("        '{} {}') words='{}' ;;\n", command.path, name,
                                       fmt::join(words, " "));
            }
        }
    }
    const std::string paths = branches(all, [](const CommandWords& command) {
        return command.path.empty() ? std::string() : std::string("path=$next");
    });
    const std::string words = branches(all, [&](const CommandWords& command) {
        std::string text = fmt::format("words='{}'", fmt::join(names_of(command), " "));
        if (command.takes_scenes) text += fmt::format("; scenes='{}'", fmt::join(scenes, " "));
        return text;
    });
    return "# Completion of scotty for bash, made by: scotty completion bash\n"
           "_scotty() {\n"
           "    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}\n"
           "    local path= next= words= scenes= i\n"
           "    for ((i = 1; i < COMP_CWORD; ++i)); do\n"
           "        next=${path:+$path }${COMP_WORDS[i]}\n"
           "        case $next in\n" +
           paths +
           "        esac\n    done\n"
           "    case \"$path $previous\" in\n" +
           choices +
           "    esac\n"
           "    if [[ -z $words ]]; then\n        case $path in\n" +
           words +
           "        esac\n    fi\n"
           "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
           "    if [[ $current != -* ]]; then\n"
           "        local found\n"
           "        mapfile -t found < <(compgen -W \"$scenes\" -- \"$current\"; compgen -f -- "
           "\"$current\")\n"
           "        [[ -n $path ]] && COMPREPLY+=(\"${found[@]}\")\n"
           "    fi\n"
           "}\n"
           "complete -o filenames -F _scotty scotty\n";
}

/// In single quotes, as zsh and fish take them.
std::string in_quotes(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

/// zsh reads bash's completions: one table, one script.
std::string zsh(const std::vector<CommandWords>& all, const std::vector<std::string>& scenes) {
    return "#compdef scotty\nautoload -U +X bashcompinit && bashcompinit\n" + bash(all, scenes);
}

std::string fish(const std::vector<CommandWords>& all, const std::vector<std::string>& scenes) {
    std::string out = "# Completion of scotty for fish, made by: scotty completion fish\n";
    for (const CommandWords& command : all) {
        std::string condition = "__fish_use_subcommand";
        if (!command.path.empty()) {
            std::istringstream path(command.path);
            condition.clear();
            for (std::string word; path >> word;) {
                condition += (condition.empty() ? "" : "; and ");
                condition += "__fish_seen_subcommand_from " + word;
            }
        }
        const std::string begin = "complete -c scotty -n " + in_quotes(condition);
        for (const CLI::App* sub : command.subs) {
            out += fmt::format("{} -f -a {} -d {}\n", begin, sub->get_name(),
                               in_quotes(sub->get_description()));
        }
        if (command.takes_scenes) {
            out += fmt::format("{} -a {}\n", begin,
                               in_quotes(fmt::format("{}", fmt::join(scenes, " "))));
        }
        for (const OptionWords& option : command.options) {
            out += begin;
            for (const std::string& name : option.names) {
                out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            }
            if (!option.value.empty()) out += " -r";
            const auto words = option.choices();
            if (!words.empty()) {
                out += " -f -a " + in_quotes(fmt::format("{}", fmt::join(words, " ")));
            }
            out += " -d " + in_quotes(option.help) + "\n";
        }
    }
    return out;
}

/// Text as a man page takes it: a dot or quote at the start of a line and backslashes mean
/// something.
std::string roff(const std::string& text) {
    std::string out;
    bool begins = true;
    for (const char c : text) {
        if (begins && (c == '.' || c == '\'')) out += "\\&";
        begins = c == '\n';
        if (c == '\\') {
            out += "\\e";
        } else if (c == '-') {
            out += "\\-";
        } else {
            out += c;
        }
    }
    return out;
}

std::string roff_options(const CLI::App& command, bool positional) {
    std::string out;
    for (const CLI::Option* option : options_of(command, positional)) {
        const OptionWords words = words_of(*option);
        std::string value = positional || words.value.empty() ? "" : " " + words.value;
        if (words.many) value += " ...";
        out += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n",
                           roff(fmt::format("{}", fmt::join(words.names, ", "))), roff(value),
                           roff(words.help.empty() ? "(see above)" : words.help));
    }
    return out;
}

void roff_command(const CLI::App& command, const std::string& path, std::string& out) {
    out += fmt::format(".SH {}\n{}\n", roff(path), roff(command.get_description()));
    out += roff_options(command, true) + roff_options(command, false);
    if (!command.get_footer().empty()) {
        out += ".PP\n.nf\n" + roff(command.get_footer()) + "\n.fi\n";
    }
    for (const CLI::App* sub : commands_of(command)) {
        roff_command(*sub, path + " " + sub->get_name(), out);
    }
}

}  // namespace

std::string completion(const CLI::App& app, const std::string& shell,
                       const std::vector<std::string>& scenes) {
    std::vector<CommandWords> all;
    collect(app, "", all);
    if (shell == "bash") return bash(all, scenes);
    if (shell == "zsh") return zsh(all, scenes);
    if (shell == "fish") return fish(all, scenes);
    throw reference::Error::bad_input("completion",
                                      fmt::format("expected bash, zsh or fish, found '{}'", shell));
}

std::string manual_page(const CLI::App& app, const std::string& version) {
    std::string out = fmt::format(
        ".TH SCOTTY 1 \"\" \"CUDA\\-Scotty {}\" \"User Commands\"\n.SH NAME\nscotty \\- {}\n"
        ".SH SYNOPSIS\n.B scotty\n[\\fIOPTION\\fR...] \\fICOMMAND\\fR [\\fIARGUMENT\\fR...]\n"
        ".SH OPTIONS\n",
        version, roff(app.get_description()));
    out += roff_options(app, false);
    out += ".SH COMMANDS\n";
    for (const CLI::App* sub : commands_of(app)) {
        out += fmt::format(".TP\n.B {}\n{}\n", sub->get_name(), roff(sub->get_description()));
    }
    for (const CLI::App* sub : commands_of(app)) {
        roff_command(*sub, "scotty " + sub->get_name(), out);
    }
    return out + ".SH EXIT STATUS AND EXAMPLES\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
}

}  // namespace scotty::verify
