/// scotty-gpu: the CUDA pipeline on its own, for a machine that has nothing but a driver.
///
/// Reads a pipeline input (`scotty capture SCENE -o DIR --input-only`), runs on the device, writes
/// a capture, an image and timings. The diff runs anywhere.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "gpu/host/pipeline.h"
#include "gpu/parity/parity.h"
#include "reference/base/memory.h"
#include "reference/base/write_file.h"
#include "reference/contract/parameter_table.h"
#include "verify/capture/capture_writer.h"
#include "verify/capture/npy.h"
#include "verify/capture/picture_arrays.h"
#include "verify/capture/pipeline_input.h"
#include "verify/capture/ray_file.h"
#include "verify/render/render_defaults.h"

namespace {

using namespace scotty;  // one program, one file
using reference::PipelineParameters;

/// What the command line says instead of the input's parameters, by row of the table.
using Overrides = std::map<const reference::ParameterInfo*, std::string>;

void add_overrides(CLI::App& command, Overrides& overrides) {
    using reference::parameter;
    static constexpr std::array kRows{&parameter("rays_per_block"), &parameter("queue_levels"),
                                      &parameter("queues"),         &parameter("batch_rays"),
                                      &parameter("hit_capacity"),   &parameter("early_out"),
                                      &parameter("hit_mode"),       &parameter("block_order"),
                                      &parameter("shadow_query"),   &parameter("arithmetic")};
    for (const reference::ParameterInfo* info : kRows) {
        command
            .add_option_function<std::string>(
                std::string(info->option),
                [info, &overrides](const std::string& text) { overrides[info] = text; },
                std::string(info->help))
            ->type_name(valid_values(*info));
    }
}

/// Where nobody asks for the stages: the fastest values for a device, like scotty render's. All
/// give the same picture; the tree is the input's.
void set_fastest(const Overrides& overrides, PipelineParameters& p) {
    const auto device = gpu::find_device();
    if (!device) return;  // making the pipeline says so
    verify::Backend cuda;
    cuda.name = "cuda";
    cuda.free_memory = device->free_bytes;
    verify::set_render_defaults(cuda, p, [&](std::string_view option) {
        return option == "--width" ||
               std::any_of(overrides.begin(), overrides.end(),
                           [&](const auto& each) { return each.first->option == option; });
    });
}

void apply(const Overrides& overrides, verify::PipelineInput& input) {
    PipelineParameters& p = input.parameters;
    for (const auto& [info, text] : overrides) set_from_text(*info, p, text);
    reference::validate(p);
    cut_levels(input.bvh, p.queue_levels);
}

int show_device() {
    const auto device = gpu::find_device();
    if (!device) throw reference::Error::missing_environment("no CUDA device");
    std::printf(
        "%s, compute capability %d.%d, %d multiprocessors, %.1f GiB, driver %d, runtime %d\n",
        device->name.c_str(), device->compute_major, device->compute_minor, device->multiprocessors,
        static_cast<double>(device->memory_bytes) / (1u << 30), device->driver_version,
        device->runtime_version);
    return 0;
}

struct RunOptions {
    std::string input, capture, image;
    std::vector<std::string> stages;
    bool hashes_only = false;
    bool timings = false;
    std::size_t memory_limit = 0;
    Overrides overrides;
};

/// `seconds`: of the render by the host's clock, the picture's way back included.
void print_timings(reference::PipelineInterface& pipeline, const PipelineParameters& p,
                   double seconds) {
    std::map<reference::StageKind, std::pair<int, double>> by_kind;
    double kernels = 0.0;
    for (const reference::LaunchRecord& launch : pipeline.launches()) {
        auto& [count, sum] = by_kind[launch.kind];
        ++count;
        sum += launch.seconds;
        kernels += launch.seconds;
    }
    for (const auto& [kind, sum] : by_kind) {
        std::printf("%-20s %6d launches %10.3f ms %5.1f %%\n", reference::to_string(kind),
                    sum.first, 1e3 * sum.second, 100.0 * sum.second / kernels);
    }
    const double samples = static_cast<double>(p.image_width) * p.image_height * p.spp;
    std::printf(
        "width %d, queue levels %u, queues of %s, early-out %s, hit mode %s, batches of %u\n",
        p.width, p.queue_levels, to_string(p.queues), to_string(p.early_out), to_string(p.hit_mode),
        p.batch_rays);
    std::printf("kernels together %.3f ms; the render by the host's clock %.3f ms\n", 1e3 * kernels,
                1e3 * seconds);
    std::printf("at 8 queries a sample, as the report counts: %.1f Mrays/s, by the clock %.1f\n",
                8e-6 * samples / kernels, 8e-6 * samples / seconds);
}

int run(const RunOptions& options) {
    verify::PipelineInput input = verify::read_pipeline_input(options.input);
    if (options.capture.empty()) set_fastest(options.overrides, input.parameters);
    apply(options.overrides, input);
    const gpu::PipelineOptions device{options.timings, options.memory_limit};
    reference::Image image;
    if (options.capture.empty()) {
        const auto pipeline = gpu::make_pipeline(input.scene, input.bvh, input.parameters, device);
        image = pipeline->render();
        if (options.timings) {
            image = pipeline->render();
            pipeline->clear_launches();  // the device is warm, and so is memory for a picture
            const auto begin = std::chrono::steady_clock::now();
            pipeline->render();
            print_timings(
                *pipeline, input.parameters,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        }
    } else {
        verify::CaptureWriter writer(
            options.capture, verify::header_of("cuda", input.scene, input.bvh, input.parameters),
            options.stages);
        const auto pipeline =
            gpu::make_pipeline(input.scene, input.bvh, input.parameters, device, &writer);
        try {
            image = pipeline->render();
        } catch (const reference::Error&) {
            // What was captured until then is what tells why.
            verify::write_pipeline_input(writer.input_folder(), input.scene, input.bvh,
                                         input.parameters);
            writer.finish();
            std::fprintf(stderr, "scotty-gpu: %s holds the %zu stages until the error\n",
                         options.capture.c_str(), writer.stage_count());
            throw;
        }
        if (!options.hashes_only) {
            verify::write_pipeline_input(writer.input_folder(), input.scene, input.bvh,
                                         input.parameters);
        }
        writer.finish();
        if (options.hashes_only) {
            std::filesystem::remove_all(std::filesystem::path(options.capture) / "buffers");
        }
        std::printf("%s: %zu stages\n", options.capture.c_str(), writer.stage_count());
    }
    if (!options.image.empty()) {
        verify::write_picture_arrays(options.image, image,
                                     {{"scene", input.scene.name},
                                      {"backend", "cuda"},
                                      {"samples", input.parameters.spp},
                                      {"parameters", verify::to_json(input.parameters)}});
        std::printf("%s: %u x %u, radiance\n", options.image.c_str(), image.width, image.height);
        if (!image.variance.empty()) {
            std::printf("%s: the variance of each mean of %u samples\n",
                        verify::variance_file(options.image).c_str(), input.parameters.spp);
        }
    }
    return 0;
}

struct TraceOptions {
    std::string input, hits;
    std::vector<std::string> rays;
    bool any = false;
    int repeats = 25;
    Overrides overrides;
};

void print_rate(const std::string& name, std::size_t rays, double seconds) {
    std::printf("  %-40s %10zu rays %9.3f ms %8.1f Mrays/s\n", name.c_str(), rays, 1e3 * seconds,
                1e-6 * static_cast<double>(rays) / seconds);
}

int trace(const TraceOptions& options) {
    verify::PipelineInput input = verify::read_pipeline_input(options.input);
    if (options.rays.size() > 1 && !options.hits.empty()) {
        throw reference::Error::bad_input("--output", "expected one ray file, found several");
    }
    std::vector<verify::RayFile> files;
    for (const std::string& name : options.rays) {
        files.push_back(verify::read_rays(name));
        input.parameters.batch_rays = std::max<std::uint32_t>(
            input.parameters.batch_rays, static_cast<std::uint32_t>(files.back().rays.size()));
    }
    apply(options.overrides, input);

    const auto pipeline = gpu::make_pipeline(input.scene, input.bvh, input.parameters);
    const reference::PipelineParameters& p = input.parameters;
    std::printf(
        "%s: width %d, %d rays per block, queue levels %u, queues of %s, early-out %s, hit mode "
        "%s\n",
        input.scene.name.c_str(), input.bvh.width, p.rays_per_block, p.queue_levels,
        reference::to_string(p.queues), reference::to_string(p.early_out),
        reference::to_string(p.hit_mode));
    std::size_t all_rays = 0;
    double all_seconds = 0.0;
    for (std::size_t i = 0; i < files.size(); ++i) {
        const auto& rays = files[i].rays;
        const bool any = options.any || files[i].any_hit;
        const auto kind = any ? reference::TraversalKind::any : reference::TraversalKind::closest;
        std::vector<reference::Hit> hits(rays.size());
        pipeline->trace(rays, kind, hits);
        if (!options.hits.empty()) {
            std::vector<reference::HitCandidate> records;
            records.reserve(hits.size());
            for (const reference::Hit& hit : hits) records.push_back(verify::hit_record(hit, any));
            verify::write_hits(options.hits, records);
        }
        const double seconds = pipeline->time_trace(rays, kind, options.repeats);
        print_rate(options.rays[i], rays.size(), seconds);
        all_rays += rays.size();
        all_seconds += seconds;
    }
    if (files.size() > 1) print_rate("together", all_rays, all_seconds);
    return 0;
}

int parity(std::uint64_t count) {
    const std::vector<gpu::ParityResult> results = gpu::test_parity(count);
    std::uint64_t mismatches = 0;
    for (const gpu::ParityResult& result : results) {
        mismatches += result.mismatches;
        std::printf("%-28s %12llu tried %8llu mismatches%s%s\n", result.name.c_str(),
                    static_cast<unsigned long long>(result.tried),
                    static_cast<unsigned long long>(result.mismatches),
                    result.mismatches == 0 ? "" : "   first: ", result.first.c_str());
    }
    std::printf("%s\n", mismatches == 0 ? "parity: passed" : "parity: FAILED");
    return mismatches == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    scotty::reference::keep_freed_memory();
    CLI::App app("The CUDA pipeline of CUDA-Scotty on its own: needs a driver, nothing else.");
    app.require_subcommand(1);
    app.footer("Example:\n  scotty-gpu run coil.input -o coil.cuda --timings");
    RunOptions run_options;
    TraceOptions trace_options;
    std::uint64_t parity_count = 1u << 22;

    CLI::App* device = app.add_subcommand("device", "Shows the device");
    CLI::App* run_command = app.add_subcommand(
        "run",
        "Renders a pipeline input: with the parameters that are fastest here or, where a capture "
        "is written, with its own; options are taken in any case");
    run_command->add_option("input", run_options.input, "Directory of a pipeline input or capture")
        ->required();
    run_command->add_option("-o,--output", run_options.capture, "Capture to write");
    run_command->add_option("--stages", run_options.stages, "Only stages that match a pattern");
    run_command->add_option("--image", run_options.image, "Image to write, .npy");
    run_command->add_option("--memory-limit", run_options.memory_limit,
                            "Bytes of device memory to stay within");
    run_command->add_flag("--hashes-only", run_options.hashes_only,
                          "Keep the capture's index, not its buffers");
    run_command->add_flag("--timings", run_options.timings, "Print time by kernel");
    add_overrides(*run_command, run_options.overrides);
    CLI::App* trace_command = app.add_subcommand("trace", "Traces ray files and times them");
    trace_command->add_option("--input", trace_options.input, "Directory of a pipeline input")
        ->required();
    trace_command->add_option("--rays", trace_options.rays, "Ray files")->required();
    trace_command->add_option("-o,--output", trace_options.hits, "Hit file to write");
    trace_command->add_flag("--any", trace_options.any, "Any hit, whatever the file says");
    trace_command->add_option("--repeats", trace_options.repeats, "Timed rounds (median)")
        ->check(CLI::Range(1, 10000));
    add_overrides(*trace_command, trace_options.overrides);
    CLI::App* parity_command = app.add_subcommand(
        "parity", "Compares every arithmetic operation and numerics function with the host");
    parity_command->add_option("--count", parity_count, "Random operands each");

    try {
        app.parse(argc, argv);
        if (device->parsed()) return show_device();
        if (run_command->parsed()) return run(run_options);
        if (trace_command->parsed()) return trace(trace_options);
        return parity(parity_count);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const reference::Error& error) {
        std::fprintf(stderr, "scotty-gpu: %s\n", error.what());
        switch (error.kind()) {
            case reference::ErrorKind::bad_input:
                return 2;
            case reference::ErrorKind::missing_environment:
                return 3;
            case reference::ErrorKind::internal:
                return 70;
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scotty-gpu: internal error: %s\n", error.what());
    }
    return 70;
}
