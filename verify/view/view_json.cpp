#include "verify/view/view_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reference/contract/parameter_table.h"
#include "reference/numerics/path.h"
#include "scenes/camera_file.h"

namespace scotty::verify {

using nlohmann::json;
using reference::ParameterGroup;
using reference::ParameterInfo;
using reference::Vec3;

namespace {

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

const char* group_name(ParameterGroup group) {
    switch (group) {
        case ParameterGroup::picture:
            return "picture";
        case ParameterGroup::tree:
            return "tree";
        case ParameterGroup::pipeline:
            return "pipeline";
        case ParameterGroup::filter:
            return "filter";
        case ParameterGroup::arithmetic:
            break;
    }
    return "arithmetic";
}

json parameter_json(const ParameterInfo& info) {
    json out{{"name", info.name},
             {"title", info.title},
             {"help", info.help},
             {"group", group_name(info.group)},
             {"low", info.low},
             {"high", info.high},
             {"multiple_of", info.multiple_of},
             {"valid", valid_values(info)}};
    if (!info.only.empty()) out["only"] = std::vector(info.only.begin(), info.only.end());
    if (!info.words.empty()) {
        out["words"] = std::vector<std::string>(info.words.begin(), info.words.end());
    }
    return out;
}

}  // namespace

json camera_json(const reference::Camera& camera) {
    return {{"position", to_json(camera.position)},
            {"right", to_json(camera.right)},
            {"up", to_json(camera.up)},
            {"forward", to_json(camera.forward)},
            {"tan_half_fov", camera.tan_half_fov},
            {"tan_half_width", camera.tan_half_width}};
}

json frame_json(const ShownPicture& picture) {
    const ViewState& state = picture.shows;
    const reference::PipelineParameters& p = state.parameters;
    reference::Camera camera = state.camera;
    camera.tan_half_fov = vertical_tangent(camera, static_cast<float>(p.image_width),
                                           static_cast<float>(p.image_height));
    camera.tan_half_width = 0.0f;
    json out{{"state", picture.state},
             {"full", {p.image_width, p.image_height}},
             {"samples", picture.samples},
             {"target", p.spp},
             {"rest", picture.at_rest},
             {"what", to_string(state.subject)},
             {"backend", state.backend},
             {"camera", camera_json(camera)},
             {"render_seconds", picture.render_seconds},
             {"samples_per_second", picture.samples_per_second},
             {"device_bytes", picture.device_bytes},
             {"statistics", picture.statistics}};
    out["noise"] = 0.0;  // not known
    out["filter"] = state.filtered && p.filter != reference::Filter::none &&
                            picture.samples < p.filter_threshold
                        ? to_string(p.filter)
                        : "none";
    if (!picture.legend.unit.empty()) {
        out["legend"] = {{"low", picture.legend.low},
                         {"high", picture.legend.high},
                         {"logarithmic", picture.legend.logarithmic},
                         {"unit", picture.legend.unit}};
    }
    return out;
}

json hello_json(const reference::Scene& scene) {
    const reference::Bounds box = bounds_of(scene);
    json out{{"type", "hello"},
             {"protocol", 1},
             {"scene",
              {{"name", scene.name},
               {"source", scene.source},
               {"triangles", scene.triangles.size()},
               {"low", to_json(box.low)},
               {"high", to_json(box.high)}}},
             {"backends", RenderLoop::backends()},
             {"parameters", json::array()},
             {"subjects", json::array()},
             {"tones", json::array()},
             {"cannot", json::object()}};
    for (const ParameterInfo& info : reference::kParameters) {
        if (info.name != "samples_per_pass") out["parameters"].push_back(parameter_json(info));
    }
    for (std::size_t i = 0; i < kViewSubjects; ++i) {
        out["subjects"].push_back(to_string(static_cast<ViewSubject>(i)));
    }
    for (const ToneMap tone : {ToneMap::clamp, ToneMap::reinhard, ToneMap::filmic}) {
        out["tones"].push_back(to_string(tone));
    }
    for (const std::string& backend : RenderLoop::backends()) {
        const std::string why = RenderLoop::cannot_show(backend, ViewSubject::queues);
        if (!why.empty()) out["cannot"][backend] = why;
    }
    return out;
}

json state_json(const ViewState& state, const reference::Scene& scene,
                const std::string& camera_file) {
    json parameters = json::object();
    for (const ParameterInfo& info : reference::kParameters) {
        parameters[std::string(info.name)] = text_of(info, state.parameters);
    }
    std::vector<std::string> words{"scotty"};
    const auto render = render_words(state, seen_from(scene.source, camera_file), "view.exr");
    words.insert(words.end(), render.begin(), render.end());
    return {{"type", "state"},
            {"backend", state.backend},
            {"parameters", std::move(parameters)},
            {"moving_samples", state.moving_samples},
            {"what", to_string(state.subject)},
            {"tone", to_string(state.tone)},
            {"exposure", state.exposure},
            {"filtered", state.filtered},
            {"measured", state.measured},
            {"command", shell_line(words)},
            {"camera_file", camera_file}};
}

json change_json(const ChangeEffect& effect) {
    const double before = effect.seconds_before / effect.samples;
    const double after = effect.seconds_after / effect.samples;
    std::string verdict;
    if (effect.same_picture) {
        verdict = fmt::format("the same bits ({})", effect.hash);
    } else if (effect.should_be_same) {
        verdict = "ANOTHER PICTURE, which this change must not make";
    } else {
        verdict = fmt::format("another picture, as it should be ({})", effect.hash);
    }
    return {{"type", "changed"},
            {"what", effect.what},
            {"samples", effect.samples},
            {"milliseconds_before", 1e3 * before},
            {"milliseconds_after", 1e3 * after},
            {"same_picture", effect.same_picture},
            {"fault", effect.should_be_same && !effect.same_picture},
            {"text", fmt::format("{}: {:.3g} ms a sample, was {:.3g} ms ({:.2f} times as fast); "
                                 "picture of {} samples: {}",
                                 effect.what, 1e3 * after, 1e3 * before,
                                 after > 0.0 ? before / after : 0.0, effect.samples, verdict)}};
}

json path_json(const Pick& pixel, const TracedPath& path, const reference::Scene& scene) {
    json out{{"type", "path"},           {"x", pixel.x},    {"y", pixel.y},
             {"batch", path.batch},      {"ray", path.ray}, {"origin", to_json(path.origin)},
             {"vertices", json::array()}};
    static constexpr const char* kMaterials[]{"diffuse", "mirror", "glass", "conductor"};
    static_assert(std::size(kMaterials) == reference::kMaterialKinds);
    for (const PathVertex& vertex : path.vertices) {
        const auto& material = scene.materials[scene.material_of[vertex.primitive]];
        json lights = json::array();
        for (const PathVertex::Light& light : vertex.lights) {
            lights.push_back({{"end", to_json(light.end)}, {"blocked", light.blocked}});
        }
        out["vertices"].push_back(
            {{"position", to_json(vertex.position)},
             {"primitive", vertex.primitive},
             {"distance", vertex.distance},
             {"material", kMaterials[static_cast<std::size_t>(material.kind)]},
             {"lights", std::move(lights)}});
    }
    if (path.escaped) out["escape"] = to_json(path.escape_direction);
    return out;
}

std::string seen_from(const std::string& specification, const std::string& camera_file) {
    std::string scene = specification;
    if (camera_file.empty()) return scene;
    scenes::take_camera_file(scene);
    const bool has_choices = scene.rfind('#') != std::string::npos;
    return scene + (has_choices ? "," : "#") + "camera=" + camera_file;
}

std::vector<std::string> render_words(const ViewState& state, const std::string& scene,
                                      const std::string& file) {
    const reference::PipelineParameters& p = state.parameters;
    std::vector<std::string> words{
        "render",    scene,         "-o",     file,
        "--backend", state.backend, "--size", fmt::format("{}x{}", p.image_width, p.image_height)};
    for (const ParameterInfo& info : reference::kParameters) {
        const bool is_size = info.option == "--size";
        const bool of_picture = info.group == ParameterGroup::picture && !is_size;
        const bool of_work = state.backend != "embree" && info.group != ParameterGroup::picture &&
                             info.group != ParameterGroup::filter &&
                             info.name != "samples_per_pass";
        const std::string value = text_of(info, p);
        const bool is_standard = value == text_of(info, reference::PipelineParameters());
        if ((of_picture || of_work) && (info.name == "spp" || of_work || !is_standard)) {
            words.insert(words.end(), {std::string(info.option), value});
        }
    }
    return words;
}

std::string shell_line(const std::vector<std::string>& words) {
    constexpr const char* kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:=,+";
    std::string line;
    for (const std::string& word : words) {
        if (!line.empty()) line += ' ';
        if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) {
            line += word;
            continue;
        }
        line += '\'';
        for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
        line += '\'';
    }
    return line;
}

}  // namespace scotty::verify
