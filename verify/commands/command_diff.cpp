/// scotty diff: two captures, or a capture and a fresh run, launch by launch; or two images.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "verify/backends/temporary_capture.h"
#include "verify/base/ask.h"
#include "verify/base/output_path.h"
#include "verify/capture/pipeline_input.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/diff/diff.h"
#include "verify/diff/foreign.h"
#include "verify/diff/replay.h"
#include "verify/images/image_diff.h"
#include "verify/images/image_noise.h"
#include "verify/report/report.h"

namespace scotty::verify {
namespace {

using reference::Error;

struct DiffCommand {
    std::string a, b;
    std::string backend, backends;
    std::vector<std::string> stages;
    bool isolated = false;
    reference::Arithmetic arithmetic = reference::Arithmetic::exact;
    JsonOutput json;
    std::size_t threads = 0;
    reference::PipelineParameters parameters;  ///< of --backends on a scene
    ImageDiffSettings image;
    bool image_options = false;  ///< one of those was given
    std::string html;            ///< the page to write; empty: none
    std::string command_line;
};

bool compares_images(const DiffCommand& options) {
    return options.backends.empty() && (is_image_path(options.a) || is_image_path(options.b));
}

/// Images are told in the order EXPECTED NEW, as captures are; who has them the other way round
/// mostly has the golden file second.
void hint_at_order(const DiffCommand& options) {
    const auto is_golden = [](const std::string& path) {
        return path.find("golden/") != std::string::npos;
    };
    if (is_golden(options.b) && !is_golden(options.a)) {
        spdlog::warn(
            "{} looks like a golden image and is given as the new one: the order is "
            "scotty diff GOLDEN IMAGE",
            options.b);
    }
}

/// The viewer of `scotty verify`'s page, with this one pair in it.
std::string page_of(const DiffCommand& options, const ImageDiff& diff) {
    Report report;
    report.threads = 0;
    report.command = options.command_line;
    report.stopped = diff.verdict.not_judged;
    ImageCase& shown = report.images.emplace_back();
    shown.name = options.b;
    shown.image = diff.image.image;
    shown.golden = diff.golden.image;
    shown.verdict = diff.verdict;
    shown.z = pixel_statistics(shown.image, shown.golden);
    shown.replay = options.command_line;
    return to_html(report);
}

int run_image_diff(const DiffCommand& options) {
    if (options.b.empty()) {
        throw Error::bad_input(options.a,
                               "expected an image to hold against it: scotty diff GOLDEN IMAGE");
    }
    if (!options.backend.empty() || options.isolated || !options.stages.empty()) {
        throw Error::bad_input("scotty diff",
                               "--backend, --isolated and --stages are for captures, not images");
    }
    hint_at_order(options);
    if (!options.image.heat_map.empty()) check_image_path(options.image.heat_map);
    const ImageDiff diff = diff_images(options.a, options.b, options.image);
    if (!options.image.heat_map.empty()) {
        if (NoisyPair::other_layout(diff.image.image, diff.golden.image).empty()) {
            write_heat_map(diff, options.image.heat_map);
        } else {
            spdlog::warn("{} is not written: the layouts differ", options.image.heat_map);
        }
    }
    if (!options.html.empty()) {
        reference::write_file(options.html, page_of(options, diff));
        spdlog::info("{}: the two images, to be looked into", options.html);
    }
    print_result(options.json, to_json(diff).dump(2), to_text(diff));
    if (!diff.verdict.not_judged.empty()) return kExitUsage;
    return diff.verdict.passed() ? kExitPassed : kExitFailed;
}

bool is_backend(const std::string& name) {
    const auto& names = backend_names();
    return std::find(names.begin(), names.end(), name) != names.end();
}

PipelineInput input_of_scene(const DiffCommand& options) {
    if (options.a.empty()) {
        throw Error::bad_input(
            "--backends",
            "expected a scene for both to run: scotty diff --backends emulator,simt coil");
    }
    PipelineInput input;
    input.scene = load_scene_argument(options.a);
    input.parameters = options.parameters;
    input.bvh = build_wide_bvh(input.scene, bvh_parameters(input.parameters, options.threads));
    return input;
}

std::string rerun_command(const DiffCommand& options) {
    if (options.a.empty()) return fmt::format("scotty diff --backends {}", options.backends);
    const reference::PipelineParameters& p = options.parameters;
    return fmt::format("scotty diff --backends {} {} {} {}", options.backends,
                       shell_word(options.a), picture_options(p), pipeline_options(p));
}

/// Two back ends on a scene, or a back end and a capture, whose input it runs.
DiffReport compare_backends(const DiffCommand& options, DiffOptions diff) {
    const std::vector<std::string> pair = split_list("--backends", options.backends);
    if (pair.size() != 2 || (!is_backend(pair[0]) && !is_backend(pair[1]))) {
        throw Error::bad_input(
            "--backends",
            fmt::format("expected two of {}, one of them perhaps a capture, found '{}'",
                        fmt::join(backend_names(), ", "), options.backends));
    }
    diff.rerun = rerun_command(options);
    if (!is_backend(pair[0]) || !is_backend(pair[1])) {
        const bool capture_first = !is_backend(pair[0]);
        const Capture capture = Capture::open(pair[capture_first ? 0 : 1]);
        const Backend backend = backend_named(pair[capture_first ? 1 : 0], options.threads);
        if (capture.header().foreign) return diff_foreign(capture, backend, std::move(diff));
        if (options.isolated) return diff_isolated(capture, backend, std::move(diff));
        if (capture_first) return diff_with_run(capture, backend, std::move(diff));
        const TemporaryCapture run(backend, read_pipeline_input(capture.directory()));
        return diff_captures(run.get(), capture, std::move(diff));
    }
    const Backend a = backend_named(pair[0], options.threads);
    const Backend b = backend_named(pair[1], options.threads);
    diff.b_arithmetic = options.arithmetic;
    const TemporaryCapture run(a, input_of_scene(options));
    return options.isolated ? diff_isolated(run.get(), b, std::move(diff))
                            : diff_with_run(run.get(), b, std::move(diff));
}

DiffReport compare(const DiffCommand& options) {
    if (!options.backends.empty()) {
        DiffOptions diff;
        diff.patterns = options.stages;
        return compare_backends(options, std::move(diff));
    }
    if (options.a.empty()) {
        throw Error::bad_input("scotty diff", "expected a capture, or --backends and a scene");
    }
    const Capture a = Capture::open(options.a);
    DiffOptions diff;
    diff.patterns = options.stages;
    if (!options.b.empty()) {
        if (options.isolated || !options.backend.empty()) {
            throw Error::bad_input("scotty diff",
                                   "expected a second capture, or --backend (with --isolated or "
                                   "without), found both");
        }
        return diff_captures(a, Capture::open(options.b), std::move(diff));
    }
    const Backend backend =
        backend_named(options.backend.empty() ? "emulator" : options.backend, options.threads);
    if (a.header().foreign) return diff_foreign(a, backend, std::move(diff));
    reference::PipelineParameters b;
    b.arithmetic = options.arithmetic;
    expect_arithmetic(backend, b);
    diff.b_arithmetic = options.arithmetic;
    return options.isolated ? diff_isolated(a, backend, std::move(diff))
                            : diff_with_run(a, backend, std::move(diff));
}

int run_diff(const DiffCommand& options) {
    if (compares_images(options)) return run_image_diff(options);
    if (options.image_options) {
        throw Error::bad_input(
            "scotty diff",
            "--false-alarm, --heavy-tailed, --tolerance, --samples, "
            "--also, --part, --layer, --heatmap and --html are for images, which end in "
            ".exr, .png or the like");
    }
    const DiffReport report = compare(options);
    if (report.stages.empty()) {
        throw Error::bad_input("scotty diff",
                               "no stage was compared: --stages matches none, or the captures "
                               "hold none in common");
    }
    print_result(options.json, to_json(report).dump(2), to_text(report));
    return report.passed() ? kExitPassed : kExitFailed;
}

void add_image_options(CLI::App& command, const std::shared_ptr<DiffCommand>& options) {
    const auto given = [options](CLI::Option* option) {
        option->each([options](const std::string&) { options->image_options = true; });
        return option->group("Images");
    };
    given(command.add_option("--false-alarm", options->image.gates.false_alarm,
                             "probability that a sound image is rejected"))
        ->check(CLI::Range(1e-15, 0.5))
        ->capture_default_str();
    command
        .add_flag_callback(
            "--heavy-tailed",
            [options] {
                options->image.gates.light_tailed = false;
                options->image_options = true;
            },
            "caustics or fireflies: single pixels prove nothing")
        ->group("Images");
    given(command.add_option("--tolerance", options->image.tolerance,
                             "judge by this share of a value, or of the golden image's mean where "
                             "that is more; 0: the same bits"))
        ->check(CLI::Range(0.0, 1.0))
        ->type_name("REL");
    given(command.add_option("--samples", options->image.samples,
                             "a pixel of IMAGE has, where the file does not say (for --also)"))
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 31));
    given(command.add_option("--also", options->image.also,
                             "renders like IMAGE with other seeds: its noise is what they differ "
                             "by"))
        ->type_name("FILE");
    given(command.add_option("--part", options->image.choice.part,
                             "of files that hold several pictures: this one, by name or number"))
        ->type_name("NAME");
    given(command.add_option("--layer", options->image.choice.layer,
                             "the channels NAME.R, NAME.G, NAME.B"))
        ->type_name("NAME");
    given(command.add_option("--html", options->html,
                             "write a page that flips, splits and magnifies the two images"))
        ->type_name("FILE")
        ->check(output_file());
    given(command.add_option("--heatmap", options->image.heat_map,
                             "write where they differ: z, or ulps where noise is not known"))
        ->type_name("FILE.png")
        ->check(output_file());
}

}  // namespace

void add_diff_command(CLI::App& app, Action& action, const std::string& command_line) {
    auto* command = app.add_subcommand(
        "diff",
        "Compare two captures, or a capture with a fresh run, kernel launch by launch; or an "
        "image with its golden image.");
    command->footer(
        "Examples:\n"
        "  scotty diff coil.emulator coil.cuda\n"
        "  scotty diff coil.cuda                       (with a fresh run of the emulator)\n"
        "  scotty diff coil.cuda --isolated            (each stage alone, on the capture's "
        "inputs:\n"
        "                                               tells a wrong kernel from wrong data)\n"
        "  scotty diff --backends emulator,simt coil --size 32x24 --width 4\n"
        "  scotty diff --backends simt,coil.cuda --isolated\n"
        "  scotty diff mine.capture                    (of another program, by "
        "scotty/capture_writer.h)\n"
        "  scotty diff A B --stages '*/intersect' --json\n"
        "  scotty diff GOLDEN.exr IMAGE.exr            (by noise, where the files know theirs)\n"
        "  scotty diff GOLDEN.exr a.exr --also b.exr c.exr d.exr --heatmap z.png\n"
        "  scotty diff GOLDEN.exr IMAGE.exr --html d.html   (a page to look into both)\n"
        "  scotty diff GOLDEN.exr image.npy --tolerance 0.02\n"
        "  scotty diff GOLDEN.exr coil.cuda            (the image of a capture)\n\n"
        "Verdicts: identical, reordered (where the order is free), differs. Exit code 1 where\n"
        "anything differs, is missing on one side, or is not finite. Images: layout, finite, then "
        "the\nmean of all, of 8x8 tiles and of pixels by their noise. Where an image does not know "
        "its "
        "noise\nand the bits differ there is no verdict (exit code 2), unless --tolerance states "
        "one.");
    auto options = std::make_shared<DiffCommand>();
    options->command_line = command_line;
    options->parameters.image_width = 64;
    options->parameters.image_height = 64;
    options->parameters.spp = 1;
    command->add_option("a", options->a,
                        "what is expected: a capture or a golden image; with --backends: a scene");
    command->add_option("b", options->b,
                        "what is new: a capture or an image; none: --backend runs");
    command->add_option("--backend", options->backend,
                        "emulator, simt or cuda: who runs the pipeline [emulator]");
    command
        ->add_option("--backends", options->backends,
                     "two back ends that run a scene, or a back end and a capture")
        ->type_name("A,B");
    command->add_flag("--isolated", options->isolated, "each stage alone, on A's inputs");
    command
        ->add_option_function<std::string>(
            "--arithmetic",
            [options](const std::string& word) {
                options->arithmetic = reference::parse_arithmetic(word);
            },
            "fast: what runs computes approximately, and is held to tolerances [exact]")
        ->type_name("exact|fast");
    command->add_option("--stage,--stages", options->stages, "only stages of such names [all]")
        ->type_name("PATTERN");
    add_json_option(*command, options->json);
    add_image_options(*command, options);
    add_thread_option(*command, options->threads);
    add_picture_options(*command, options->parameters);
    add_pipeline_options(*command, options->parameters);
    add_pass_option(*command, options->parameters);
    command->callback([&action, options] { action = [options] { return run_diff(*options); }; });
}

}  // namespace scotty::verify
