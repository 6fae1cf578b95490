#include "verify/commands/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "scenes/scenes.h"
#include "verify/backends/checked_program.h"
#include "verify/backends/simt/simt_pipeline.h"
#include "verify/base/output_path.h"
#include "verify/capture/ray_file.h"
#include "verify/mutants/plant.h"

namespace scotty::verify {

using reference::Error;
using reference::PipelineParameters;

namespace {

template <class Integer>
Integer parse_integer(const std::string& option, std::string_view text) {
    Integer value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
        throw Error::bad_input(option, fmt::format("expected a number, found '{}'", text));
    }
    return value;
}

/// One option whose text is given to `take`: our own messages say what was expected.
void add_word(CLI::App& command, const std::string& name,
              std::function<void(const std::string&)> take, const std::string& help,
              const std::string& type, const std::string& group) {
    command
        .add_option_function<std::string>(
            name, [take = std::move(take)](const std::string& word) { take(word); }, help)
        ->type_name(type)
        ->group(group);
}

template <class Value, class Parse>
void add_list(CLI::App& command, const std::string& name, std::vector<Value>& values,
              const Parse& parse, const std::string& help, const std::string& type) {
    add_word(
        command, name,
        [&values, parse, name](const std::string& text) {
            for (const std::string& word : split_list(name, text)) values.push_back(parse(word));
        },
        help, type, "Selecting configurations");
}

constexpr const char* kPicture = "Picture";
constexpr const char* kPipeline = "Pipeline";

}  // namespace

std::vector<std::string> split_list(const std::string& option, const std::string& text) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    while (true) {
        const std::size_t comma = text.find(',', begin);
        parts.push_back(text.substr(begin, comma == std::string::npos ? comma : comma - begin));
        if (parts.back().empty()) {
            throw Error::bad_input(option,
                                   fmt::format("expected values between commas, found '{}'", text));
        }
        if (comma == std::string::npos) return parts;
        begin = comma + 1;
    }
}

void parse_size(const std::string& text, PipelineParameters& parameters) {
    const std::size_t cross = text.find('x');
    if (cross == std::string::npos) {
        throw Error::bad_input("--size",
                               fmt::format("expected WIDTHxHEIGHT like 640x480, found '{}'", text));
    }
    parameters.image_width =
        parse_integer<std::uint32_t>("--size", std::string_view(text).substr(0, cross));
    parameters.image_height =
        parse_integer<std::uint32_t>("--size", std::string_view(text).substr(cross + 1));
}

/// The option of a row of the table; the default is the value in `p`, unless it has another name.
void add_parameter(CLI::App& command, PipelineParameters& p, const reference::ParameterInfo& info,
                   const std::string& group, const std::string& standard = {}) {
    const std::string type =
        info.words.empty() ? "N" : fmt::format("{}", fmt::join(info.words, "|"));
    add_word(
        command, std::string(info.option),
        [&p, &info](const std::string& text) {
            try {
                set_from_text(info, p, text);
            } catch (const Error& error) {
                throw Error::bad_input(std::string(info.option), error.what());
            }
        },
        fmt::format("{} [{}]", info.help, standard.empty() ? text_of(info, p) : standard), type,
        group);
}

void add_picture_options(CLI::App& command, PipelineParameters& p) {
    using reference::parameter;
    add_word(
        command, "--size", [&p](const std::string& text) { parse_size(text, p); },
        fmt::format("{} [{}x{}]", parameter("image_width").help, p.image_width, p.image_height),
        "WxH", kPicture);
    for (const auto* info : {&parameter("spp"), &parameter("bounces"), &parameter("light_samples"),
                             &parameter("roulette"), &parameter("seed")}) {
        add_parameter(command, p, *info, kPicture);
    }
    add_parameter(command, p, parameter("max_leaf_size"), kPipeline);
}

void add_pipeline_options(CLI::App& command, PipelineParameters& p,
                          std::span<const std::string_view> of_backend) {
    using reference::parameter;
    for (const auto* info :
         {&parameter("width"), &parameter("rays_per_block"), &parameter("queue_levels"),
          &parameter("queues"), &parameter("early_out"), &parameter("hit_mode"),
          &parameter("block_order"), &parameter("shadow_query"), &parameter("hit_capacity"),
          &parameter("batch_rays")}) {
        const bool depends =
            std::find(of_backend.begin(), of_backend.end(), info->option) != of_backend.end();
        add_parameter(command, p, *info, kPipeline, depends ? "the back end's fastest" : "");
    }
}

void add_pass_option(CLI::App& command, PipelineParameters& p) {
    add_parameter(command, p, reference::parameter("samples_per_pass"), kPipeline);
}

void add_image_filter_options(CLI::App& command, PipelineParameters& p) {
    using reference::parameter;
    for (const auto* info : {&parameter("filter"), &parameter("filter_threshold")}) {
        add_parameter(command, p, *info, kPicture);
    }
}

void add_arithmetic_option(CLI::App& command, PipelineParameters& p) {
    add_parameter(command, p, reference::parameter("arithmetic"), kPipeline);
}

void add_json_option(CLI::App& command, JsonOutput& output) {
    command
        .add_option("--json", output.file,
                    "write the result as JSON, to FILE.json or in place of what is printed")
        ->type_name("[FILE]")
        ->check(output_file());
}

std::vector<std::string> json_words(std::vector<std::string> words) {
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] != "--json") continue;
        const bool named =
            i + 1 < words.size() && (words[i + 1] == "-" || words[i + 1].ends_with(".json"));
        if (!named) words[i] = "--json=-";
    }
    return words;
}

void add_filter_options(CLI::App& command, ConfigurationFilter& filter) {
    const auto integer = [](const char* name) {
        return [name](const std::string& word) { return parse_integer<int>(name, word); };
    };
    const auto count = [](const char* name) {
        return [name](const std::string& word) { return parse_integer<std::uint32_t>(name, word); };
    };
    add_list(command, "--width", filter.widths, integer("--width"), "children a node", "2,4,8,16");
    add_list(command, "--rays-per-block", filter.rays_per_block, integer("--rays-per-block"),
             "threads a block", "32..1024");
    add_list(command, "--queue-levels", filter.queue_levels, count("--queue-levels"),
             "levels that have queues, 0: all", "0,2,...");
    add_list(command, "--queues", filter.queues, reference::parse_queues, "what rays wait in",
             "nodes,pairs");
    add_list(command, "--early-out", filter.early_out, reference::parse_early_out, "culling policy",
             "off,level,immediate");
    add_list(command, "--hit-mode", filter.hit_mode, reference::parse_hit_mode,
             "how hits come together", "buffer,packed");
    add_list(command, "--block-order", filter.block_order, reference::parse_block_order,
             "which rays a block takes", "linear,strided");
    add_list(command, "--shadow-query", filter.shadow_query, reference::parse_shadow_query,
             "what a shadow ray asks for", "any,closest");
    add_list(command, "--hit-capacity", filter.hit_capacity, count("--hit-capacity"),
             "hit slots a ray at first", "1..65536");
    add_list(command, "--batch-rays", filter.batch_rays, count("--batch-rays"),
             "rays in flight at once", "N,...");
    add_list(command, "--samples-per-pass", filter.samples_per_pass, count("--samples-per-pass"),
             "samples that every pixel gets before any gets its next ones, 0: all", "0,N,...");
    add_list(command, "--schedule", filter.schedule, emulation::parse_schedule,
             "order of blocks and threads, on the CPU", "free,linear,...");
    command.add_flag("--all", filter.all, "every combination, not only all pairs of values")
        ->group("Selecting configurations");
}

reference::Scene load_scene_argument(const std::string& scene) {
    return scene.ends_with(".scn") ? read_scene_file(scene) : scenes::load_scene(scene);
}

void add_backend_options(CLI::App& command, BackendChoice& choice, const std::string& help,
                         bool one_configuration) {
    command.add_option("--backend", choice.name, help)->capture_default_str();
    command.add_flag("--check", choice.check,
                     "emulator and simt: watch every load and store of the kernels for races, "
                     "unwritten memory and bounds");
    command
        .add_option("--plant", choice.plant,
                    "with a fault in the kernels: scotty mutants --list has their names")
        ->type_name("NAME");
    if (!one_configuration) return;
    add_word(
        command, "--schedule",
        [&choice](const std::string& word) {
            if (std::filesystem::is_regular_file(word)) {
                choice.interleaving = word;
            } else {
                choice.schedule = emulation::parse_schedule(word);
            }
        },
        "order of blocks and threads, on the CPU: free, linear, reversed, strided, adversarial or "
        "shuffle:SEED",
        "WORD", kPipeline);
}

Backend chosen_backend(const BackendChoice& choice, std::size_t threads,
                       const PipelineParameters& parameters) {
    if (choice.check && choice.name == "cuda") {
        throw Error::bad_input("--check",
                               "needs --backend emulator or simt: what a device touches is not "
                               "watched (compute-sanitizer does that)");
    }
    if (!choice.interleaving.empty()) {
        throw Error::bad_input(
            "--schedule",
            fmt::format("{}: a file is of one launch; scotty replay runs it", choice.interleaving));
    }
    if (!choice.plant.empty()) {
        plant(choice.plant, choice.name);
        simt::watch_memory(choice.check);  // here too it is on by default
    }
    if (choice.check) become_checked_program();
    return backend_named(choice.name, Configuration{parameters, choice.schedule}.device(threads));
}

void add_thread_option(CLI::App& command, std::size_t& threads) {
    command.add_option("--threads", threads, "worker threads; 0: all of the machine")
        ->capture_default_str()
        ->check(CLI::Range(std::size_t{0}, std::size_t{4096}));
}

}  // namespace scotty::verify
