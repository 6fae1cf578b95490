#include "verify/view/view_session.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "reference/contract/parameter_table.h"
#include "scenes/camera_file.h"
#include "verify/base/scratch_folder.h"
#include "verify/pages/page.h"
#include "verify/render/watched_render.h"
#include "verify/view/comparison.h"
#include "verify/view/encoder.h"
#include "verify/view/jobs.h"
#include "verify/view/view_json.h"
#include "verify/view/view_library.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using reference::Error;
using reference::PipelineParameters;

/// Pixels of a run that is captured or verified: each pixel's buffers are kept.
constexpr std::uint32_t kJudgedPixels = 64 * 48;
constexpr std::uint32_t kComparedPixels = 512 * 512;

std::string text_of(const json& message) {
    return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Error::bad_input(file.filename().string(), "is not there yet");
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// The same shape with at most so many pixels.
std::pair<std::uint32_t, std::uint32_t> size_within(const PipelineParameters& p,
                                                    std::uint32_t pixels) {
    const double all = static_cast<double>(p.image_width) * p.image_height;
    const double share = std::min(1.0, std::sqrt(pixels / all));
    const auto edge = [share](std::uint32_t length) {
        return std::max(1u, static_cast<std::uint32_t>(length * share));
    };
    return {edge(p.image_width), edge(p.image_height)};
}
std::string size_text(const std::pair<std::uint32_t, std::uint32_t>& size) {
    return fmt::format("{}x{}", size.first, size.second);
}

/// What a name in a download may consist of.
std::string file_name_of(const std::string& scene) {
    std::string name;
    for (const char c : scene) {
        name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '-';
    }
    return name.empty() ? "view" : name;
}

WebResponse not_found(const std::string& why) {
    return {404, "text/plain; charset=utf-8", why + "\n", {}};
}

std::vector<std::string> options_as_words(const PipelineParameters& p,
                                          std::initializer_list<reference::ParameterGroup> groups) {
    std::vector<std::string> words;
    for (const reference::ParameterInfo& info : reference::kParameters) {
        if (std::find(groups.begin(), groups.end(), info.group) == groups.end()) continue;
        if (info.option == "--size" || info.name == "samples_per_pass" || info.name == "spp")
            continue;
        words.insert(words.end(), {std::string(info.option), reference::text_of(info, p)});
    }
    return words;
}

/// What a job runs, one after the other, and what viewers are told of it.
struct JobPlan {
    std::vector<std::vector<std::string>> commands;
    json message;
};

/// The frame of a viewer's newest request is named in frames for this long a list of requests.
constexpr std::size_t kMostNoted = 4096;

}  // namespace

std::string random_token() {
    std::array<unsigned char, 16> bytes{};
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        throw Error::missing_environment("the system gives no random numbers for the link's token");
    }
    std::string token;
    for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
    return token;
}

class ViewSession::State final : public ViewHost {
 public:
    State(reference::Scene scene, ViewState first, ViewOptions options)
        : options_(std::move(options)),
          module_(view_module()),
          name_(file_name_of(scene.name)),
          camera_file_(name_ + ".camera"),
          own_(scene.camera),
          encoder_(module_, [this](const auto& frame) { publish(frame); }),
          loop_(std::move(scene), std::move(first), options_.loop, events()) {
        if (options_.token.empty()) options_.token = random_token();
        std::string error;
        auto server =
            module_.listen({options_.address, options_.port, options_.token}, *this, error);
        if (server == nullptr) {
            throw Error::missing_environment(fmt::format("cannot listen on {} port {}: {}",
                                                         options_.address, options_.port, error));
        }
        const std::lock_guard lock(mutex_);
        server_ = std::move(server);
        if (newest_) server_->offer(newest_);
    }
    ~State() override {
        std::map<std::string, RunningJob> jobs;
        {
            const std::lock_guard lock(jobs_mutex_);
            jobs.swap(jobs_);
        }
        jobs.clear();
        std::unique_ptr<ViewServer> server;
        {
            const std::lock_guard lock(mutex_);
            closing_ = true;
            server.swap(server_);
        }
        server.reset();
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    std::string link() const {
        const bool v6 = options_.address.find(':') != std::string::npos;
        const std::lock_guard lock(mutex_);
        return fmt::format("http://{}{}{}:{}/{}/", v6 ? "[" : "", options_.address, v6 ? "]" : "",
                           server_->port(), options_.token);
    }
    void wait_for_first_picture() {
        std::unique_lock lock(mutex_);
        first_.wait(lock, [this] { return newest_ != nullptr; });
    }

    WebResponse get(const std::string& path) override;
    void joined(ViewerId viewer) override;
    void left(ViewerId viewer) override;
    void received(ViewerId viewer, std::string_view text) override;
    std::string frame_header(ViewerId viewer, const ViewFrame& frame) override;

 private:
    /// A viewer's requests that no frame has shown yet: state and the viewer's number.
    struct Viewer {
        std::deque<std::pair<std::uint64_t, std::uint64_t>> requests;
        std::uint64_t shown = 0;
    };
    struct RunningJob {
        std::unique_ptr<ScratchFolder> folder;    ///< of the job that runs
        std::unique_ptr<ScratchFolder> finished;  ///< of the one before, whose files are shown
        std::unique_ptr<Job> job;
    };

    RenderLoopEvents events();
    void publish(const std::shared_ptr<const EncodedFrame>& frame);
    void send_to(ViewerId viewer, const json& message);
    void send_to_all(const json& message);
    void tell_state();
    void carry_out(ViewerId viewer, const ViewMessage& message);
    void note(ViewerId viewer, std::uint64_t state, std::uint64_t id);
    WebResponse saved_picture(const std::string& extension);
    WebResponse file_of_job(const std::string& kind, const std::string& file,
                            const std::string& type);
    void start_job(const StartJob& wanted);
    /// Writes the camera's file into `folder`, where the commands write theirs.
    JobPlan plan_job(const StartJob& wanted, const ViewState& state, const fs::path& folder) const;
    void finish_job(const std::string& kind, const fs::path& folder, const JobResult& result,
                    json message);
    std::string scene_with_camera(const fs::path& folder, const ViewState& state) const;
    json compare(const fs::path& folder, const ViewState& state) const;

    ViewOptions options_;
    const ViewModule& module_;
    std::string name_, camera_file_;
    reference::Camera own_;

    mutable std::mutex mutex_;
    std::condition_variable first_;
    std::unique_ptr<ViewServer> server_;
    std::shared_ptr<const EncodedFrame> newest_;
    std::map<ViewerId, Viewer> viewers_;
    bool closing_ = false;

    std::mutex jobs_mutex_;
    std::map<std::string, RunningJob> jobs_;
    // Last, so that they end first: their threads call the above.
    Encoder encoder_;
    RenderLoop loop_;
};

RenderLoopEvents ViewSession::State::events() {
    RenderLoopEvents events;
    events.shown = [this](ShownPicture&& picture) { encoder_.take(std::move(picture)); };
    events.changed = [this](const ChangeEffect& effect) { send_to_all(change_json(effect)); };
    events.picked = [this](std::uint64_t asker, const Pick& pixel, const TracedPath& path) {
        send_to(asker, path_json(pixel, path, loop_.scene()));
    };
    events.failed = [this](const std::string& why) {
        spdlog::warn("{}", why);
        send_to_all({{"type", "failed"}, {"text", why}});
    };
    return events;
}

void ViewSession::State::publish(const std::shared_ptr<const EncodedFrame>& frame) {
    {
        const std::lock_guard lock(mutex_);
        newest_ = frame;
        if (server_) server_->offer(frame);
    }
    first_.notify_all();
}

void ViewSession::State::send_to(ViewerId viewer, const json& message) {
    const std::lock_guard lock(mutex_);
    if (server_) server_->send(viewer, text_of(message));
}

void ViewSession::State::send_to_all(const json& message) {
    const std::string text = text_of(message);
    const std::lock_guard lock(mutex_);
    if (!server_) return;
    for (const auto& [viewer, about] : viewers_) server_->send(viewer, text);
}

void ViewSession::State::tell_state() {
    const ViewState state = loop_.state();
    const bool is_own = camera_json(state.camera) == camera_json(own_);
    json message = state_json(state, loop_.scene(), is_own ? "" : camera_file_);
    message["camera"] = camera_json(state.camera);
    const std::lock_guard lock(mutex_);
    message["viewers"] = viewers_.size();
    if (server_) server_->tell_newest(text_of(message));
}

void ViewSession::State::joined(ViewerId viewer) {
    std::size_t count = 0;
    {
        const std::lock_guard lock(mutex_);
        viewers_[viewer] = {};
        count = viewers_.size();
    }
    loop_.set_viewers(count);
    json hello = hello_json(loop_.scene());
    hello["version"] = options_.version;
    json& cameras = hello["scene"]["cameras"] = json::array();
    for (const scenes::Viewpoint& viewpoint : options_.viewpoints)
        cameras.push_back(viewpoint.name);
    send_to(viewer, hello);
    tell_state();
}

void ViewSession::State::left(ViewerId viewer) {
    std::size_t count = 0;
    {
        const std::lock_guard lock(mutex_);
        viewers_.erase(viewer);
        count = viewers_.size();
        if (closing_) return;
    }
    loop_.set_viewers(count);
    tell_state();
}

void ViewSession::State::note(ViewerId viewer, std::uint64_t state, std::uint64_t id) {
    const std::lock_guard lock(mutex_);
    const auto found = viewers_.find(viewer);
    if (found == viewers_.end() || id == 0) return;
    auto& requests = found->second.requests;
    requests.emplace_back(state, id);
    if (requests.size() > kMostNoted) requests.pop_front();
}

std::string ViewSession::State::frame_header(ViewerId viewer, const ViewFrame& frame) {
    std::string header = static_cast<const EncodedFrame&>(frame).header;
    {
        const std::lock_guard lock(mutex_);
        const auto found = viewers_.find(viewer);
        if (found != viewers_.end()) {
            Viewer& about = found->second;
            while (!about.requests.empty() && about.requests.front().first <= frame.state) {
                about.shown = about.requests.front().second;
                about.requests.pop_front();
            }
            header += ",\"shows\":" + std::to_string(about.shown);
        }
    }
    header += '}';
    const auto length = static_cast<std::uint32_t>(header.size());
    std::string out;
    for (unsigned byte = 0; byte < 4; ++byte) {
        out += static_cast<char>(length >> (8 * byte) & 0xffu);
    }
    return out + header;
}

void ViewSession::State::received(ViewerId viewer, std::string_view text) {
    std::uint64_t id = 0;
    try {
        const ViewMessage message = parse_message(text);
        id = message.id;
        carry_out(viewer, message);
    } catch (const std::exception& error) {  // of ours: it says what was expected
        send_to(viewer, {{"type", "error"}, {"id", id}, {"text", error.what()}});
    }
}

void ViewSession::State::carry_out(ViewerId viewer, const ViewMessage& message) {
    const std::uint64_t id = message.id;
    if (const auto* look = std::get_if<LookAt>(&message.what)) {
        note(viewer, loop_.look(camera_of(*look), look->moving), id);
        if (!look->moving) tell_state();
    } else if (const auto* own = std::get_if<OwnCamera>(&message.what)) {
        if (own->number && *own->number >= options_.viewpoints.size()) {
            throw Error::bad_input("number", "the file has no such camera");
        }
        note(viewer,
             own->number ? loop_.look(options_.viewpoints[*own->number].camera, false)
                         : loop_.own_camera(),
             id);
        tell_state();
    } else if (std::get_if<FrameAll>(&message.what) != nullptr) {
        note(viewer, loop_.frame_all(), id);
        tell_state();
    } else if (const auto* set = std::get_if<SetValues>(&message.what)) {
        note(viewer, loop_.set(*set), id);
        tell_state();
    } else if (const auto* show = std::get_if<ShowAs>(&message.what)) {
        note(viewer, loop_.show(*show), id);
        tell_state();
    } else if (const auto* pick = std::get_if<Pick>(&message.what)) {
        loop_.pick(viewer, *pick);
    } else if (const auto* start = std::get_if<StartJob>(&message.what)) {
        start_job(*start);
    } else if (const auto* stop = std::get_if<StopJob>(&message.what)) {
        const std::lock_guard lock(jobs_mutex_);
        const auto found = jobs_.find(stop->kind);
        if (found != jobs_.end() && found->second.job) found->second.job->stop();
    } else {
        const std::lock_guard lock(mutex_);
        if (server_) server_->acknowledged(viewer);
    }
}

std::string ViewSession::State::scene_with_camera(const fs::path& folder,
                                                  const ViewState& state) const {
    if (camera_json(state.camera) == camera_json(own_)) return loop_.scene().source;
    const fs::path file = folder / camera_file_;
    reference::write_file(file, scenes::camera_text(state.camera));
    return seen_from(loop_.scene().source, file.string());
}

JobPlan ViewSession::State::plan_job(const StartJob& wanted, const ViewState& state,
                                     const fs::path& folder) const {
    using Group = reference::ParameterGroup;
    const PipelineParameters& p = state.parameters;
    const std::string scene = scene_with_camera(folder, state);
    const std::string size = size_text(size_within(p, kJudgedPixels));
    const auto file = [&](const char* name) { return (folder / name).string(); };
    JobPlan plan;
    plan.message = {{"type", "job"}, {"job", wanted.kind}, {"size", size}};
    if (wanted.kind == "verify") {
        plan.commands.push_back(
            {"verify", scene, "--size", size, "--backend", state.backend, "--quick", "--no-golden",
             "--report", folder.string(), "--bounces", std::to_string(p.bounces), "--light-samples",
             std::to_string(p.light_samples), "--seed", std::to_string(p.seed)});
    } else if (wanted.kind == "queues") {
        const auto [width, height] = size_within(p, kJudgedPixels);
        if (wanted.x >= p.image_width || wanted.y >= p.image_height) {
            throw Error::bad_input("pixel", "lies outside of the picture");
        }
        const std::string pixel = fmt::format("{},{}", wanted.x * width / p.image_width,
                                              wanted.y * height / p.image_height);
        std::vector<std::string> capture{"capture", scene,   "-o", file("capture"), "--size",
                                         size,      "--spp", "1",  "--backend",     state.backend};
        const auto words = options_as_words(p, {Group::picture, Group::tree, Group::pipeline});
        capture.insert(capture.end(), words.begin(), words.end());
        plan.commands = {
            capture, {"queues", file("capture"), "--html", file("queues.html"), "--pixel", pixel}};
        plan.message["pixel"] = pixel;
    } else {
        const auto names = RenderLoop::backends();
        if (std::find(names.begin(), names.end(), wanted.backend) == names.end()) {
            throw Error::bad_input("backend",
                                   fmt::format("expected one of {}", fmt::join(names, ", ")));
        }
        const std::string compared = size_text(size_within(p, kComparedPixels));
        plan.message["size"] = compared;
        const auto add_side = [&](const char* side, const std::string& backend,
                                  const std::string& plant) {
            plan.message[side] = backend + (plant.empty() ? "" : " with " + plant);
            std::vector<std::string> render{"render", scene,   "-o", file(side) + ".npy", "--size",
                                            compared, "--spp", "1",  "--backend",         backend};
            auto words = options_as_words(p, {Group::picture});
            if (backend != "embree") {
                const auto more = options_as_words(p, {Group::tree, Group::pipeline});
                words.insert(words.end(), more.begin(), more.end());
            }
            render.insert(render.end(), words.begin(), words.end());
            if (!plant.empty()) render.insert(render.end(), {"--plant", plant});
            plan.commands.push_back(render);
        };
        add_side("a", state.backend, wanted.own_plant);
        add_side("b", wanted.backend, wanted.plant);
    }
    return plan;
}

void ViewSession::State::start_job(const StartJob& wanted) {
    const ViewState state = loop_.state();
    const std::string kind = wanted.kind;
    const bool has_stages = RenderLoop::cannot_show(state.backend, ViewSubject::queues).empty();
    if (kind != "compare" && !has_stages) {
        throw Error::bad_input(kind, state.backend +
                                         " is what others are held against: it has no "
                                         "stages; choose another back end");
    }
    {
        const std::lock_guard lock(jobs_mutex_);
        const auto found = jobs_.find(kind);
        if (found != jobs_.end() && found->second.job && !found->second.job->is_done()) {
            throw Error::bad_input(kind, "runs already; stop it, or wait");
        }
    }
    auto folder = std::make_unique<ScratchFolder>();
    fs::create_directories(folder->path());
    const fs::path path = folder->path();
    const auto [commands, message] = plan_job(wanted, state, path);
    const auto done = [this, kind, about = message, path, state](const JobResult& result) {
        json finished = about;
        if (kind == "compare" && result.exit_code == 0 && !result.stopped && result.signal == 0) {
            try {
                finished.update(compare(path, state));
            } catch (const std::exception& error) {
                finished["text"] = error.what();
            }
        }
        finish_job(kind, path, result, std::move(finished));
    };
    json started = message;
    started["state"] = "running";
    started["command"] = shell_line(commands.front());
    send_to_all(started);
    std::unique_ptr<Job> before;
    {
        const std::lock_guard lock(jobs_mutex_);
        before = std::move(jobs_[kind].job);
    }
    before.reset();
    const std::lock_guard lock(jobs_mutex_);
    RunningJob& entry = jobs_[kind];
    entry.folder = std::move(folder);
    entry.job = std::make_unique<Job>(commands, path, done);
}

void ViewSession::State::finish_job(const std::string& kind, const fs::path& folder,
                                    const JobResult& result, json message) {
    if (!result.stopped) {
        const std::lock_guard lock(jobs_mutex_);
        const auto found = jobs_.find(kind);
        if (found != jobs_.end() && found->second.folder &&
            found->second.folder->path() == folder) {
            found->second.finished = std::move(found->second.folder);
        }
    }
    if (result.stopped) {
        message["state"] = "stopped";
    } else if (result.exit_code == 0 && result.signal == 0) {
        message["state"] = "passed";
    } else if (result.exit_code == 1) {
        message["state"] = "failed";
    } else {
        message["state"] = "broken";
    }
    message["exit_code"] = result.exit_code;
    message["output"] = result.output;
    if (kind == "verify" && !result.stopped) message["link"] = "verify";
    if (kind == "queues" && message["state"] == "passed") message["link"] = "queues";
    send_to_all(message);
}

json ViewSession::State::compare(const fs::path& folder, const ViewState& state) const {
    const auto a = read_radiance((folder / "a.npy").string());
    const auto b = read_radiance((folder / "b.npy").string());
    const PictureComparison found = compare_pictures(a, b, state.exposure, state.tone);
    const auto save = [&](const char* name, const ColorImage& image) {
        reference::write_file(folder / name,
                              module_.png(image.rgb.data(), static_cast<int>(image.width),
                                          static_cast<int>(image.height)));
    };
    save("a.png", found.a);
    save("b.png", found.b);
    save("difference.png", found.difference);
    json out{{"pixels", found.pixels},   {"different", found.different},
             {"largest", found.largest}, {"first", {found.first_x, found.first_y}},
             {"width", found.a.width},   {"height", found.a.height}};
    out["text"] = found.different == 0
                      ? fmt::format("the same bits in all {} pixels", found.pixels)
                      : fmt::format("{} of {} pixels differ, by up to {:.3g}; the first is {},{}",
                                    found.different, found.pixels, found.largest, found.first_x,
                                    found.first_y);
    return out;
}

WebResponse ViewSession::State::file_of_job(const std::string& kind, const std::string& file,
                                            const std::string& type) {
    const std::lock_guard lock(jobs_mutex_);
    const auto found = jobs_.find(kind);
    if (found == jobs_.end() || !found->second.finished)
        return not_found("nobody has asked for it yet");
    return {200, type, bytes_of(found->second.finished->path() / file), {}};
}

WebResponse ViewSession::State::saved_picture(const std::string& extension) {
    std::uint32_t samples = 0;
    ViewState state;
    const auto picture = loop_.picture_at_rest(samples, state);
    if (!picture) return not_found("no picture of full size has been at rest yet");
    const ScratchFolder folder;
    fs::create_directories(folder.path());
    RenderOutput output;
    output.file = (folder.path() / ("view." + extension)).string();
    output.exposure = state.exposure;
    PipelineParameters p = state.parameters;
    p.spp = samples;
    p.filter = reference::Filter::none;
    output.provenance = {{"scotty:scene", loop_.scene().name},
                         {"scotty:backend", state.backend},
                         {"scotty:camera", camera_json(state.camera).dump()},
                         {"scotty:parameters", to_json(p).dump()},
                         {"scotty:version", options_.version}};
    write_picture(output, p, *picture, samples);
    return {200, extension == "png" ? "image/png" : "application/octet-stream",
            bytes_of(output.file), name_ + "." + extension};
}

WebResponse ViewSession::State::get(const std::string& path) {
    constexpr const char* kHtml = "text/html; charset=utf-8";
    try {
        if (path.empty()) return {200, kHtml, filled_page("view.html", {}), {}};
        if (path == "camera") {
            return {200, "application/json", scenes::camera_text(loop_.state().camera),
                    camera_file_};
        }
        for (const char* extension : {"exr", "npy", "png"}) {
            if (path == std::string("picture.") + extension) return saved_picture(extension);
        }
        if (path == "verify") return file_of_job("verify", "verify.html", kHtml);
        if (path == "queues") return file_of_job("queues", "queues.html", kHtml);
        for (const char* name : {"a.png", "b.png", "difference.png"}) {
            if (path == std::string("compare/") + name) {
                return file_of_job("compare", name, "image/png");
            }
        }
        return not_found("no such page");
    } catch (const std::exception& error) {
        return {500, "text/plain; charset=utf-8", std::string(error.what()) + "\n", {}};
    }
}

ViewSession::ViewSession(reference::Scene scene, ViewState first, ViewOptions options)
    : state_(std::make_unique<State>(std::move(scene), std::move(first), std::move(options))) {}
ViewSession::~ViewSession() = default;
std::string ViewSession::link() const { return state_->link(); }
void ViewSession::wait_for_first_picture() { state_->wait_for_first_picture(); }

}  // namespace scotty::verify
