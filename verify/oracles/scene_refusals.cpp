#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "verify/oracles/refusal_check.h"

namespace scotty::verify {

using reference::Camera;
using reference::Light;
using reference::LightKind;
using reference::Material;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
// The limits that docs/scenes.md states, written down once more: a judge does not ask the judged.
constexpr float kFarthest = 1e12f;
constexpr float kBrightest = 1e12f;

float above(float value) { return std::nextafter(value, reference::kInfinity); }
float below(float value) { return std::nextafter(value, -reference::kInfinity); }

std::set<std::size_t> ends_and_middle(std::size_t size) {
    if (size == 0) return {};
    return {0, size / 2, size - 1};
}

class SceneSpoiler {
 public:
    SceneSpoiler(const Scene& scene, const SceneValidator& validator)
        : scene_(scene), validator_(validator), fingerprint_(fingerprint(scene)) {}

    std::vector<Failure> run() {
        spoil_tables();
        for (const std::size_t i : ends_and_middle(scene_.vertices.size())) spoil_vertex(i);
        for (const std::size_t i : ends_and_middle(scene_.triangles.size())) spoil_triangle(i);
        for (const std::size_t i : ends_and_middle(scene_.normals.size())) spoil_normal(i);
        for (const std::size_t i : ends_and_middle(scene_.materials.size())) spoil_material(i);
        for (const std::size_t i : ends_and_middle(scene_.lights.size())) spoil_light(i);
        spoil_camera();
        return std::move(failures_);
    }

 private:
    using Edit = std::function<void(Scene&)>;

    void fail(const std::string& what, const std::string& sentence) {
        Failure failure;
        failure.invariant = kRefusal;
        failure.stage = "scene";
        failure.field = what;
        failure.sentence = sentence;
        failures_.push_back(std::move(failure));
    }

    /// An error that names `element`, such as "vertex 3".
    void refused(const std::string& element, const std::string& what, const Edit& edit) {
        Scene copy = scene_;
        edit(copy);
        try {
            validator_(copy);
        } catch (const reference::Error& error) {
            const std::string text = error.what();
            if (text.find(element) != std::string::npos) return;
            fail(what, fmt::format("{} is refused without naming it: {}", what, text));
            return;
        }
        fail(what, what + " is taken for valid");
    }

    /// No error; and another scene, unless it was so before.
    void taken(const std::string& what, const Edit& edit) {
        Scene copy = scene_;
        edit(copy);
        try {
            validator_(copy);
        } catch (const reference::Error& error) {
            fail(what, fmt::format("{} is refused: {}", what, error.what()));
        }
    }
    void changes(const std::string& what, const Edit& edit) {
        taken(what, edit);
        Scene copy = scene_;
        edit(copy);
        if (fingerprint(copy) != fingerprint_) return;
        fail(what, fmt::format("{} leaves the scene's fingerprint as it is", what));
    }

    void spoil_tables() {
        const std::size_t vertices = scene_.vertices.size();
        refused("geometry", "a scene without triangles", [](Scene& s) {
            s.triangles.clear();
            s.material_of.clear();
        });
        refused("material indices", "a triangle without a material",
                [](Scene& s) { s.material_of.pop_back(); });
        refused("material indices", "a material of no triangle",
                [](Scene& s) { s.material_of.push_back(0); });
        refused("normals", "one normal more than vertices",
                [=](Scene& s) { s.normals.assign(vertices + 1, Vec3(0.0f, 0.0f, 1.0f)); });
        if (vertices > 1) {
            refused("normals", "one normal less than vertices",
                    [=](Scene& s) { s.normals.assign(vertices - 1, Vec3(0.0f, 0.0f, 1.0f)); });
        }
    }

    template <class At>
    void spoil_axes(const std::string& element, const char* field, float low, float high,
                    const At& at) {
        for (int axis = 0; axis < 3; ++axis) {
            const std::string what = fmt::format("{}, {}.{}", element, field, "xyz"[axis]);
            spoil_range(element, what, low, high,
                        [&](Scene& s, float value) { at(s)[axis] = value; });
        }
    }
    template <class Set>
    void spoil_range(const std::string& element, const std::string& what, float low, float high,
                     const Set& set) {
        for (const float value :
             {kNan, reference::kInfinity, -reference::kInfinity, above(high), below(low)}) {
            refused(element, fmt::format("{} = {}", what, value), [&](Scene& s) { set(s, value); });
        }
        for (const float value : {low, high}) {
            taken(fmt::format("{} = {}", what, value), [&](Scene& s) { set(s, value); });
        }
    }

    void spoil_vertex(std::size_t i) {
        const std::string element = fmt::format("vertex {}", i);
        spoil_axes(element, "position", -kFarthest, kFarthest,
                   [i](Scene& s) -> Vec3& { return s.vertices[i]; });
        for (int axis = 0; axis < 3; ++axis) {
            changes(fmt::format("{} moved along {}", element, "xyz"[axis]),
                    [=](Scene& s) { s.vertices[i][axis] = above(s.vertices[i][axis]); });
        }
    }

    void spoil_triangle(std::size_t i) {
        const std::string element = fmt::format("triangle {}", i);
        const auto vertices = static_cast<std::uint32_t>(scene_.vertices.size());
        for (std::size_t corner = 0; corner < 3; ++corner) {
            for (const std::uint32_t index : {vertices, 0xffffffffu}) {
                refused(element, fmt::format("{}, corner {} = {}", element, corner, index),
                        [=](Scene& s) { s.triangles[i][corner] = index; });
            }
            const std::uint32_t other =
                scene_.triangles[i][corner] == vertices - 1 ? 0 : vertices - 1;
            if (vertices > 1) {
                changes(fmt::format("{}, corner {} = {}", element, corner, other),
                        [=](Scene& s) { s.triangles[i][corner] = other; });
            }
        }
        const auto materials = static_cast<std::uint32_t>(scene_.materials.size());
        refused(element, fmt::format("{}, material = {}", element, materials),
                [=](Scene& s) { s.material_of[i] = materials; });
        taken(fmt::format("{}, material = {}", element, materials - 1),
              [=](Scene& s) { s.material_of[i] = materials - 1; });
        if (materials > 1) {
            const std::uint32_t other = scene_.material_of[i] == 0 ? 1 : 0;
            changes(fmt::format("{}, material = {}", element, other),
                    [=](Scene& s) { s.material_of[i] = other; });
        }
    }

    void spoil_normal(std::size_t i) {
        const Vec3 sound = scene_.normals[i];
        if (reference::is_zero(sound)) return;
        const auto repaired = [&](const char* how, const Vec3& spoiled, const Vec3& expected) {
            const std::string what = fmt::format("normal {} {}", i, how);
            Scene copy = scene_;
            copy.warnings.clear();
            copy.normals[i] = spoiled;
            validator_(copy);
            const Vec3 off = copy.normals[i] - expected;
            if (!(reference::max_abs(off) <= 1e-6f)) fail(what, what + " is not repaired");
            const bool said = !copy.warnings.empty() &&
                              copy.warnings.front().find("1 normals") != std::string::npos;
            if (!said) fail(what, what + " is repaired, and no warning says so");
        };
        repaired("of twice the length", sound * 2.0f, sound);
        repaired("of half the length", sound * 0.5f, sound);
        repaired("that is no number", Vec3(kNan, sound.y, sound.z), Vec3(0.0f, 0.0f, 0.0f));
        changes(fmt::format("normal {} turned over", i),
                [=](Scene& s) { s.normals[i] = sound * -1.0f; });
    }

    void spoil_material(std::size_t i) {
        const std::string element = fmt::format("material {}", i);
        const auto at = [i](Scene& s) -> Material& { return s.materials[i]; };
        spoil_axes(element, "reflectance", 0.0f, 1.0f,
                   [&](Scene& s) -> Vec3& { return at(s).reflectance; });
        spoil_axes(element, "transmittance", 0.0f, 1.0f,
                   [&](Scene& s) -> Vec3& { return at(s).transmittance; });
        spoil_axes(element, "emission", 0.0f, kBrightest,
                   [&](Scene& s) -> Vec3& { return at(s).emission; });
        spoil_range(element, element + ", roughness", 0.0f, 1.0f, [&](Scene& s, float value) {
            at(s).kind = MaterialKind::conductor;
            at(s).ior = value;
        });
        spoil_range(element, element + ", index of refraction", 0.01f, 100.0f,
                    [&](Scene& s, float value) {
                        at(s).kind = MaterialKind::glass;
                        at(s).ior = value;
                    });
        refused(element, element + ", kind = 4",
                [&](Scene& s) { at(s).kind = static_cast<MaterialKind>(4); });
        refused(element, element + ", emission_is_sampled = 2",
                [&](Scene& s) { at(s).emission_is_sampled = 2; });
        changes(element + ", emission_is_sampled",
                [&](Scene& s) { at(s).emission_is_sampled ^= 1u; });
        for (int axis = 0; axis < 3; ++axis) {
            const auto moved = [axis](Vec3& v) {
                v[axis] = v[axis] > 0.5f ? below(v[axis]) : above(v[axis]);
            };
            const std::string of = fmt::format("{}, {{}}.{}", element, "xyz"[axis]);
            changes(fmt::format(fmt::runtime(of), "reflectance"),
                    [&](Scene& s) { moved(at(s).reflectance); });
            changes(fmt::format(fmt::runtime(of), "transmittance"),
                    [&](Scene& s) { moved(at(s).transmittance); });
            changes(fmt::format(fmt::runtime(of), "emission"),
                    [&](Scene& s) { moved(at(s).emission); });
        }
    }

    void spoil_light(std::size_t i) {
        const std::string element = fmt::format("light {}", i);
        const auto at = [i](Scene& s) -> Light& { return s.lights[i]; };
        const Light& light = scene_.lights[i];
        spoil_axes(element, "radiance", 0.0f, kBrightest,
                   [&](Scene& s) -> Vec3& { return at(s).radiance; });
        spoil_axes(element, "position", -kFarthest, kFarthest,
                   [&](Scene& s) -> Vec3& { return at(s).position; });
        refused(element, element + ", kind = 7",
                [&](Scene& s) { at(s).kind = static_cast<LightKind>(7); });
        const bool is_area =
            light.kind == LightKind::parallelogram || light.kind == LightKind::triangle;
        const bool has_direction = light.kind == LightKind::directional ||
                                   light.kind == LightKind::hemisphere ||
                                   light.kind == LightKind::spot;
        if (is_area || has_direction) {
            for (const float factor : {1.01f, 0.99f, 0.0f, kNan}) {
                refused(element, fmt::format("{}, normal times {}", element, factor),
                        [&](Scene& s) { at(s).normal = at(s).normal * factor; });
            }
            changes(element + ", normal turned over",
                    [&](Scene& s) { at(s).normal = at(s).normal * -1.0f; });
        }
        if (light.kind == LightKind::spot) spoil_cone(element, i);
        if (!is_area) return;
        for (const float factor : {1.01f, 0.99f, 0.0f, -1.0f, 2.0f, 0.5f, kNan}) {
            refused(element, fmt::format("{}, area times {}", element, factor),
                    [&](Scene& s) { at(s).area *= factor; });
        }
        refused(element, element + ", normal along an edge", [&](Scene& s) {
            at(s).normal = reference::normalize_or(light.edge_x, light.normal);
        });
        for (int axis = 0; axis < 3; ++axis) {
            for (const float value :
                 {kNan, reference::kInfinity, above(kFarthest), below(-kFarthest)}) {
                refused(element, fmt::format("{}, edge_x.{} = {}", element, "xyz"[axis], value),
                        [&](Scene& s) { at(s).edge_x[axis] = value; });
                refused(element, fmt::format("{}, edge_y.{} = {}", element, "xyz"[axis], value),
                        [&](Scene& s) { at(s).edge_y[axis] = value; });
            }
        }
    }

    void spoil_cone(const std::string& element, std::size_t i) {
        const auto set = [i](Scene& s, float inner, float outer) {
            set_spot_cone(s.lights[i], {inner, outer});
        };
        for (const auto& [inner, outer] : {std::pair{above(1.0f), 0.5f},
                                           {below(-1.0f), -1.0f},
                                           {kNan, 0.5f},
                                           {0.5f, kNan},
                                           {0.5f, above(0.5f)},
                                           {1.0f, 1.0f},
                                           {0.5f, below(-1.0f)}}) {
            refused(element, fmt::format("{}, cone {} to {}", element, inner, outer),
                    [&, in = inner, out = outer](Scene& s) { set(s, in, out); });
        }
        for (const auto& [inner, outer] :
             {std::pair{1.0f, below(1.0f)}, {0.5f, 0.5f}, {-1.0f, -1.0f}, {1.0f, -1.0f}}) {
            taken(fmt::format("{}, cone {} to {}", element, inner, outer),
                  [&, in = inner, out = outer](Scene& s) { set(s, in, out); });
        }
    }

    void spoil_camera() {
        const std::string element = "camera 0";
        spoil_axes(element, "position", -kFarthest, kFarthest,
                   [](Scene& s) -> Vec3& { return s.camera.position; });
        spoil_range(element, "camera, tan_half_fov", 1e-4f, 1e4f,
                    [](Scene& s, float value) { s.camera.tan_half_fov = value; });
        spoil_range(element, "camera, tan_half_width", 1e-4f, 1e4f,
                    [](Scene& s, float value) { s.camera.tan_half_width = value; });
        taken("camera, tan_half_width = 0", [](Scene& s) { s.camera.tan_half_width = 0.0f; });
        for (Vec3 Camera::*axis : {&Camera::right, &Camera::up, &Camera::forward}) {
            for (const float factor : {1.01f, 0.99f, -1.0f, 0.0f, kNan}) {
                refused(element, fmt::format("camera, an axis times {}", factor),
                        [=](Scene& s) { s.camera.*axis = s.camera.*axis * factor; });
            }
        }
        refused(element, "camera, right and up exchanged",
                [](Scene& s) { std::swap(s.camera.right, s.camera.up); });
        refused(element, "camera, up and forward exchanged",
                [](Scene& s) { std::swap(s.camera.up, s.camera.forward); });
        changes("camera moved", [](Scene& s) { s.camera.position.x = above(s.camera.position.x); });
        changes("camera's field of view",
                [](Scene& s) { s.camera.tan_half_fov = above(s.camera.tan_half_fov); });
    }

    const Scene& scene_;
    const SceneValidator& validator_;
    std::uint64_t fingerprint_;
    std::vector<Failure> failures_;
};

}  // namespace

std::vector<Failure> check_scene_refusals(const Scene& scene, const SceneValidator& validator) {
    return SceneSpoiler(scene, validator).run();
}

std::vector<Failure> check_parameter_refusals(const ParameterValidator& validator) {
    std::vector<Failure> failures;
    const auto ask = [&](const reference::ParameterInfo& info, std::uint64_t value, bool valid) {
        reference::PipelineParameters p;
        info.set(p, value);
        bool refused = false;
        try {
            validator(p);
        } catch (const reference::Error& error) {
            refused = std::string(error.what()).find(info.title) != std::string::npos;
        }
        if (refused != valid) return;
        Failure failure;
        failure.invariant = kRefusal;
        failure.stage = "parameters";
        failure.field = info.name;
        failure.sentence =
            fmt::format("{} = {} is {}", info.name, value, valid ? "refused" : "taken for valid");
        failures.push_back(std::move(failure));
    };
    for (const reference::ParameterInfo& info : reference::kParameters) {
        if (!info.words.empty()) continue;
        if (!info.only.empty()) {
            for (const std::uint64_t value : info.only) {
                ask(info, value, true);
                ask(info, value + 1, false);
            }
            continue;
        }
        if (info.name != "image_width" && info.name != "image_height") ask(info, info.high, true);
        ask(info, info.low, true);
        constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
        if (info.low > 0) ask(info, info.low - 1, false);
        if (info.high < kMost) ask(info, info.high + 1, false);
        if (info.multiple_of > 1) ask(info, info.low + 1, false);
    }
    return failures;
}

}  // namespace scotty::verify
