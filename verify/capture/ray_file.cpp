#include "verify/capture/ray_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include "reference/base/error.h"

namespace scotty::verify {

using reference::Error;
using reference::HitCandidate;
using reference::Ray;
using reference::Scene;
using reference::Vec3;
namespace fs = std::filesystem;

namespace {

static_assert(sizeof(Ray) == 8 * sizeof(float), "a ray is what the file holds of it");

/// Reads a file front to back and knows how much is left.
class Reader {
 public:
    explicit Reader(const fs::path& file)
        : file_(file), in_(file, std::ios::binary | std::ios::ate) {
        if (!in_) fail("cannot be read");
        left_ = static_cast<std::uint64_t>(in_.tellg());
        in_.seekg(0);
    }

    [[noreturn]] void fail(const std::string& what) const {
        throw Error::bad_input(file_.string(), what);
    }

    void expect_magic(std::string_view magic, const char* kind) {
        std::array<char, 4> found{};
        if (left_ >= found.size()) read(found.data(), found.size());
        if (std::string_view(found.data(), found.size()) != magic) {
            fail(fmt::format("expected {}, which begins with '{}'; found another kind of file",
                             kind, magic));
        }
    }
    std::uint32_t word(const char* what) {
        if (left_ < 4) fail(fmt::format("ends before its {}; it has been cut short", what));
        std::uint32_t value = 0;
        read(&value, sizeof value);
        return value;
    }
    template <class T>
    std::vector<T> records(std::uint64_t count, const char* what, bool last) {
        const std::uint64_t needed = count * sizeof(T);
        if (left_ < needed || (last && left_ != needed)) {
            fail(
                fmt::format("expected {} {} = {} bytes, found {}; it has been cut short or is "
                            "another kind of file",
                            count, what, needed, left_));
        }
        std::vector<T> values(count);
        read(values.data(), needed);
        return values;
    }
    std::uint64_t left() const { return left_; }

 private:
    void read(void* target, std::uint64_t bytes) {
        in_.read(static_cast<char*>(target), static_cast<std::streamsize>(bytes));
        if (!in_ && bytes != 0) fail("cannot be read to its end");
        left_ -= bytes;
    }

    fs::path file_;
    std::ifstream in_;
    std::uint64_t left_ = 0;
};

class Writer {
 public:
    explicit Writer(const fs::path& file) : file_(file), out_(file, std::ios::binary) {}

    void bytes(const void* data, std::size_t size) {
        if (size != 0) {
            out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
        }
    }
    void word(std::uint32_t value) { bytes(&value, sizeof value); }
    void finish() {
        out_.close();
        if (!out_) {
            throw Error::bad_input(file_.string(),
                                   "cannot be written (is the disk full, or the folder read-only "
                                   "or missing?)");
        }
    }

 private:
    fs::path file_;
    std::ofstream out_;
};

bool finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Bounds of a direction's largest component. Products of such directions with coordinates stay
/// finite and above zero in float, in our tracers and in Embree.
constexpr float kShortestDirection = 1e-12f;
constexpr float kLongestDirection = 1e12f;

/// Null where the ray can be traced.
const char* fault_of(const Ray& ray) {
    if (!finite(ray.origin)) return "its origin is not finite";
    if (!finite(ray.direction)) return "its direction is not finite";
    if (reference::max_abs(ray.origin) > reference::kMaxCoordinate) {
        return "its origin is beyond 1e12, where scenes end";
    }
    if (reference::is_zero(ray.direction)) return "its direction is zero";
    const float longest = reference::max_abs(ray.direction);
    if (longest < kShortestDirection) {
        return "its direction is too short: scale it to 1e-12 at least, and divide its t by as "
               "much";
    }
    if (longest > kLongestDirection) {
        return "its direction is too long: scale it to 1e12 at most, and divide its t by as much";
    }
    if (!(ray.t_min >= 0.0f)) return "its t_min is negative or NaN";
    if (std::isnan(ray.t_max)) return "its t_max is NaN";
    return nullptr;
}

}  // namespace

RayFile read_rays(const fs::path& file) {
    Reader reader(file);
    reader.expect_magic("RAY1", "a file of rays");
    const std::uint32_t count = reader.word("number of rays");
    const std::uint32_t any_hit = reader.word("any-hit flag");
    if (any_hit > 1) {
        reader.fail(fmt::format("the any-hit flag: expected 0 or 1, found {}", any_hit));
    }
    RayFile out{reader.records<Ray>(count, "rays of 32 bytes", true), any_hit == 1};
    for (std::size_t i = 0; i < out.rays.size(); ++i) {
        if (const char* fault = fault_of(out.rays[i])) {
            throw Error::bad_input(fmt::format("{}: ray {}", file.string(), i), fault);
        }
    }
    return out;
}

void write_rays(const fs::path& file, const RayFile& rays) {
    Writer writer(file);
    writer.bytes("RAY1", 4);
    writer.word(static_cast<std::uint32_t>(rays.rays.size()));
    writer.word(rays.any_hit ? 1 : 0);
    writer.bytes(rays.rays.data(), rays.rays.size() * sizeof(Ray));
    writer.finish();
}

std::vector<HitCandidate> read_reference(const fs::path& file, std::size_t count) {
    Reader reader(file);
    reader.expect_magic("REF1", "a file of reference hits");
    const std::uint32_t found = reader.word("number of hits");
    if (found != count) {
        reader.fail(fmt::format("expected {} hits, one a ray, found {}", count, found));
    }
    return reader.records<HitCandidate>(found, "hits of 8 bytes", true);
}

std::vector<HitCandidate> read_hits(const fs::path& file) {
    Reader reader(file);
    if (reader.left() % sizeof(HitCandidate) != 0) {
        reader.fail(fmt::format("expected hits of 8 bytes each, found {} bytes", reader.left()));
    }
    return reader.records<HitCandidate>(reader.left() / sizeof(HitCandidate), "hits of 8 bytes",
                                        true);
}

void write_hits(const fs::path& file, std::span<const HitCandidate> hits) {
    Writer writer(file);
    writer.bytes(hits.data(), hits.size_bytes());
    writer.finish();
}

HitCandidate hit_record(const reference::Hit& hit, bool any_hit) {
    if (any_hit) return {0.0f, reference::is_hit(hit) ? 1u : 0u};
    return {hit.t, hit.primitive};
}

Scene read_scene_file(const fs::path& file) {
    Reader reader(file);
    reader.expect_magic("SCN1", "a scene");
    const std::uint32_t vertices = reader.word("number of vertices");
    const std::uint32_t triangles = reader.word("number of triangles");
    Scene scene;
    scene.name = file.filename().string();
    scene.source = file.string();
    scene.vertices = reader.records<Vec3>(vertices, "vertices of 12 bytes", false);
    scene.triangles =
        reader.records<std::array<std::uint32_t, 3>>(triangles, "triangles of 12 bytes", true);
    scene.material_of.assign(scene.triangles.size(), 0);
    reference::Material grey;
    grey.reflectance = Vec3(0.5f, 0.5f, 0.5f);
    scene.materials = {grey};
    try {
        reference::validate_and_repair(scene);
    } catch (const Error& error) {
        throw Error::bad_input(file.string(), error.what());
    }
    return scene;
}

void write_scene_file(const fs::path& file, const Scene& scene) {
    Writer writer(file);
    writer.bytes("SCN1", 4);
    writer.word(static_cast<std::uint32_t>(scene.vertices.size()));
    writer.word(static_cast<std::uint32_t>(scene.triangles.size()));
    writer.bytes(scene.vertices.data(), scene.vertices.size() * sizeof(Vec3));
    writer.bytes(scene.triangles.data(), scene.triangles.size() * sizeof(scene.triangles[0]));
    writer.finish();
}

}  // namespace scotty::verify
