#include "verify/view/render_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/file_scene.h"
#include "verify/backends/cuda/cuda_backend.h"
#include "verify/render/progressive.h"
#include "verify/render/render_defaults.h"
#include "verify/view/view_measures.h"
#include "verify/view/view_statistics.h"

namespace scotty::verify {
namespace {

using Clock = std::chrono::steady_clock;
using reference::Error;
using reference::Filter;
using reference::Image;
using reference::ParameterInfo;
using reference::PipelineParameters;
using reference::Vec3;

/// A camera that has been still for so long is at rest, whatever its viewer said last.
constexpr std::chrono::milliseconds kStill{250};
/// Pictures at rest are shown this often.
constexpr std::chrono::milliseconds kRestPace{100};
/// Samples after which a change is judged.
constexpr std::uint32_t kJudgedSamples = 4;
/// Seconds of a first pass after which a smaller picture is shown before.
constexpr double kLongPass = 0.3;
/// Batches after which records of launches are added up, so that they do not fill the memory.
constexpr std::uint32_t kCountedBatches = 256;
constexpr std::uint32_t kMostPixels = 4096u * 4096u;
constexpr std::uint32_t kLeastEdge = 16;
/// Sizes of a moving picture, as shares of each edge.
constexpr std::array kScales{1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125};

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What a single sample's stages give, and no number of samples makes better.
bool is_of_stages(ViewSubject subject) {
    return subject != ViewSubject::picture && subject != ViewSubject::variance;
}

Backend make_backend(const std::string& name, std::size_t threads) {
    return name == "embree" ? embree_backend(threads) : backend_named(name, threads);
}

}  // namespace

class RenderLoop::State {
 public:
    State(reference::Scene scene, ViewState first, RenderLoopOptions options,
          RenderLoopEvents events)
        : options_(std::move(options)), events_(std::move(events)), wanted_(std::move(first)) {
        input_.scene = std::move(scene);
        own_camera_ = input_.scene.camera;
        wanted_.camera = own_camera_;
        given_ = options_.is_given ? options_.is_given : [](std::string_view) { return false; };
        set_defaults(wanted_);
        make(wanted_);
        thread_ = std::thread([this] { run(); });
    }
    ~State() {
        {
            const std::lock_guard lock(mutex_);
            stop_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    std::uint64_t look(const reference::Camera& camera, bool moving) {
        const std::lock_guard lock(mutex_);
        wanted_.camera = camera;
        moving_ = moving;
        last_move_ = Clock::now();
        return changed_picture();
    }
    std::uint64_t own_camera() { return look(own_camera_, false); }
    std::uint64_t frame_all() {
        reference::Camera camera;
        {
            const std::lock_guard lock(mutex_);
            camera = wanted_.camera;
        }
        return look(scenes::fit_camera(input_.scene, camera), false);
    }
    std::uint64_t set(const SetValues& values);
    std::uint64_t show(const ShowAs& how);
    void pick(std::uint64_t asker, const Pick& pixel);
    void set_viewers(std::size_t count) {
        {
            const std::lock_guard lock(mutex_);
            viewers_ = count;
        }
        wake_.notify_all();
    }

    ViewState state() const {
        const std::lock_guard lock(mutex_);
        return wanted_;
    }
    std::uint64_t number() const {
        const std::lock_guard lock(mutex_);
        return number_;
    }
    const reference::Scene& scene() const { return input_.scene; }
    std::shared_ptr<const Image> picture_at_rest(std::uint32_t& samples, ViewState& state) const {
        const std::lock_guard lock(mutex_);
        samples = kept_samples_;
        state = kept_state_;
        return kept_;
    }

 private:
    /// What a number of samples gave, to hold a change against.
    struct Judged {
        ViewState state;
        std::string hash;
        double seconds = 0.0;
        std::uint32_t samples = 0;
    };

    /// The picture is another; `mutex_` is held.
    std::uint64_t changed_picture() {
        ++picture_;
        return changed_display();
    }
    /// The same picture is to be shown otherwise.
    std::uint64_t changed_display() {
        ++number_;
        wake_.notify_all();
        return number_;
    }

    void set_defaults(ViewState& state) const {
        const Backend named = make_backend(state.backend, options_.threads);
        if (is_cpu(state.backend) && !given_("--batch-rays")) {
            state.parameters.batch_rays =
                state.backend == "simt" ? kCpuBatchRays / 8 : kCpuBatchRays;
        }
        const auto is_given = [this, &state](std::string_view option) {
            return given_(option) || (is_cpu(state.backend) && option == "--batch-rays");
        };
        set_render_defaults(named, state.parameters, is_given);
    }

    void make(const ViewState& state);
    void run();
    void work(const ViewState& state, std::uint64_t number, std::uint64_t picture, bool moving);
    void render_moving(const ViewState& state, std::uint64_t number);
    void render_feature(const ViewState& state, std::uint64_t number, bool moving);
    void refine(const ViewState& state, std::uint64_t number, std::uint64_t picture);
    void trace_picks(const ViewState& state);
    void show_kept(const ViewState& state, std::uint64_t number);
    void keep(Image&& image, std::uint32_t samples, const ViewState& state, double seconds);
    void judge(const ViewState& state, const Image& image, std::uint32_t samples, double seconds);
    /// Of the launches since it was called last, which took so long together.
    nlohmann::json take_statistics(double seconds);
    void fill_statistics(ShownPicture& picture);
    double moving_scale(const ViewState& state) const;
    PipelineParameters moving_parameters(const ViewState& state) const;

    RenderLoopOptions options_;
    RenderLoopEvents events_;
    std::function<bool(std::string_view)> given_;
    std::vector<std::string> given_later_;
    reference::Camera own_camera_;

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    ViewState wanted_;
    std::uint64_t number_ = 1, picture_ = 1;
    bool moving_ = false, stop_ = false;
    Clock::time_point last_move_{};
    std::size_t viewers_ = 0;
    std::deque<std::pair<std::uint64_t, Pick>> picks_;
    std::shared_ptr<const Image> kept_;
    std::uint32_t kept_samples_ = 0;
    ViewState kept_state_;

    // Of the render thread.
    PipelineInput input_;
    Backend backend_;
    std::unique_ptr<ProgressiveRenderer> renderer_;
    /// For paths that are asked for: the other may be in the middle of a render.
    std::unique_ptr<ProgressiveRenderer> picker_;
    ViewState made_;
    std::uint64_t shown_number_ = 0, done_picture_ = 0;
    bool shown_at_rest_ = false;
    double kept_seconds_ = 0.0;
    nlohmann::json kept_statistics_;
    double seconds_per_path_ = 0.0;
    std::optional<Judged> judged_;
    std::thread thread_;
};

std::uint64_t RenderLoop::State::set(const SetValues& values) {
    const std::lock_guard lock(mutex_);
    ViewState next = wanted_;
    std::vector<std::string> given = given_later_;
    for (const auto& [name, value] : values.values) {
        if (name == "backend") {
            const auto names = backends();
            if (std::find(names.begin(), names.end(), value) == names.end()) {
                throw Error::bad_input("backend",
                                       fmt::format("expected one of {}", fmt::join(names, ", ")));
            }
            next.backend = value;
            continue;
        }
        if (name == "moving_samples") {
            const ParameterInfo& info = reference::parameter("spp");
            PipelineParameters p;
            set_from_text(info, p, value);
            next.moving_samples = std::min(p.spp, 64u);
            continue;
        }
        const auto* info =
            std::find_if(reference::kParameters.begin(), reference::kParameters.end(),
                         [&name = name](const ParameterInfo& row) { return row.name == name; });
        if (info == reference::kParameters.end() || name == "samples_per_pass") {
            throw Error::bad_input(name, "a view has no such parameter");
        }
        set_from_text(*info, next.parameters, value);
        given.emplace_back(info->option);
    }
    const auto is_given = [first = options_.is_given, given](std::string_view option) {
        return (first && first(option)) ||
               std::find(given.begin(), given.end(), option) != given.end();
    };
    given_ = is_given;
    given_later_ = given;
    if (next.backend != wanted_.backend) set_defaults(next);
    reference::validate(next.parameters);
    if (std::uint64_t{next.parameters.image_width} * next.parameters.image_height > kMostPixels) {
        throw Error::bad_input("size", "a view has at most 4096 x 4096 pixels");
    }
    if (next.parameters.arithmetic != reference::Arithmetic::exact && is_cpu(next.backend)) {
        throw Error::bad_input("arithmetic", "only cuda has another than exact");
    }
    wanted_ = next;
    return changed_picture();
}

std::uint64_t RenderLoop::State::show(const ShowAs& how) {
    const std::lock_guard lock(mutex_);
    ViewState next = wanted_;
    if (how.subject) next.subject = *how.subject;
    if (how.tone) next.tone = *how.tone;
    if (how.exposure) next.exposure = *how.exposure;
    if (how.filtered) next.filtered = *how.filtered;
    if (how.measured) next.measured = *how.measured;
    const std::string why = cannot_show(next.backend, next.subject);
    if (!why.empty()) throw Error::bad_input(to_string(next.subject), why);
    const bool is_new_pipeline = needs_new_pipeline(wanted_, next);
    wanted_ = next;
    return is_new_pipeline ? changed_picture() : changed_display();
}

void RenderLoop::State::pick(std::uint64_t asker, const Pick& pixel) {
    constexpr std::size_t kMostPicks = 16;
    const std::lock_guard lock(mutex_);
    const std::string why = cannot_show(wanted_.backend, ViewSubject::distance);
    if (!why.empty()) throw Error::bad_input("paths", why);
    if (pixel.x >= wanted_.parameters.image_width || pixel.y >= wanted_.parameters.image_height) {
        throw Error::bad_input("pixel", "lies outside of the picture");
    }
    std::erase_if(picks_, [asker](const auto& waiting) { return waiting.first == asker; });
    if (picks_.size() >= kMostPicks) throw Error::bad_input("pixel", "too many wait already");
    picks_.emplace_back(asker, pixel);
    wake_.notify_all();
}

void RenderLoop::State::make(const ViewState& state) {
    renderer_.reset();  // before what they borrow changes
    picker_.reset();
    const bool is_new_tree =
        input_.bvh.node_refs.empty() || needs_new_tree(input_.parameters, state.parameters);
    input_.parameters = state.parameters;
    if (is_new_tree) {
        input_.bvh =
            build_wide_bvh(input_.scene, bvh_parameters(state.parameters, options_.threads));
    }
    backend_ = make_backend(state.backend, options_.threads);
    renderer_ = std::make_unique<ProgressiveRenderer>(backend_, input_, state.measured);
    made_ = state;
    seconds_per_path_ = 0.0;
}

void RenderLoop::State::run() {
    std::unique_lock lock(mutex_);
    while (!stop_) {
        const bool idle = viewers_ == 0 && shown_number_ != 0;
        const bool refines = !is_of_stages(wanted_.subject) && picture_ != done_picture_;
        const bool due = number_ != shown_number_ || refines || !picks_.empty();
        const bool settles = moving_ || !shown_at_rest_;
        if (idle || !(due || settles)) {
            wake_.wait(lock);
            continue;
        }
        const bool still = Clock::now() - last_move_ >= kStill;
        if (still) moving_ = false;
        if (moving_ && number_ == shown_number_ && picks_.empty()) {
            wake_.wait_until(lock, last_move_ + kStill);
            continue;
        }
        const ViewState state = wanted_;
        const std::uint64_t number = number_;
        const std::uint64_t picture = picture_;
        const bool moving = moving_;
        lock.unlock();
        try {
            work(state, number, picture, moving);
        } catch (const std::exception& error) {
            // What fails now would fail again; the next request may not.
            events_.failed(error.what());
            shown_number_ = number;
            done_picture_ = picture;
            shown_at_rest_ = true;
            made_.backend.clear();
        }
        lock.lock();
    }
}

void RenderLoop::State::work(const ViewState& state, std::uint64_t number, std::uint64_t picture,
                             bool moving) {
    if (made_.backend.empty() || needs_new_pipeline(made_, state)) make(state);
    input_.scene.camera = state.camera;
    trace_picks(state);
    if (is_of_stages(state.subject)) {
        if (number != shown_number_ || !shown_at_rest_) render_feature(state, number, moving);
    } else if (moving) {
        if (number != shown_number_) render_moving(state, number);
    } else if (picture == done_picture_ && kept_) {
        if (number != shown_number_ || !shown_at_rest_) show_kept(state, number);
    } else {
        // Where the first pass takes long, or nobody knows, something else is seen meanwhile.
        const double pass = static_cast<double>(state.parameters.image_width) *
                            state.parameters.image_height * seconds_per_path_;
        const bool is_known = seconds_per_path_ > 0.0 || !is_cpu(state.backend);
        if (number != shown_number_ && (!is_known || pass > kLongPass)) {
            render_moving(state, number);
        }
        refine(state, number, picture);
    }
}

double RenderLoop::State::moving_scale(const ViewState& state) const {
    if (seconds_per_path_ == 0.0 && is_cpu(state.backend)) return kScales.back();
    const double budget = 0.75 / options_.frame_rate;
    const double whole = static_cast<double>(state.parameters.image_width) *
                         state.parameters.image_height * state.moving_samples * seconds_per_path_;
    for (const double scale : kScales) {
        if (whole * scale * scale <= budget) return scale;
    }
    return kScales.back();
}

PipelineParameters RenderLoop::State::moving_parameters(const ViewState& state) const {
    PipelineParameters p = state.parameters;
    const double scale = moving_scale(state);
    const auto scaled = [scale](std::uint32_t edge) {
        const auto out = static_cast<std::uint32_t>(std::lround(edge * scale));
        return std::max(std::min(edge, kLeastEdge), out);
    };
    p.image_width = scaled(p.image_width);
    p.image_height = scaled(p.image_height);
    p.spp = state.moving_samples;
    p.samples_per_pass = 0;
    if (is_cpu(state.backend)) {
        // In one batch: nobody looks in between.
        p.batch_rays = std::max(p.batch_rays, p.image_width * p.image_height * p.spp);
    }
    if (!state.filtered) p.filter = Filter::none;
    return p;
}

nlohmann::json RenderLoop::State::take_statistics(double seconds) {
    auto& pipeline = renderer_->pipeline();
    nlohmann::json statistics = launch_statistics(pipeline.launches());
    statistics["seconds"] = seconds;
    pipeline.clear_launches();
    return statistics;
}

void RenderLoop::State::fill_statistics(ShownPicture& picture) {
    picture.statistics = take_statistics(picture.render_seconds);
    picture.device_bytes = renderer_->pipeline().device_bytes();
}

void RenderLoop::State::render_moving(const ViewState& state, std::uint64_t number) {
    input_.parameters = moving_parameters(state);
    renderer_->pipeline().clear_launches();
    const auto start = Clock::now();
    ShownPicture shown;
    shown.image = std::make_shared<const Image>(
        renderer_
            ->render({[](std::uint32_t, const std::function<Image()>&) {},
                      [](const std::string&) { return false; },
                      [](std::uint32_t) { return false; }})
            .image);
    const PipelineParameters& p = input_.parameters;
    if (state.backend == "embree" && p.spp < p.filter_threshold) {
        shown.filter = p.filter;  // Embree's renderer has none
    }
    const double seconds = seconds_since(start);
    const double paths = static_cast<double>(shown.image->pixels.size()) * p.spp;
    const double measured = seconds / paths;
    seconds_per_path_ =
        seconds_per_path_ == 0.0 ? measured : 0.7 * seconds_per_path_ + 0.3 * measured;
    shown.state = number;
    shown.shows = state;
    shown.samples = input_.parameters.spp;
    shown.render_seconds = seconds;
    shown.samples_per_second = paths / seconds;
    fill_statistics(shown);
    shown_number_ = number;
    shown_at_rest_ = false;
    events_.shown(std::move(shown));
}

void RenderLoop::State::render_feature(const ViewState& state, std::uint64_t number, bool moving) {
    input_.parameters = moving ? moving_parameters(state) : state.parameters;
    PipelineParameters& p = input_.parameters;
    p.spp = 1;
    p.samples_per_pass = 0;
    p.filter = Filter::none;
    if (state.subject != ViewSubject::bounces) {
        p.bounces = 0;
        p.light_samples = 0;
    }
    renderer_->pipeline().clear_launches();
    const auto start = Clock::now();
    FeatureObserver observer(input_.scene, p.image_width, p.image_height, state.subject);
    renderer_->render_observed(observer);
    ShownPicture shown;
    shown.render_seconds = seconds_since(start);
    const double paths = static_cast<double>(p.image_width) * p.image_height;
    if (seconds_per_path_ == 0.0) seconds_per_path_ = shown.render_seconds / paths;
    shown.samples_per_second = paths / shown.render_seconds;
    shown.colors = false_colors(observer.take(), shown.legend);
    shown.state = number;
    shown.shows = state;
    shown.samples = 1;
    shown.at_rest = !moving;
    fill_statistics(shown);
    if (state.subject == ViewSubject::queues) {
        shown.statistics["queues"][0] = observer.queue_lengths();
    }
    shown_number_ = number;
    shown_at_rest_ = !moving;
    events_.shown(std::move(shown));
}

void RenderLoop::State::keep(Image&& image, std::uint32_t samples, const ViewState& state,
                             double seconds) {
    auto kept = std::make_shared<const Image>(std::move(image));
    const std::lock_guard lock(mutex_);
    kept_ = std::move(kept);
    kept_samples_ = samples;
    kept_state_ = state;
    kept_seconds_ = seconds;
}

void RenderLoop::State::show_kept(const ViewState& state, std::uint64_t number) {
    ShownPicture shown;
    shown.image = kept_;
    shown.samples = kept_samples_;
    const PipelineParameters& p = state.parameters;
    if (state.filtered && kept_samples_ < p.filter_threshold) shown.filter = p.filter;
    shown.state = number;
    shown.shows = state;
    shown.at_rest = true;
    shown.render_seconds = kept_seconds_;
    shown.samples_per_second = kept_seconds_ > 0.0 ? static_cast<double>(kept_->pixels.size()) *
                                                         kept_samples_ / kept_seconds_
                                                   : 0.0;
    shown.statistics = kept_statistics_;
    shown.device_bytes = renderer_->pipeline().device_bytes();
    shown_number_ = number;
    shown_at_rest_ = true;
    events_.shown(std::move(shown));
}

void RenderLoop::State::judge(const ViewState& state, const Image& image, std::uint32_t samples,
                              double seconds) {
    Judged now{state, hash_of(image), seconds, samples};
    const auto before = std::exchange(judged_, now);
    if (!before || before->samples != samples || !same_camera(before->state.camera, state.camera)) {
        return;
    }
    ChangeEffect effect;
    bool changes_picture = false;
    effect.what = differences(before->state, state, changes_picture);
    if (effect.what.empty()) return;
    effect.seconds_before = before->seconds;
    effect.seconds_after = seconds;
    effect.same_picture = before->hash == now.hash;
    effect.should_be_same = !changes_picture;
    effect.samples = samples;
    effect.hash = now.hash;
    events_.changed(effect);
}

void RenderLoop::State::refine(const ViewState& state, std::uint64_t number,
                               std::uint64_t picture) {
    PipelineParameters& p = input_.parameters;
    p = state.parameters;
    p.filter = Filter::none;
    // A device is quick where a pass fills a batch; the passes end where changes are judged.
    const std::uint64_t pixels = std::uint64_t{p.image_width} * p.image_height;
    p.samples_per_pass = static_cast<std::uint32_t>(
        is_cpu(state.backend) ? 1 : std::clamp<std::uint64_t>(p.batch_rays / pixels, 1, 4));
    if (p.samples_per_pass == 3) p.samples_per_pass = 2;
    const std::uint32_t judged = std::min(kJudgedSamples, p.spp);
    renderer_->pipeline().clear_launches();
    Clock::duration beside{};  // what was not rendering
    const auto start = Clock::now();
    Clock::time_point due = start;
    std::uint64_t last_number = number;
    std::uint32_t batches = 0;
    const auto rendered = [&] {
        return std::chrono::duration<double>(Clock::now() - start - beside).count();
    };
    const auto aside = [&](const auto& f) {
        const auto begin = Clock::now();
        f();
        beside += Clock::now() - begin;
    };
    double window = 0.0;  // seconds of rendering when statistics were taken last
    const auto count_launches = [&] {
        const double seconds = rendered();
        kept_statistics_ = take_statistics(seconds - std::exchange(window, seconds));
    };
    const auto take = [&](Image&& image, std::uint32_t samples) {
        const double seconds = rendered();
        count_launches();
        if (samples == judged) judge(state, image, samples, seconds);
        keep(std::move(image), samples, state, seconds);
        if (seconds_per_path_ == 0.0) {
            seconds_per_path_ = seconds / (static_cast<double>(pixels) * samples);
        }
        ViewState shown_as = state;
        {
            const std::lock_guard lock(mutex_);
            if (picture == picture_) {
                shown_as = wanted_;
                last_number = number_;
            }
        }
        show_kept(shown_as, last_number);
    };
    const ProgressiveListener listener{
        [&](std::uint32_t samples, const std::function<Image()>& pass) {
            const auto begin = Clock::now();
            aside([&] { take(pass(), samples); });
            const auto end = Clock::now();
            due = end + std::max<Clock::duration>(kRestPace, 5 * (end - begin));
        },
        [&](const std::string&) {
            std::uint64_t now_number = 0;
            ViewState now;
            {
                const std::lock_guard lock(mutex_);
                if (stop_ || picture != picture_ || is_of_stages(wanted_.subject)) return true;
                if (viewers_ == 0 && shown_number_ != 0) return true;
                now_number = number_;
                now = wanted_;
            }
            aside([&] { trace_picks(state); });
            if (++batches % kCountedBatches == 0) count_launches();
            if (now_number != last_number && kept_ && shown_at_rest_) {
                last_number = now_number;
                aside([&] { show_kept(now, now_number); });
            }
            return false;
        },
        [&](std::uint32_t samples) { return samples == judged || Clock::now() >= due; }};
    kept_statistics_ = {};
    shown_at_rest_ = false;
    ProgressiveImage done = renderer_->render(listener);
    if (done.samples != p.spp) return;  // it was stopped; what there is has been shown
    take(std::move(done.image), done.samples);
    done_picture_ = picture;
}

void RenderLoop::State::trace_picks(const ViewState& state) {
    std::deque<std::pair<std::uint64_t, Pick>> picks;
    {
        const std::lock_guard lock(mutex_);
        picks.swap(picks_);
    }
    for (const auto& [asker, pixel] : picks) {
        PipelineParameters p = state.parameters;
        if (pixel.x >= p.image_width || pixel.y >= p.image_height) continue;
        p.spp = 1;
        p.samples_per_pass = 0;
        p.filter = Filter::none;
        PathObserver observer(pixel.y * p.image_width + pixel.x);
        const PipelineParameters before = std::exchange(input_.parameters, p);
        if (!picker_) picker_ = std::make_unique<ProgressiveRenderer>(backend_, input_);
        picker_->render_observed(observer);
        picker_->pipeline().clear_launches();
        input_.parameters = before;
        events_.picked(asker, pixel, observer.path());
    }
}

RenderLoop::RenderLoop(reference::Scene scene, ViewState first, RenderLoopOptions options,
                       RenderLoopEvents events)
    : state_(std::make_unique<State>(std::move(scene), std::move(first), std::move(options),
                                     std::move(events))) {}
RenderLoop::~RenderLoop() = default;

std::uint64_t RenderLoop::look(const reference::Camera& camera, bool moving) {
    return state_->look(camera, moving);
}
std::uint64_t RenderLoop::own_camera() { return state_->own_camera(); }
std::uint64_t RenderLoop::frame_all() { return state_->frame_all(); }
std::uint64_t RenderLoop::set(const SetValues& values) { return state_->set(values); }
std::uint64_t RenderLoop::show(const ShowAs& how) { return state_->show(how); }
void RenderLoop::pick(std::uint64_t asker, const Pick& pixel) { state_->pick(asker, pixel); }
void RenderLoop::set_viewers(std::size_t count) { state_->set_viewers(count); }
ViewState RenderLoop::state() const { return state_->state(); }
std::uint64_t RenderLoop::state_number() const { return state_->number(); }
const reference::Scene& RenderLoop::scene() const { return state_->scene(); }
std::shared_ptr<const Image> RenderLoop::picture_at_rest(std::uint32_t& samples,
                                                         ViewState& state) const {
    return state_->picture_at_rest(samples, state);
}

std::vector<std::string> RenderLoop::backends() {
    std::vector<std::string> names{"emulator", "simt", "embree"};
    if (find_cuda()) names.emplace_back("cuda");
    return names;
}

std::string RenderLoop::cannot_show(const std::string& backend, ViewSubject subject) {
    const bool always = subject == ViewSubject::picture || subject == ViewSubject::variance;
    if (backend != "embree" || always) return {};
    return "embree traces path by path: it has no stages and no queues to look into";
}

}  // namespace scotty::verify
