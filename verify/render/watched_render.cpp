#include "verify/render/watched_render.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>

#include "reference/base/error.h"
#include "verify/base/progress.h"
#include "verify/base/stop_signal.h"
#include "verify/images/image_file.h"
#include "verify/render/tev_display.h"

namespace scotty::verify {

using reference::Image;
using reference::PipelineParameters;

namespace {

/// What goes on beside a progressive render: the file, the display, the line on the terminal.
class Onlookers {
 public:
    Onlookers(const RenderOutput& output, const PipelineParameters& parameters)
        : output_(output), parameters_(parameters) {
        if (output.display.empty()) return;
        with_display([&] {
            display_.emplace(parse_display(output_.display), output_.file, parameters_.image_width,
                             parameters_.image_height);
        });
    }

    void on_pass(std::uint32_t samples, const std::function<Image()>& picture) {
        samples_ = samples;
        const bool file = file_pace_.is_due();
        const bool display = display_ && display_pace_.is_due();
        if (!file && !display) return;
        const Image image = picture();
        if (display) display_pace_.run([&] { show(image); });
        if (file) file_pace_.run([&] { write_picture(output_, parameters_, image, samples); });
    }
    void say(const std::string& stage) {
        const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
        const std::uint32_t spp = parameters_.spp;
        const double rate = samples_ / seconds;
        progress_.show(
            samples_ == 0 ? fmt::format("sample 1 of {}: {}", spp, stage)
                          : fmt::format("{} of {} samples, {:.3g} samples/s, {} left: {}", samples_,
                                        spp, rate, short_duration((spp - samples_) / rate), stage));
    }
    void finish(const ProgressiveImage& last) {
        write_picture(output_, parameters_, last.image, last.samples);
        show(last.image);
        if (display_) with_display([&] { display_->finish(); });
        progress_.clear();
    }

 private:
    using Clock = std::chrono::steady_clock;

    /// Not too often, and for a tenth of the time at most.
    class Pace {
     public:
        explicit Pace(std::chrono::milliseconds interval) : interval_(interval) {}
        bool is_due() const { return Clock::now() >= due_; }
        template <class Work>
        void run(Work&& work) {
            const auto start = Clock::now();
            work();
            const auto end = Clock::now();
            due_ = end + std::max<Clock::duration>(interval_, 9 * (end - start));
        }

     private:
        Clock::duration interval_;
        Clock::time_point due_;
    };

    /// A display that fails is done without.
    template <class Work>
    void with_display(Work&& work) {
        try {
            work();
        } catch (const reference::Error& error) {
            display_.reset();
            progress_.clear();
            spdlog::warn("{}; rendering goes on without it", error.what());
        }
    }
    void show(const Image& image) {
        if (display_) with_display([&] { display_->update(image); });
    }

    const RenderOutput& output_;
    const PipelineParameters& parameters_;
    Progress progress_;
    std::optional<TevDisplay> display_;
    Pace file_pace_{std::chrono::seconds(1)}, display_pace_{std::chrono::milliseconds(100)};
    Clock::time_point start_ = Clock::now();
    std::uint32_t samples_ = 0;
};

}  // namespace

void write_picture(const RenderOutput& output, const PipelineParameters& p, const Image& image,
                   std::uint32_t samples) {
    const bool filtered = p.filter != reference::Filter::none && samples < p.filter_threshold;
    if (std::filesystem::path(output.file).extension() == ".png") {
        write_image(image, output.file, output.exposure);
        return;
    }
    MeasuredImage measured{image.width, image.height, {}, {}, filtered ? 0 : samples, 1};
    measured.mean.reserve(image.pixels.size());
    for (const reference::Vec3& pixel : image.pixels) {
        measured.mean.push_back({pixel.x, pixel.y, pixel.z});
    }
    for (const reference::Vec3& pixel : image.variance) {
        measured.variance.push_back({pixel.x, pixel.y, pixel.z});
    }
    write_measured_image(measured, output.file, output.provenance);
}

WatchedRender render_watched(const Backend& backend, const PipelineInput& input,
                             const RenderOutput& output) {
    const StopSignals signals;
    Onlookers onlookers(output, input.parameters);
    WatchedRender done;
    done.picture =
        render_progressively(backend, input,
                             {[&](std::uint32_t samples, const std::function<Image()>& picture) {
                                  onlookers.on_pass(samples, picture);
                              },
                              [&](const std::string& stage) {
                                  onlookers.say(stage);
                                  return signals.received() != 0;
                              }});
    if (done.picture.samples != 0) onlookers.finish(done.picture);
    if (done.picture.samples != input.parameters.spp) done.signal = signals.received();
    return done;
}

}  // namespace scotty::verify
