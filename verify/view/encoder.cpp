#include "verify/view/encoder.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "verify/render/progressive.h"
#include "verify/view/display.h"
#include "verify/view/view_json.h"
#include "verify/view/view_measures.h"

namespace scotty::verify {
namespace {

constexpr int kQuality = 85;
/// Rows of a strip, at least: JPEG's blocks are 16 high, and a strip has a header.
constexpr std::uint32_t kStripRows = 64;
constexpr std::uint32_t kMostStrips = 8;

std::uint32_t rows_of_strip(std::uint32_t height) {
    const std::uint32_t strips = std::clamp(height / kStripRows, 1u, kMostStrips);
    const std::uint32_t rows = (height + strips - 1) / strips;
    return (rows + 15) / 16 * 16;
}

std::string without_brace(const nlohmann::json& object) {
    std::string text = object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    text.pop_back();
    return text;
}

/// Sets the legend of false colours.
ColorImage colors_of(ShownPicture& picture) {
    if (!picture.image) return std::move(picture.colors);
    const ViewState& shows = picture.shows;
    if (shows.subject == ViewSubject::variance) {
        return false_colors(variance_of(*picture.image), picture.legend);
    }
    const auto map = [&](const reference::Image& image) {
        return to_srgb(image, shows.exposure, shows.tone, /*exact=*/picture.at_rest);
    };
    return picture.filter == reference::Filter::none
               ? map(*picture.image)
               : map(filtered_image(*picture.image, picture.filter));
}

}  // namespace

std::shared_ptr<EncodedFrame> encode_frame(const ViewModule& module, ShownPicture picture) {
    nlohmann::json measures;
    if (picture.image && picture.at_rest) {
        measures = {{"hash", hash_of(*picture.image)}, {"noise", noise_of(*picture.image)}};
    }
    const ColorImage colors = colors_of(picture);
    const bool lossless = picture.at_rest;
    const std::uint32_t rows = rows_of_strip(colors.height);
    const std::uint32_t count = (colors.height + rows - 1) / rows;
    std::vector<std::string> strips(count);
    oneapi::tbb::parallel_for(0u, count, [&](std::uint32_t i) {
        const std::uint32_t first = i * rows;
        const std::uint8_t* rgb = &colors.rgb[std::size_t{3} * colors.width * first];
        const auto width = static_cast<int>(colors.width);
        const auto height = static_cast<int>(std::min(rows, colors.height - first));
        strips[i] =
            lossless ? module.png(rgb, width, height) : module.jpeg(rgb, width, height, kQuality);
    });
    auto frame = std::make_shared<EncodedFrame>();
    auto parts = nlohmann::json::array();
    for (std::uint32_t i = 0; i < count; ++i) {
        parts.push_back({std::min(rows, colors.height - i * rows), strips[i].size()});
        frame->payload += strips[i];
    }
    nlohmann::json header = frame_json(picture);
    if (!measures.is_null()) header.update(measures);
    header["type"] = lossless ? "image/png" : "image/jpeg";
    header["width"] = colors.width;
    header["height"] = colors.height;
    header["parts"] = std::move(parts);
    frame->state = picture.state;
    frame->header = without_brace(header);
    return frame;
}

Encoder::Encoder(const ViewModule& module,
                 std::function<void(std::shared_ptr<const EncodedFrame>)> done)
    : module_(module), done_(std::move(done)), thread_([this] { run(); }) {}

Encoder::~Encoder() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

void Encoder::take(ShownPicture&& picture) {
    {
        const std::lock_guard lock(mutex_);
        newest_ = std::move(picture);
    }
    wake_.notify_all();
}

void Encoder::run() {
    using Clock = std::chrono::steady_clock;
    Clock::time_point last{};
    std::unique_lock lock(mutex_);
    while (true) {
        wake_.wait(lock, [this] { return stop_ || newest_.has_value(); });
        if (stop_) return;
        ShownPicture picture = std::move(*newest_);
        newest_.reset();
        lock.unlock();
        const auto begin = Clock::now();
        auto frame = encode_frame(module_, std::move(picture));
        frame->number = ++frames_;
        const auto end = Clock::now();
        const double between = std::chrono::duration<double>(end - last).count();
        frames_per_second_ =
            between > 1.0 ? 0.0 : 0.8 * frames_per_second_ + 0.2 / std::max(between, 1e-4);
        last = end;
        frame->header += ",\"frame\":" + std::to_string(frames_) + ",\"encode_seconds\":" +
                         std::to_string(std::chrono::duration<double>(end - begin).count()) +
                         ",\"frames_per_second\":" + std::to_string(frames_per_second_);
        done_(std::move(frame));
        lock.lock();
    }
}

}  // namespace scotty::verify
