/// Command-line options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "verify/backends/backend.h"
#include "verify/sweep/configurations.h"

namespace scotty::verify {

/// --size, --spp, --bounces, --light-samples, --seed, --leaf-size: what a picture is made of.
void add_picture_options(CLI::App& command, reference::PipelineParameters& parameters);

/// --width, --rays-per-block, --early-out, --hit-mode, --block-order, --shadow-query,
/// --hit-capacity, --batch-rays: how it is traced. One value each. Those of `of_backend` have
/// a default that depends on the back end.
void add_pipeline_options(CLI::App& command, reference::PipelineParameters& parameters,
                          std::span<const std::string_view> of_backend = {});

/// --samples-per-pass. With it and the two above a command takes all that picture_options() and
/// pipeline_options() print.
void add_pass_option(CLI::App& command, reference::PipelineParameters& parameters);

/// --filter and --filter-threshold, where an image is shown or kept.
void add_image_filter_options(CLI::App& command, reference::PipelineParameters& parameters);

/// --arithmetic, where the back end can be chosen.
void add_arithmetic_option(CLI::App& command, reference::PipelineParameters& parameters);

/// The same options (and --schedule) as comma-separated lists of values to select by.
void add_filter_options(CLI::App& command, ConfigurationFilter& filter);

/// Where `--json [FILE]` puts a result.
struct JsonOutput {
    std::string file;  ///< empty: nowhere; "-": standard output, in place of the text

    bool in_place() const { return file == "-"; }
};
/// A word behind --json is its FILE where it is "-" or ends in ".json"; other names stand in one
/// word, --json=NAME (json_words()).
void add_json_option(CLI::App& command, JsonOutput& output);
/// Words of a command line in which every --json has its value: "-" where none was given.
std::vector<std::string> json_words(std::vector<std::string> words);
/// Prints the text, or the JSON in its place; writes the JSON to a file where one was named. Throws
/// bad_input where it cannot be written.
void print_result(const JsonOutput& output, const std::string& json, const std::string& text);

/// A built-in scene, a file that scenes/ loads, or a .scn of bare triangles
/// (verify/capture/ray_file.h).
reference::Scene load_scene_argument(const std::string& scene);

/// Who runs the pipeline, and how closely it is watched.
struct BackendChoice {
    std::string name = "emulator";
    bool check = false;
    Schedule schedule{};
    std::string interleaving;  ///< --schedule FILE: a saved order of one launch's blocks
    std::string plant;         ///< a fault (verify/mutants/plant.h); empty: none
};
/// --backend, --check and --plant, and --schedule for commands that run one configuration.
void add_backend_options(CLI::App& command, BackendChoice& choice, const std::string& help,
                         bool one_configuration);
/// Throws as backend_named() does, and bad_input where --check does not go with the back end. With
/// --check or --plant this may go on as another program.
Backend chosen_backend(const BackendChoice& choice, std::size_t threads,
                       const reference::PipelineParameters& parameters);

/// --threads
void add_thread_option(CLI::App& command, std::size_t& threads);

/// "640x480" into width and height; throws bad_input.
void parse_size(const std::string& text, reference::PipelineParameters& parameters);

/// "a,b,c" into its parts; throws bad_input where one is empty.
std::vector<std::string> split_list(const std::string& option, const std::string& text);

}  // namespace scotty::verify
