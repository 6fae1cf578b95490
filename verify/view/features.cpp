#include "verify/view/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reference/base/assert.h"
#include "reference/contract/buffers.h"

namespace scotty::verify {

namespace buffers = reference::buffers;
using reference::Hit;
using reference::kNotApplicable;
using reference::Ray;
using reference::StageKind;
using reference::StageView;
using reference::Vec3;

namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

/// The unit normal of the triangle; zero where it has no area.
Vec3 normal_of(const reference::Scene& scene, std::uint32_t primitive) {
    const auto& corners = scene.triangles[primitive];
    const Vec3 a = scene.vertices[corners[0]];
    const Vec3 n = reference::cross(scene.vertices[corners[1]] - a, scene.vertices[corners[2]] - a);
    const float size = reference::max_abs(n);
    if (!(size > 0.0f)) return {0.0f, 0.0f, 0.0f};
    const Vec3 scaled = n / size;
    return scaled / std::sqrt(reference::dot(scaled, scaled));
}

}  // namespace

FeatureObserver::FeatureObserver(const reference::Scene& scene, std::uint32_t width,
                                 std::uint32_t height, ViewSubject subject)
    : scene_(scene), image_{width, height, {}, subject, {}} {
    SCOTTY_ASSERT(subject != ViewSubject::picture && subject != ViewSubject::variance, ==, true);
    const std::size_t pixels = std::size_t{width} * height;
    image_.values.assign(pixels, kNothing);
    if (subject == ViewSubject::normal) image_.normals.assign(pixels, Vec3(0.0f, 0.0f, 0.0f));
}

bool FeatureObserver::wants(StageKind kind) const {
    switch (image_.subject) {
        case ViewSubject::queues:
            return kind == StageKind::primary_rays || kind == StageKind::merge_intersections ||
                   is_level_kernel(kind);
        default:
            return kind == StageKind::primary_rays || kind == StageKind::scene_rays;
    }
}

void FeatureObserver::on_retry(std::string_view /*stage*/, std::string_view /*reason*/) {
    std::fill(counts_.begin(), counts_.end(), 0u);
    in_flight_.clear();
}

void FeatureObserver::on_stage(const StageView& stage) {
    if (stage.kind == StageKind::primary_rays) {
        const auto pixel = stage.get(buffers::pixel);
        pixel_.assign(pixel.begin(), pixel.end());
        counts_.assign(pixel.size(), 0u);
        return;
    }
    if (image_.subject == ViewSubject::queues) return count_queues(stage);
    if (image_.subject == ViewSubject::bounces) {
        const auto depth = stage.get(buffers::depth);
        for (std::size_t ray = 0; ray < depth.size(); ++ray) {
            image_.values[pixel_[ray]] = static_cast<float>(depth[ray]);
        }
        return;
    }
    if (stage.bounce == 0) take_hits(stage);
}

void FeatureObserver::take_hits(const StageView& stage) {
    const auto hits = stage.get(buffers::path_hits);
    for (std::size_t ray = 0; ray < hits.size(); ++ray) {
        const Hit& hit = hits[ray];
        if (!is_hit(hit)) continue;
        const std::uint32_t pixel = pixel_[ray];
        if (image_.subject == ViewSubject::normal) {
            image_.normals[pixel] = normal_of(scene_, hit.primitive);
        } else {
            image_.values[pixel] = image_.subject == ViewSubject::primitive
                                       ? static_cast<float>(hit.primitive & 0xffffffu)
                                       : hit.t;
        }
    }
}

void FeatureObserver::count_queues(const StageView& stage) {
    if (stage.bounce != 0 || stage.light != kNotApplicable) return;
    if (stage.kind == StageKind::merge_intersections) {
        for (std::size_t ray = 0; ray < counts_.size(); ++ray) {
            image_.values[pixel_[ray]] = static_cast<float>(counts_[ray]);
        }
        lengths_.resize(std::max(lengths_.size(), in_flight_.size()), 0);
        for (std::size_t level = 0; level < in_flight_.size(); ++level) {
            lengths_[level] += in_flight_[level];
        }
        in_flight_.clear();
        return;
    }
    std::uint64_t& entries = in_flight_.emplace_back(0);
    if (stage.kind == StageKind::intersect_root) {
        for (std::uint32_t& count : counts_) ++count;
        entries = counts_.size();
        return;
    }
    for (const reference::NodeRay& pair : stage.get(buffers::pairs)) {
        ++entries;
        ++counts_[pair.ray];
    }
    const auto lengths = stage.get(buffers::node_counts);
    const auto offsets = stage.get(buffers::queue_offsets);
    const auto queue = stage.get(buffers::queue);
    for (std::size_t node = 0; node < lengths.size(); ++node) {
        entries += lengths[node];
        for (const std::uint32_t ray : queue.subspan(offsets[node], lengths[node])) ++counts_[ray];
    }
}

FeatureImage FeatureObserver::take() { return std::move(image_); }

bool PathObserver::wants(StageKind kind) const {
    constexpr std::array kSeen{StageKind::primary_rays, StageKind::direct_light_rays,
                               StageKind::merge_intersections, StageKind::resolve_light,
                               StageKind::scene_rays};
    return std::find(kSeen.begin(), kSeen.end(), kind) != kSeen.end();
}

void PathObserver::on_stage(const StageView& stage) {
    if (stage.kind == StageKind::primary_rays) {
        const auto pixel = stage.get(buffers::pixel);
        const auto found = std::find(pixel.begin(), pixel.end(), wanted_);
        here_ = found != pixel.end();
        if (!here_) return;
        alive_ = true;
        path_ = {};
        path_.batch = stage.batch;
        path_.ray = static_cast<std::uint32_t>(found - pixel.begin());
        path_.origin = stage.get(buffers::rays)[path_.ray].origin;
        return;
    }
    if (!here_ || !alive_) return;
    const std::uint32_t ray = path_.ray;
    if (stage.kind == StageKind::merge_intersections && stage.light == kNotApplicable) {
        const Ray& traced = stage.get(buffers::rays)[ray];
        const Hit& hit = stage.get(buffers::merged)[ray];
        if (!is_hit(hit)) {
            path_.escaped = true;
            path_.escape_direction = traced.direction;
            alive_ = false;
            return;
        }
        path_.vertices.push_back(
            {traced.origin + traced.direction * hit.t, hit.primitive, hit.t, {}});
    } else if (stage.kind == StageKind::resolve_light && !path_.vertices.empty()) {
        const Ray& shadow = stage.get(buffers::shadow_rays)[ray];
        if (is_dead(shadow)) return;
        const bool blocked = is_hit(stage.get(buffers::shadow_hits)[ray]);
        const float length = std::min(shadow.t_max, reference::kMaxCoordinate);
        path_.vertices.back().lights.push_back(
            {shadow.origin + shadow.direction * length, blocked});
    } else if (stage.kind == StageKind::scene_rays) {
        alive_ = (stage.get(buffers::flags)[ray] & reference::kPathAlive) != 0;
    }
}

}  // namespace scotty::verify
