#include "verify/sweep/verify.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/embree_renderer.h"
#include "reference/truth/tracers.h"
#include "verify/backends/backend.h"
#include "verify/backends/temporary_capture.h"
#include "verify/base/ask.h"
#include "verify/base/same_bits.h"
#include "verify/capture/pipeline_input.h"
#include "verify/capture/recording.h"
#include "verify/diff/diff.h"
#include "verify/diff/replay.h"
#include "verify/diff/run_refusals.h"
#include "verify/oracles/interval_check.h"
#include "verify/oracles/refusal_check.h"
#include "verify/oracles/trace_check.h"
#include "verify/schedules/schedule_check.h"
#include "verify/sweep/crash_verdict.h"
#include "verify/sweep/emulator_diff.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::PipelineParameters;
using reference::StageView;

namespace {

using Clock = std::chrono::steady_clock;

/// Where no more paths than these run, all stages are run alone, too.
constexpr std::size_t kMostPathsAlone = 64;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Passes stages through VerifySettings::tamper.
class TamperingObserver : public reference::StageObserver {
 public:
    TamperingObserver(reference::StageObserver& to, const VerifySettings::Tamper& tamper,
                      std::size_t configuration)
        : to_(to), tamper_(tamper), configuration_(configuration) {}

    void on_stage(const StageView& stage) override {
        tamper_(stage, configuration_, [&](const StageView& shown) { to_.on_stage(shown); });
    }
    void on_retry(std::string_view stage, std::string_view reason) override {
        to_.on_retry(stage, reason);
    }

 private:
    reference::StageObserver& to_;
    const VerifySettings::Tamper& tamper_;
    std::size_t configuration_;
};

/// Ends a run from inside: thrown after a launch, and caught where the configuration was begun.
struct Stopped {};

class StoppingObserver : public reference::StageObserver {
 public:
    StoppingObserver(const std::function<bool()>& stop, const std::atomic<bool>& ended)
        : stop_(stop), ended_(ended) {}
    void on_stage(const StageView&) override {
        note_progress();
        if (ended_ || (stop_ && stop_())) throw Stopped{};
    }

 private:
    const std::function<bool()>& stop_;
    const std::atomic<bool>& ended_;
};

bool hits_anything(const Recording& recording) {
    return std::any_of(recording.traversals.begin(), recording.traversals.end(),
                       [](const TraversalRecord& traversal) {
                           return std::any_of(traversal.hits.begin(), traversal.hits.end(),
                                              reference::is_hit);
                       });
}

class SceneVerification {
 public:
    SceneVerification(const reference::Scene& scene, const VerifySettings& settings)
        : scene_(scene), settings_(settings) {
        report_.scene = scene.name;
        report_.source = scene.source;
        report_.triangles = scene.triangles.size();
        report_.warnings = scene.warnings;
    }

    SceneReport run() {
        const auto start = Clock::now();
        const UnderWay under_way("tree, oracles and runs of " + source(),
                                 replay_of(baseline_configuration(settings_.parameters)));
        const std::vector<Configuration> all = all_configurations(settings_);
        std::vector<std::size_t> ours;  // but the baseline
        for (std::size_t i = 1; i < all.size(); ++i) {
            if (is_ours(i)) ours.push_back(i);
        }
        const bool whole = is_ours(0);
        if (!whole && ours.empty()) return std::move(report_);
        steps_ = 1 + (whole && settings_.oracles ? 1 : 0) + ours.size();
        report_.left_out = ours.size() + (whole ? 1 : 0);
        try {
            run_all(all, ours, whole);
        } catch (const Stopped&) {  // what was judged until then is reported
        }
        report_.seconds = seconds_since(start);
        return std::move(report_);
    }

 private:
    void run_all(const std::vector<Configuration>& all, const std::vector<std::size_t>& ours,
                 bool whole) {
        ConfigurationReport baseline;
        const Recording truth = run_configuration(all.front(), nullptr, 0, baseline);
        if (!hits_anything(truth)) {
            report_.warnings.emplace_back(
                "no ray hit anything, so hits were not put to the test: does the camera see the "
                "scene (#camera=fit frames a file's), and have its triangles any area?");
        }
        if (whole) {
            baseline.unit = settings_.first_unit;
            report_.configurations.push_back(std::move(baseline));
            judged();
            if (settings_.oracles) run_oracles(truth);
            announce();
        }  // else another shard's to report
        run_others(all, ours, truth);
        judge_hashes();
    }

    /// Last, and only of what everything else calls right: a hash says that a thing is another, not
    /// why.
    void judge_hashes() {
        if (settings_.hashes == nullptr || !report_.passed()) return;
        hashes_.merge(table_hashes());
        hashes_.merge(scene_hashes(source(), scene_));
        std::vector<Failure> failures = settings_.hashes->look_up(hashes_);
        if (failures.empty()) return;
        ConfigurationReport& first = report_.configurations.front();
        first.counts.failures += failures.size();
        first.failures = std::move(failures);
        announce();
    }

    /// What load_scene() takes.
    const std::string& source() const {
        return scene_.source.empty() ? scene_.name : scene_.source;
    }
    bool asks_hashes() const {
        return settings_.hashes != nullptr && settings_.stage_pattern.empty();
    }
    void note(Hashes hashes) {
        const std::lock_guard lock(mutex_);
        hashes_.merge(std::move(hashes));
    }

    /// Configurations know nothing of each other: as many at a time as there are threads, so that
    /// those whose blocks run one by one leave no core idle. Where all memory is watched, or a
    /// device runs, one at a time.
    void run_others(const std::vector<Configuration>& all, const std::vector<std::size_t>& ours,
                    const Recording& truth) {
        for (const std::size_t i : ours) bvh_of(all[i].parameters);  // which builds are shared
        const bool one_by_one = settings_.check || settings_.tamper || settings_.backend == "cuda";
        const std::size_t before = report_.configurations.size();
        std::vector<std::optional<ConfigurationReport>> done(ours.size());
        std::exception_ptr thrown;
        const auto run_one = [&](std::size_t i) {
            if (ended_) return;
            try {
                ConfigurationReport report;
                run_configuration(all[ours[i]], &truth, ours[i], report);
                report.unit = settings_.first_unit + ours[i];
                const std::lock_guard lock(mutex_);
                done[i] = std::move(report);
                --report_.left_out;
                announce(*done[i]);
            } catch (const Stopped&) {
                ended_ = true;
            } catch (...) {
                const std::lock_guard lock(mutex_);
                thrown = std::current_exception();
                ended_ = true;
            }
        };
        if (one_by_one) {
            for (std::size_t i = 0; i < ours.size(); ++i) run_one(i);
        } else {
            tbb::parallel_for(
                tbb::blocked_range<std::size_t>(0, ours.size(), 1),
                [&](const tbb::blocked_range<std::size_t>& range) {
                    // A thread that waits inside a run takes no other run meanwhile.
                    for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        tbb::this_task_arena::isolate([&] { run_one(i); });
                    }
                },
                tbb::simple_partitioner());
        }
        if (thrown) std::rethrow_exception(thrown);
        report_.configurations.reserve(before + done.size());
        for (auto& one : done) {
            if (one) report_.configurations.push_back(std::move(*one));
        }
        if (ended_) throw Stopped{};
    }

    void judged() {
        --report_.left_out;
        announce();
    }

    /// Says what failed first, once; ends the run where that was asked for.
    void announce() {
        if (report_.passed()) return;
        say_first(report_);
        if (settings_.fail_fast) throw Stopped{};
    }
    void announce(const ConfigurationReport& configuration) {
        if (configuration.failures.empty()) return;
        SceneReport alone;
        alone.scene = report_.scene;
        alone.configurations = {configuration};
        say_first(alone);
        if (settings_.fail_fast) throw Stopped{};
    }
    void say_first(const SceneReport& report) {
        if (std::exchange(announced_, true) || !settings_.on_first_failure) return;
        settings_.on_first_failure(placed_failures(report).front());
    }

    bool is_ours(std::size_t configuration) const {
        return !settings_.has_unit || settings_.has_unit(settings_.first_unit + configuration);
    }

    void begin_step(const std::string& what) {
        const std::lock_guard lock(mutex_);
        if (settings_.progress) settings_.progress(what, done_, steps_);
        ++done_;
    }

    /// Built once a width and cut, and valid before anything is traced through it.
    const reference::WideBvh& bvh_of(const PipelineParameters& p) {
        auto& bvh = bvhs_[{p.width, p.queue_levels}];
        if (bvh.width == 0) {
            bvh = build_wide_bvh(scene_, bvh_parameters(p, settings_.threads));
            for (const std::string& fault : reference::validate(bvh, scene_)) {
                Failure failure;
                failure.invariant = "bvh";
                failure.stage = fmt::format("BVH of width {}", p.width);
                failure.sentence = fault;
                report_.bvh_failures.push_back(std::move(failure));
            }
            if (asks_hashes()) note(tree_hashes(source(), p, bvh));
        }
        return bvh;
    }

    std::string replay_of(const Configuration& configuration) const {
        const PipelineParameters& p = configuration.parameters;
        std::string command = fmt::format("scotty verify {} {} {}", shell_word(source()),
                                          picture_options(p), configuration.options());
        if (p.filter != reference::Filter::none) {
            command += fmt::format(" --filter {} --filter-threshold {}",
                                   reference::to_string(p.filter), p.filter_threshold);
        }
        if (settings_.backend != "emulator") command += " --backend " + settings_.backend;
        if (settings_.check) command += " --check";
        if (!settings_.plant.empty()) command += " --plant " + settings_.plant;
        if (settings_.threads != 0) command += fmt::format(" --threads {}", settings_.threads);
        if (settings_.schedules != 0)
            command += fmt::format(" --schedules {}", settings_.schedules);
        return command;
    }

    PipelineInput input_of(const reference::WideBvh& bvh, const PipelineParameters& p) const {
        return {scene_, bvh, p};
    }

    /// Runs, judges every launch, and compares with the baseline where there is one. `index` is the
    /// configuration's in all_configurations(). May run on several threads at a time.
    Recording run_configuration(const Configuration& configuration, const Recording* baseline,
                                std::size_t index, ConfigurationReport& out) {
        begin_step(configuration.label());
        const auto start = Clock::now();
        const PipelineParameters& p = configuration.parameters;
        const emulation::DeviceOptions device = configuration.device(settings_.threads);
        const reference::WideBvh& bvh = bvh_of(p);
        Recording recording;
        Recorder recorder(p, recording);
        const Backend backend = backend_named(settings_.backend, device);
        InvariantChecker checker(
            scene_, bvh, p,
            {.stage_pattern = settings_.stage_pattern, .written_by = backend.written_by});
        std::optional<EmulatorDiff> emulator;
        std::optional<PipelineInput> input;
        if (backend.name != "emulator") {
            input = input_of(bvh, p);
            emulator.emplace(*input, settings_.threads, backend);
        }
        std::vector<reference::StageObserver*> all{&checker, &recorder};
        if (emulator) all.push_back(&emulator->observer());
        std::optional<StoppingObserver> stopping;
        std::optional<WorkHasher> work;
        if (asks_hashes() && backend.name != "cuda" &&
            configuration.schedule.kind != emulation::ScheduleKind::free) {
            all.push_back(&work.emplace());
        }
        if (settings_.stop || settings_.fail_fast) {
            all.push_back(&stopping.emplace(settings_.stop, ended_));
        }
        Observers observers(all);
        std::optional<TamperingObserver> tampering;
        reference::StageObserver* observer = &observers;
        if (settings_.tamper) {
            observer = &tampering.emplace(observers, settings_.tamper, index);
        }
        out.label =
            baseline == nullptr ? "baseline: " + configuration.label() : configuration.label();
        out.replay = replay_of(configuration);
        const UnderWay under_way(out.label, out.replay);
        // What had been seen until then leads: it may well be the reason.
        const auto ended_by = [&](const char* why) {
            out.failures = failures_until_now(checker, emulator, out.stages, false);
            Failure failure;
            failure.invariant = "error";
            failure.stage = "render";
            failure.sentence = why;
            out.failures.push_back(std::move(failure));
            out.counts = checker.counts();
            out.counts.failures += 1;
        };
        try {
            const std::unique_ptr<reference::PipelineInterface> pipeline =
                emulator ? backend.pipeline(*input, observer)
                         : std::make_unique<emulation::Pipeline>(scene_, bvh, p, device, observer);
            recording.image = pipeline->render();
            if (work) work->add(pipeline->launches(), pipeline->device_bytes());
        } catch (const std::bad_alloc&) {
            throw;  // the machine's limit, not the pipeline's fault
        } catch (const std::exception& error) {
            ended_by(error.what());
            return recording;
        }
        out.failures = failures_until_now(checker, emulator, out.stages, true);
        out.counts = checker.counts();
        out.counts.failures += out.failures.size() - checker.failures().size();
        out.rays = recording.living_rays();
        if (baseline != nullptr) {
            const bool any = p.shadow_query == reference::ShadowQuery::any &&
                             p.early_out != reference::EarlyOut::off;
            for (Failure& difference : compare(*baseline, recording, any, p.spp)) {
                if (!stage_matches(settings_.stage_pattern, difference.stage)) continue;
                out.failures.push_back(std::move(difference));
                ++out.counts.failures;
            }
        }
        if (settings_.stage_pattern.empty()) check_handed_out(recording, p, out);
        if (asks_hashes() && baseline == nullptr) note(picture_hashes(source(), p, recording));
        if (out.counts.failures == 0 && settings_.stage_pattern.empty()) {
            check_unwatched(bvh, p, backend, recording.image, out);
            if (recording.radiance.size() <= kMostPathsAlone) {
                std::optional<TemporaryCapture> own;
                if (!emulator) own.emplace(backend, input_of(bvh, p));
                const Capture& whole = emulator ? emulator->expected() : own->get();
                check_stages_alone(whole, backend, out);
                std::string said;
                if (baseline != nullptr) add(check_stage_refusals(whole, backend, &said), out);
                if (work) work->add(said);
            }
            if (settings_.oracles) trace_rays(bvh, p, backend, recording, out);
        }
        if (work) {
            note({{fmt::format("{} {} {} {}", backend.name == "simt" ? kWorkOfText : "work",
                               source(), picture_options(p), configuration.options()),
                   work->hash()}});
        }
        if (settings_.schedules != 0) run_schedules(bvh, p, index, out);
        out.seconds = seconds_since(start);
        return recording;
    }

    /// Where nobody watches, a pipeline may leave out what only an observer sees: another way
    /// through it, which must come to the same picture.
    void check_unwatched(const reference::WideBvh& bvh, const PipelineParameters& p,
                         const Backend& backend, const reference::Image& watched,
                         ConfigurationReport& out) {
        Failure failure;
        try {
            const auto found =
                compare_images(watched, backend.render(input_of(bvh, p), nullptr), p.spp);
            if (!found) return;
            failure = *found;
            failure.sentence = fmt::format("pixel {} is another where nobody watches the launches",
                                           failure.ray / p.spp);
        } catch (const reference::Error& error) {
            failure.sentence = error.what();
        }
        failure.invariant = invariant::kUnwatched;
        failure.stage = "render";
        out.failures.push_back(std::move(failure));
        ++out.counts.failures;
    }

    /// A stage is a function of its inputs: run alone on those of the emulator's run, each gives
    /// that run's outputs. Replay and isolated diffs are of no worth where it does not.
    static void check_stages_alone(const Capture& emulator, const Backend& backend,
                                   ConfigurationReport& out) {
        const DiffReport report = diff_isolated(emulator, backend, {});
        for (const StageResult& stage : report.stages) {
            if (!stage.failed()) continue;
            Failure failure;
            failure.invariant = "same-alone";
            failure.stage = stage.name;
            failure.launch = stage.launch;
            failure.sentence = "alone on the same inputs it gives other outputs";
            if (stage.first) failure.sentence += ": " + stage.first->sentence;
            out.failures.push_back(std::move(failure));
            ++out.counts.failures;
        }
    }

    /// A filter runs where it is asked for and there are few samples; the image that is handed out
    /// is what the last launch has made.
    static void check_handed_out(const Recording& recording, const PipelineParameters& p,
                                 ConfigurationReport& out) {
        Failure failure;
        failure.stage = "render";
        const bool asked = p.filter != reference::Filter::none && p.spp < p.filter_threshold;
        const bool ran = !recording.filtered.empty();
        const std::vector<reference::Vec3>& shown =
            ran ? recording.filtered : recording.reconstructed;
        if (asked != ran) {
            failure.invariant = invariant::kFilter;
            failure.field = buffers::filtered.name;
            failure.expected = asked ? "a filtered image" : "none";
            failure.found = ran ? "a filtered image" : "none";
            failure.sentence = fmt::format(
                "with {} samples per pixel the {} filter {} (it does below {})", p.spp,
                reference::to_string(p.filter), ran ? "ran" : "did not run", p.filter_threshold);
        } else if (shown.size() != recording.image.pixels.size() ||
                   !std::equal(shown.begin(), shown.end(), recording.image.pixels.begin(),
                               [](const auto& a, const auto& b) { return same_bits(a, b); })) {
            failure.invariant = invariant::kPixels;
            failure.field = buffers::image.name;
            failure.sentence = "the image that is handed out is not what the last launch has made";
        } else {
            return;
        }
        out.failures.push_back(std::move(failure));
        ++out.counts.failures;
    }

    /// Rays from elsewhere, and rays of this very run, through the same configuration.
    void trace_rays(const reference::WideBvh& bvh, const PipelineParameters& p,
                    const Backend& backend, const Recording& recording, ConfigurationReport& out) {
        const PipelineInput& input = input_of(bvh, p);
        TraceCheckSettings settings;
        settings.seed = p.seed + report_.configurations.size();
        settings.any_is_closest = p.early_out == reference::EarlyOut::off;
        settings.brute_force_tests =
            std::min(settings.brute_force_tests, settings_.brute_force_tests);
        // One pipeline for all queries: what an earlier batch leaves behind must not matter.
        const auto pipeline = backend.pipeline(input);
        const auto trace = [&](std::span<const reference::Ray> rays, reference::TraversalKind kind,
                               std::span<reference::Hit> hits) {
            pipeline->trace(rays, kind, hits);
        };
        add(check_traces(scene_, recording, trace, settings), out);
    }

    static void add(std::vector<Failure> failures, ConfigurationReport& out) {
        out.counts.failures += failures.size();
        std::move(failures.begin(), failures.end(), std::back_inserter(out.failures));
    }

    void run_schedules(const reference::WideBvh& bvh, const PipelineParameters& p,
                       std::size_t index, ConfigurationReport& out) {
        const PipelineInput input = input_of(bvh, p);
        const auto render = [&](const emulation::Schedule& schedule,
                                reference::StageObserver& observer) {
            const Configuration configuration{p, schedule};
            const Backend backend =
                backend_named(settings_.backend, configuration.device(settings_.threads));
            if (!settings_.tamper) {
                backend.render(input, &observer);
                return;
            }
            TamperingObserver tampering(observer, settings_.tamper, index);
            backend.render(input, &tampering);
        };
        const auto schedules = emulation::seeded_schedules(settings_.schedules);
        for (Failure& failure : check_schedules(schedules, p, render)) {
            if (!stage_matches(settings_.stage_pattern, failure.stage)) continue;
            out.failures.push_back(std::move(failure));
            ++out.counts.failures;
        }
        out.schedules = schedules.size();
    }

    /// Where the run parted from the emulator, which names who wrote it, and then the invariants
    /// that it broke.
    std::vector<Failure> failures_until_now(const InvariantChecker& checker,
                                            std::optional<EmulatorDiff>& emulator,
                                            StageCounts& stages, bool whole_run) const {
        std::vector<Failure> failures;
        if (emulator) failures = emulator->finish(stages, whole_run);
        std::erase_if(failures, [&](const Failure& failure) {
            return !stage_matches(settings_.stage_pattern, failure.stage);
        });
        failures.insert(failures.end(), checker.failures().begin(), checker.failures().end());
        return failures;
    }

    void run_oracles(const Recording& truth) {
        begin_step("brute force and Embree");
        const auto start = Clock::now();
        const reference::EmbreeTracer embree(scene_);
        const std::uint32_t spp = settings_.parameters.spp;
        report_.hits = check_hits(
            scene_, truth, embree, spp,
            {settings_.brute_force_tests, settings_.parameters.seed, settings_.stage_pattern});
        // What is known to be broken may end the process, and the report with it, where nobody
        // watches its launches.
        const bool sound = report_.configurations.front().failures.empty();
        if (sound && settings_.stage_pattern.empty()) {
            run_interval_check(truth);
            check_refusals(truth);
        }
        const PipelineParameters& p = settings_.parameters;
        // Before a filter: the same paths, added up in the same order.
        const reference::Image image{p.image_width, p.image_height, truth.reconstructed};
        const bool whole = image.pixels.size() == std::size_t{p.image_width} * p.image_height;
        if (whole && settings_.stage_pattern.empty()) {
            report_.image = check_image(
                image, reference::render_with_embree(scene_, p, embree, settings_.threads),
                report_.hits.excused, spp);
        }
        report_.oracles_ran = true;
        report_.oracle_seconds = seconds_since(start);
    }

    /// Of a small scene: is what is spoiled in it, and in what is traced through it, refused?
    void check_refusals(const Recording& truth) {
        if (scene_.triangles.size() > kMostSpoiledTriangles) return;
        const Configuration baseline = baseline_configuration(settings_.parameters);
        const Backend backend =
            backend_named(settings_.backend, baseline.device(settings_.threads));
        const PipelineInput input = input_of(bvh_of(baseline.parameters), baseline.parameters);
        std::vector<reference::Ray> rays;
        if (!truth.traversals.empty()) rays = truth.traversals.front().rays;
        if (rays.size() > kMostPathsAlone) rays.resize(kMostPathsAlone);
        const auto add = [&](std::vector<Failure> failures) {
            std::move(failures.begin(), failures.end(), std::back_inserter(report_.hits.failures));
        };
        std::string said;
        add(check_scene_refusals(scene_, reference::validate_and_repair, &said));
        const auto validator = [](const auto& tree, const auto& of) {
            return reference::validate(tree, of);
        };
        add(check_tree_refusals(input.bvh, scene_, validator, &said));
        PipelineParameters cut = baseline.parameters;  // nodes below the levels that have queues
        cut.queue_levels = 1;
        add(check_tree_refusals(bvh_of(cut), scene_, validator, &said));
        add(check_parameter_refusals([](const auto& p) { reference::validate(p); }, &said));
        add(check_ray_refusals(input, backend, rays, &said));
        add(check_queue_refusal(input, backend, rays, &said));
        // The text of others' messages is theirs.
        if (!asks_hashes() || backend.name != "emulator") return;
        note({{fmt::format("refusals {} {}", source(), picture_options(settings_.parameters)),
               hash_of_text(said)}});
    }

    void run_interval_check(const Recording& truth) {
        const Configuration baseline = baseline_configuration(settings_.parameters);
        const Backend backend =
            backend_named(settings_.backend, baseline.device(settings_.threads));
        const PipelineInput input = input_of(bvh_of(baseline.parameters), baseline.parameters);
        const auto trace = [&](std::span<const reference::Ray> rays,
                               std::span<reference::Hit> hits) {
            backend.pipeline(input)->trace(rays, reference::TraversalKind::closest, hits);
        };
        for (Failure& failure :
             check_intervals(scene_, truth, trace, settings_.brute_force_tests)) {
            report_.hits.failures.push_back(std::move(failure));
        }
    }

    const reference::Scene& scene_;
    const VerifySettings& settings_;
    SceneReport report_;
    std::map<std::pair<int, std::uint32_t>, reference::WideBvh> bvhs_;
    Hashes hashes_;  ///< of what was run
    std::size_t done_ = 0;
    std::size_t steps_ = 0;
    std::mutex mutex_;  ///< of the report and of progress, while configurations run
    std::atomic<bool> ended_{false};
    bool announced_ = false;
};

}  // namespace

PipelineParameters default_verify_parameters() {
    PipelineParameters p;
    p.image_width = 45;
    p.image_height = 37;
    p.spp = 2;
    p.bounces = 2;
    p.light_samples = 2;
    return p;
}

std::vector<Configuration> all_configurations(const VerifySettings& settings) {
    std::vector<Configuration> all{baseline_configuration(settings.parameters)};
    if (settings.only) {
        all.insert(all.end(), settings.only->begin(), settings.only->end());
        return all;
    }
    for (const Configuration& c : configurations(settings.parameters, settings.filter)) {
        if (c.options() != all.front().options()) all.push_back(c);
    }
    return all;
}

std::size_t units_of_scene(const VerifySettings& settings) {
    return all_configurations(settings).size();
}

SceneReport verify_scene(const reference::Scene& scene, const VerifySettings& settings) {
    reference::validate(settings.parameters);
    catch_crashes();
    std::optional<tbb::global_control> limit;
    if (settings.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
    }
    return SceneVerification(scene, settings).run();
}

}  // namespace scotty::verify
