#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <string_view>
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
    SceneSpoiler(const Scene& scene, const SceneValidator& validator, std::string* said)
        : scene_(scene), validator_(validator), said_(said), fingerprint_(fingerprint(scene)) {}

    std::vector<Failure> run() {
        spoil_tables();
        for (const std::size_t i : ends_and_middle(scene_.vertices.size())) spoil_vertex(i);
        for (const std::size_t i : ends_and_middle(scene_.triangles.size())) spoil_triangle(i);
        for (const std::size_t i : ends_and_middle(scene_.normals.size())) spoil_normal(i);
        for (const std::size_t i : ends_and_middle(scene_.materials.size())) spoil_material(i);
        for (const std::size_t i : ends_and_middle(scene_.lights.size())) spoil_light(i);
        spoil_camera();
        judge_areas();
        judge_darkness();
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
            if (said_ != nullptr) *said_ += text + '\n';
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

    /// Warnings of the scene with other triangles, whose corners are these.
    using Corners = std::array<Vec3, 3>;
    std::vector<std::string> warnings_of(const std::vector<Corners>& triangles) {
        Scene copy = scene_;
        copy.vertices.clear();
        copy.normals.clear();
        copy.triangles.clear();
        copy.material_of.assign(triangles.size(), 0);
        for (const Corners& corners : triangles) {
            const auto first = static_cast<std::uint32_t>(copy.vertices.size());
            copy.vertices.insert(copy.vertices.end(), corners.begin(), corners.end());
            copy.triangles.push_back({first, first + 1, first + 2});
        }
        return warnings_of(copy);
    }
    /// The same of a scene that is valid, and may be repaired.
    const std::vector<std::string>& warnings_of(Scene& scene) {
        scene.warnings.clear();
        try {
            validator_(scene);
        } catch (const reference::Error& error) {
            fail("warnings", fmt::format("a sound scene is refused: {}", error.what()));
        }
        if (said_ != nullptr) *said_ += fmt::format("{}\n", fmt::join(scene.warnings, "\n"));
        return scene.warnings;
    }
    static bool says(const std::vector<std::string>& warnings, std::string_view part) {
        return std::any_of(warnings.begin(), warnings.end(), [&](const std::string& warning) {
            return warning.find(part) != std::string::npos;
        });
    }

    /// Triangles without area are counted, and the first is named; the thinnest have some.
    void judge_areas() {
        const Vec3 a(1.0f, 2.0f, 5.0f);
        const auto at = [&](float x, float y, float z) { return a + Vec3(x, y, z); };
        const std::vector<std::pair<const char*, Corners>> empty{
            {"along x", {a, at(1.0f, 0.0f, 0.0f), at(3.0f, 0.0f, 0.0f)}},
            {"along y", {a, at(0.0f, 1.0f, 0.0f), at(0.0f, 3.0f, 0.0f)}},
            {"along z", {a, at(0.0f, 0.0f, 1.0f), at(0.0f, 0.0f, 3.0f)}},
            {"aslant", {a, at(1.0f, -2.0f, 4.0f), at(2.0f, -4.0f, 8.0f)}},
            {"of two points", {a, a, at(1.0f, 2.0f, 3.0f)}},
            {"of two other points", {a, at(1.0f, 2.0f, 3.0f), a}},
            {"of two points behind", {a, at(1.0f, 2.0f, 3.0f), at(1.0f, 2.0f, 3.0f)}},
            {"of one point", {a, a, a}}};
        const float thin = above(8.0f) - 8.0f;
        const std::vector<std::pair<const char*, Corners>> sound{
            {"across z", {a, at(1.0f, 0.0f, 0.0f), at(0.0f, 2.0f, 0.0f)}},
            {"across x", {a, at(0.0f, 1.0f, 0.0f), at(0.0f, 0.0f, 2.0f)}},
            {"across y", {a, at(1.0f, 0.0f, 0.0f), at(0.0f, 0.0f, 2.0f)}},
            {"as thin as x can be", {a, at(1.0f, 2.0f, 4.0f), at(2.0f + thin, 4.0f, 8.0f)}},
            {"as thin as y can be", {a, at(1.0f, 2.0f, 4.0f), at(2.0f, 4.0f + thin, 8.0f)}},
            {"as thin as z can be", {a, at(1.0f, 2.0f, 4.0f), at(2.0f, 4.0f, 8.0f + 2.0f * thin)}}};
        for (const auto& [how, corners] : empty) {
            const std::string what = fmt::format("a triangle {}", how);
            const auto last = warnings_of({sound[0].second, corners});
            if (!says(last, "1 triangles have zero area") || !says(last, "is triangle 1"))
                fail(what, what + " is not reported as empty");
            const auto both = warnings_of({corners, sound[0].second, corners});
            if (!says(both, "2 triangles have zero area") || !says(both, "is triangle 0"))
                fail(what, what + " is not counted twice");
        }
        for (const auto& [how, corners] : sound) {
            const std::string what = fmt::format("a triangle {}", how);
            if (says(warnings_of({corners}), "zero area")) fail(what, what + " is called empty");
        }
    }

    /// A scene is dark where nothing in it shines, and only there.
    void judge_darkness() {
        const auto dark = [&](const char* what, bool expected, const Edit& edit) {
            Scene copy = scene_;
            for (Light& light : copy.lights) light.radiance = Vec3(0.0f);
            for (Material& material : copy.materials) material.emission = Vec3(0.0f);
            edit(copy);
            if (says(warnings_of(copy), "black") == expected) return;
            fail(what, fmt::format("{} is {}called black", what, expected ? "not " : ""));
        };
        dark("a scene in which nothing shines", true, [](Scene&) {});
        dark("a scene with one material that shines", false,
             [](Scene& s) { s.materials.back().emission.z = 1.0f; });
        if (scene_.lights.empty()) return;
        dark("a scene with one light that shines", false,
             [](Scene& s) { s.lights.back().radiance.y = 1.0f; });
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
            copy.normals[i] = spoiled;
            warnings_of(copy);
            const Vec3 off = copy.normals[i] - expected;
            // Flat is flat: nothing that normalises to a direction.
            const bool is_flat = reference::is_zero(copy.normals[i]);
            if (!(reference::max_abs(off) <= 1e-6f) || is_flat != reference::is_zero(expected))
                fail(what, what + " is not repaired");
            const bool said = !copy.warnings.empty() &&
                              copy.warnings.front().find("1 normals") != std::string::npos;
            if (!said) fail(what, what + " is repaired, and no warning says so");
        };
        repaired("of twice the length", sound * 2.0f, sound);
        repaired("of half the length", sound * 0.5f, sound);
        repaired("a thousandth too long", sound * 1.001f, sound);
        repaired("of nearly no length", Vec3(0.0f, 1e-30f, 0.0f), Vec3(0.0f, 1.0f, 0.0f));
        repaired("without end", Vec3(reference::kInfinity, 0.0f, 0.0f), Vec3(0.0f, 0.0f, 0.0f));
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
    std::string* said_;
    std::uint64_t fingerprint_;
    std::vector<Failure> failures_;
};

}  // namespace

std::vector<Failure> check_scene_refusals(const Scene& scene, const SceneValidator& validator,
                                          std::string* said) {
    return SceneSpoiler(scene, validator, said).run();
}

std::vector<Failure> check_parameter_refusals(const ParameterValidator& validator,
                                              std::string* said) {
    std::vector<Failure> failures;
    const auto fail = [&](std::string_view of, const std::string& sentence) {
        Failure failure;
        failure.invariant = kRefusal;
        failure.stage = "parameters";
        failure.field = of;
        failure.sentence = sentence;
        failures.push_back(std::move(failure));
    };
    /// Whether it throws an error that names `title`.
    const auto is_refused = [&](std::string_view title, const std::function<void()>& run) {
        try {
            run();
        } catch (const reference::Error& error) {
            if (said != nullptr) *said += std::string(error.what()) + '\n';
            return std::string_view(error.what()).find(title) != std::string_view::npos;
        }
        return false;
    };
    const auto ask = [&](const reference::ParameterInfo& info, std::uint64_t value, bool valid) {
        reference::PipelineParameters p;
        info.set(p, value);
        if (is_refused(info.title, [&] { validator(p); }) != valid) return;
        fail(info.name,
             fmt::format("{} = {} is {}", info.name, value, valid ? "refused" : "taken for valid"));
    };
    for (const reference::ParameterInfo& info : reference::kParameters) {
        for (const char* text : {"", "x", "-1", "1x", "18446744073709551616", "0.5", " 8", "0x8"}) {
            reference::PipelineParameters p;
            if (is_refused(info.title, [&] { set_from_text(info, p, text); })) continue;
            if (std::string_view(text) == "-1" && info.high >> 63 != 0) continue;
            fail(info.name, fmt::format("{} is read from '{}'", info.name, text));
        }
        reference::PipelineParameters p;
        const std::string word = text_of(info, p);
        info.set(p, info.get(p) ^ 1u);
        if (is_refused(info.title, [&] { set_from_text(info, p, word); }) ||
            text_of(info, p) != word) {
            fail(info.name, fmt::format("{} is not read from '{}'", info.name, word));
        }
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
    const auto ask_tree = [&](int width, int leaf, std::string_view title) {
        reference::BvhParameters p;
        p.width = width;
        p.max_leaf_size = leaf;
        if (is_refused(title.empty() ? "BVH" : title, [&] { validate(p); }) != title.empty())
            return;
        fail("tree", fmt::format("a tree of width {} with leaves of {} is {}", width, leaf,
                                 title.empty() ? "refused" : "taken for valid"));
    };
    for (const int width : {2, 4, 8, 16}) ask_tree(width, width == 8 ? 1024 : 1, "");
    for (const int width : {0, 1, 3, 5, 7, 9, 15, 17, 32, -8}) ask_tree(width, 4, "BVH width");
    for (const int leaf : {0, -1, 1025}) ask_tree(8, leaf, "BVH leaf size");
    return failures;
}

}  // namespace scotty::verify
