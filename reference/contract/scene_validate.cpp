#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <cmath>

#include "reference/base/error.h"
#include "reference/contract/scene.h"
#include "reference/contract/scene_fields.h"

namespace scotty::reference {

namespace {

/// Names an element of the scene in an error: "coil: vertex 17".
class Checker {
 public:
    explicit Checker(const Scene& scene) : name_(scene.name.empty() ? "scene" : scene.name) {}

    [[noreturn]] void fail(const std::string& element, const std::string& what) const {
        throw Error::bad_input(name_ + ": " + element, what);
    }

    // Comparisons are written so that NaN fails them.

    void in_range(float value, float low, float high, const char* element, std::size_t index,
                  const char* field) const {
        if (value >= low && value <= high) return;
        fail(fmt::format("{} {}", element, index),
             fmt::format("{}: expected {} to {}, found {}", field, low, high, value));
    }
    void in_range(const Vec3& value, float low, float high, const char* element, std::size_t index,
                  const char* field) const {
        for (int axis = 0; axis < 3; ++axis) {
            in_range(value[axis], low, high, element, index, field);
        }
    }
    void coordinate(const Vec3& value, const char* element, std::size_t index,
                    const char* field) const {
        in_range(value, -kMaxCoordinate, kMaxCoordinate, element, index, field);
    }
    void unit(const Vec3& value, const char* element, std::size_t index, const char* field) const {
        const float square = dot(value, value);
        if (abs_of(square - 1.0f) <= 1e-3f) return;
        fail(fmt::format("{} {}", element, index),
             fmt::format("{}: expected a unit vector, found ({}, {}, {})", field, value.x, value.y,
                         value.z));
    }

 private:
    std::string name_;
};

constexpr float kMaxRadiance = 1e12f;
constexpr float kMaxIor = 100.0f;

void check_geometry(const Scene& scene, const Checker& check) {
    if (scene.triangles.empty()) check.fail("geometry", "no triangles, nothing to hit");
    if (scene.triangles.size() >= kLeafBit) {
        check.fail("geometry", fmt::format("{} triangles, at most {} can be numbered",
                                           scene.triangles.size(), kLeafBit - 1));
    }
    if (!scene.normals.empty() && scene.normals.size() != scene.vertices.size()) {
        check.fail("normals", fmt::format("expected one per vertex ({}) or none, found {}",
                                          scene.vertices.size(), scene.normals.size()));
    }
    if (scene.material_of.size() != scene.triangles.size()) {
        check.fail("material indices",
                   fmt::format("expected one per triangle ({}), found {}", scene.triangles.size(),
                               scene.material_of.size()));
    }
    for (std::size_t i = 0; i < scene.vertices.size(); ++i) {
        if (max_abs(scene.vertices[i]) <= kMaxCoordinate) {
            // max_abs() drops a NaN that is not last; a sum does not.
            const Vec3& v = scene.vertices[i];
            if (!std::isnan(v.x + v.y + v.z)) continue;
        }
        check.coordinate(scene.vertices[i], "vertex", i, "position");
    }
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        for (const std::uint32_t vertex : scene.triangles[i]) {
            if (vertex < scene.vertices.size()) continue;
            check.fail(fmt::format("triangle {}", i),
                       fmt::format("vertex index {} out of range, the scene has {} vertices",
                                   vertex, scene.vertices.size()));
        }
        if (scene.material_of[i] < scene.materials.size()) continue;
        check.fail(fmt::format("triangle {}", i),
                   fmt::format("material index {} out of range, the scene has {} materials",
                               scene.material_of[i], scene.materials.size()));
    }
}

void check_material(const Material& material, std::size_t i, const Checker& check) {
    if (static_cast<std::uint32_t>(material.kind) >= kMaterialKinds) {
        check.fail(fmt::format("material {}", i),
                   fmt::format("kind: expected 0 (diffuse), 1 (mirror) or 2 (glass), found {}",
                               static_cast<std::uint32_t>(material.kind)));
    }
    check.in_range(material.reflectance, 0.0f, 1.0f, "material", i, "reflectance");
    check.in_range(material.transmittance, 0.0f, 1.0f, "material", i, "transmittance");
    check.in_range(material.emission, 0.0f, kMaxRadiance, "material", i, "emission");
    if (material.kind == MaterialKind::conductor) {
        check.in_range(material.ior, 0.0f, 1.0f, "material", i, "roughness");
    } else {
        check.in_range(material.ior, 1.0f / kMaxIor, kMaxIor, "material", i, "index of refraction");
    }
    if (material.emission_is_sampled > 1) {
        check.fail(fmt::format("material {}", i),
                   fmt::format("emission_is_sampled: expected 0 or 1, found {}",
                               material.emission_is_sampled));
    }
}

void check_cone(const SpotCone& cone, std::size_t i, const Checker& check) {
    check.in_range(cone.inner, -1.0f, 1.0f, "light", i, "cosine of the inner cone");
    if (cone.outer >= -1.0f && cone.outer <= cone.inner && cone.outer < 1.0f) return;
    check.fail(fmt::format("light {}", i),
               fmt::format("cosine of the outer cone: expected -1 to {}, below 1, found {}",
                           cone.inner, cone.outer));
}

void check_light(const Light& light, std::size_t i, const Checker& check) {
    if (light.kind > LightKind::spot) {
        check.fail(fmt::format("light {}", i), fmt::format("kind: expected 0 to 6, found {}",
                                                           static_cast<std::uint32_t>(light.kind)));
    }
    check.in_range(light.radiance, 0.0f, kMaxRadiance, "light", i, "radiance");
    check.coordinate(light.position, "light", i, "position");
    if (light.kind == LightKind::directional || light.kind == LightKind::hemisphere ||
        light.kind == LightKind::spot) {
        check.unit(light.normal, "light", i, "normal");
    }
    if (light.kind == LightKind::spot) check_cone(spot_cone(light), i, check);
    if (light.kind != LightKind::parallelogram && light.kind != LightKind::triangle) return;
    check.coordinate(light.edge_x, "light", i, "edge_x");
    check.coordinate(light.edge_y, "light", i, "edge_y");
    check.unit(light.normal, "light", i, "normal");
    const Vec3 across = cross(light.edge_x, light.edge_y);
    const float area = length(across) * (light.kind == LightKind::triangle ? 0.5f : 1.0f);
    if (!(light.area > 0.0f) || !(abs_of(light.area - area) <= 1e-3f * area)) {
        check.fail(fmt::format("light {}", i),
                   fmt::format("area: expected {} as its edges span, above 0, found {}", area,
                               light.area));
    }
    if (!(abs_of(dot(across, light.normal)) >= 0.999f * length(across))) {
        check.fail(fmt::format("light {}", i), "normal: expected it perpendicular to both edges");
    }
}

void check_camera(const Camera& camera, const Checker& check) {
    check.coordinate(camera.position, "camera", 0, "position");
    check.unit(camera.right, "camera", 0, "right");
    check.unit(camera.up, "camera", 0, "up");
    check.unit(camera.forward, "camera", 0, "forward");
    check.in_range(camera.tan_half_fov, 1e-4f, 1e4f, "camera", 0,
                   "tangent of half the field of view");
    if (camera.tan_half_width != 0.0f) {
        check.in_range(camera.tan_half_width, 1e-4f, 1e4f, "camera", 0,
                       "tangent of half the horizontal field of view");
    }
    const Vec3 back = cross(camera.right, camera.up);
    if (!(dot(back, camera.forward) <= -0.999f) ||
        !(abs_of(dot(camera.right, camera.up)) <= 1e-3f)) {
        check.fail("camera 0", "expected right, up, forward orthonormal, right x up = -forward");
    }
}

void repair_normals(Scene& scene) {
    std::size_t repaired = 0;
    for (Vec3& normal : scene.normals) {
        if (is_zero(normal)) continue;
        if (abs_of(dot(normal, normal) - 1.0f) <= 1e-4f) continue;
        const bool is_nan = std::isnan(normal.x + normal.y + normal.z);
        normal = is_nan ? Vec3(0.0f, 0.0f, 0.0f) : normalize_or(normal, Vec3(0.0f, 0.0f, 0.0f));
        ++repaired;
    }
    if (repaired == 0) return;
    scene.warnings.push_back(fmt::format(
        "{} normals were not finite or not of unit length: normalised, or flat there", repaired));
}

/// In double, where differences of floats are exact (or nearly), so that thin is not called empty.
bool has_zero_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    double p[3];
    double q[3];
    for (int k = 0; k < 3; ++k) {
        p[k] = static_cast<double>(b[k]) - a[k];
        q[k] = static_cast<double>(c[k]) - a[k];
    }
    return p[1] * q[2] == p[2] * q[1] && p[2] * q[0] == p[0] * q[2] && p[0] * q[1] == p[1] * q[0];
}

void report_empty_triangles(Scene& scene) {
    std::size_t count = 0;
    std::size_t first = 0;
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        const auto& [a, b, c] = scene.triangles[i];
        if (!has_zero_area(scene.vertices[a], scene.vertices[b], scene.vertices[c])) continue;
        if (count++ == 0) first = i;
    }
    if (count == 0) return;
    scene.warnings.push_back(fmt::format(
        "{} triangles have zero area and are never hit, the first is triangle {}", count, first));
}

void report_darkness(Scene& scene) {
    for (const Light& light : scene.lights) {
        if (!is_zero(light.radiance)) return;
    }
    for (const Material& material : scene.materials) {
        if (!is_zero(material.emission)) return;
    }
    scene.warnings.emplace_back("no light and no emission: the picture is black");
}

/// Feeds values field by field: structures have padding, which is not part of a scene.
class SceneHasher {
 public:
    SceneHasher() : state_(XXH64_createState()) { XXH64_reset(state_, 0); }
    ~SceneHasher() { XXH64_freeState(state_); }
    SceneHasher(const SceneHasher&) = delete;
    SceneHasher& operator=(const SceneHasher&) = delete;

    void word(std::uint32_t value) { words_.push_back(value); }
    void count(std::uint64_t value) {
        word(static_cast<std::uint32_t>(value));
        word(static_cast<std::uint32_t>(value >> 32));
    }
    void field(float value) { word(std::bit_cast<std::uint32_t>(value)); }
    void field(const Vec3& value) {
        for (int axis = 0; axis < 3; ++axis) field(value[axis]);
    }
    template <class Word>
    void field(const Word& value) {
        word(static_cast<std::uint32_t>(value));
    }
    /// An array of packed elements, its length first.
    template <class Element>
    void array(const std::vector<Element>& values) {
        count(values.size());
        flush();
        if (!values.empty()) XXH64_update(state_, values.data(), values.size() * sizeof(Element));
    }
    std::uint64_t digest() {
        flush();
        return XXH64_digest(state_);
    }

 private:
    void flush() {
        if (!words_.empty()) XXH64_update(state_, words_.data(), words_.size() * sizeof words_[0]);
        words_.clear();
    }

    std::vector<std::uint32_t> words_;  ///< single values, until there is an array or the end
    XXH64_state_t* state_;
};
static_assert(std::endian::native == std::endian::little,
              "fingerprints are of little-endian bytes");

}  // namespace

void validate_and_repair(Scene& scene) {
    const Checker check(scene);
    check_geometry(scene, check);
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        check_material(scene.materials[i], i, check);
    }
    for (std::size_t i = 0; i < scene.lights.size(); ++i) check_light(scene.lights[i], i, check);
    check_camera(scene.camera, check);
    repair_normals(scene);
    report_empty_triangles(scene);
    report_darkness(scene);
}

std::uint64_t fingerprint(const Scene& scene) {
    SceneHasher hash;
    hash.array(scene.vertices);
    hash.array(scene.normals);
    hash.array(scene.triangles);
    hash.array(scene.material_of);
    const auto add = [&](const auto& field) { hash.field(field); };
    hash.count(scene.materials.size());
    for (const Material& material : scene.materials) for_each_material_field(material, add);
    hash.count(scene.lights.size());
    for (const Light& light : scene.lights) for_each_light_field(light, add);
    for_each_camera_field(scene.camera, add, scene.camera.tan_half_width != 0.0f);
    return hash.digest();
}

}  // namespace scotty::reference
