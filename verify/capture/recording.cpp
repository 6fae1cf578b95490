#include "verify/capture/recording.h"

#include <fmt/format.h>

#include <algorithm>

#include "reference/base/assert.h"
#include "verify/base/same_bits.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Hit;
using reference::Ray;
using reference::StageKind;
using reference::StageView;
using reference::Vec3;

std::string TraversalRecord::stage() const {
    return stage_name(StageKind::merge_intersections, 0, bounce, light, reference::kNotApplicable,
                      false);
}

std::uint64_t Recording::living_rays() const {
    std::uint64_t count = 0;
    for (const TraversalRecord& traversal : traversals) {
        for (const Ray& ray : traversal.rays) count += is_dead(ray) ? 0 : 1;
    }
    return count;
}

Recorder::Recorder(const reference::PipelineParameters& parameters, Recording& recording)
    : paths_(std::size_t{parameters.image_width} * parameters.image_height * parameters.spp),
      spp_(parameters.spp),
      recording_(recording) {
    recording_.radiance.assign(paths_, Vec3(0.0f, 0.0f, 0.0f));
}

bool Recorder::wants(StageKind kind) const {
    return kind == StageKind::primary_rays || kind == StageKind::merge_intersections ||
           kind == StageKind::reconstruct_image || kind == StageKind::filter;
}

TraversalRecord& Recorder::record_of(std::uint32_t bounce, std::uint32_t light) {
    for (TraversalRecord& record : recording_.traversals) {
        if (record.bounce == bounce && record.light == light) return record;
    }
    TraversalRecord& record = recording_.traversals.emplace_back();
    record.bounce = bounce;
    record.light = light;
    record.rays.assign(paths_, reference::dead_ray());
    record.hits.assign(paths_, reference::no_hit());
    return record;
}

void Recorder::on_stage(const StageView& stage) {
    if (stage.kind == StageKind::primary_rays) {
        const auto pixel = stage.get(buffers::pixel);
        const auto sample = stage.get(buffers::sample);
        path_of_.resize(pixel.size());
        for (std::size_t i = 0; i < pixel.size(); ++i) {
            path_of_[i] = pixel[i] * spp_ + sample[i];
            SCOTTY_ASSERT(path_of_[i], <, paths_);
        }
    } else if (stage.kind == StageKind::merge_intersections) {
        const auto rays = stage.get(buffers::rays);
        const auto hits = stage.get(buffers::merged);
        SCOTTY_ASSERT(rays.size(), ==, path_of_.size());
        SCOTTY_ASSERT(hits.size(), ==, path_of_.size());
        TraversalRecord& record = record_of(stage.bounce, stage.light);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            record.rays[path_of_[i]] = rays[i];
            record.hits[path_of_[i]] = hits[i];
        }
    } else if (stage.kind == StageKind::reconstruct_image) {
        const auto radiance = stage.get(buffers::radiance);
        SCOTTY_ASSERT(radiance.size(), ==, path_of_.size());
        for (std::size_t i = 0; i < radiance.size(); ++i) {
            recording_.radiance[path_of_[i]] = radiance[i];
        }
        const auto image = stage.get(buffers::image);
        recording_.reconstructed.assign(image.begin(), image.end());
    } else if (stage.kind == StageKind::filter) {
        const auto filtered = stage.get(buffers::filtered);
        recording_.filtered.assign(filtered.begin(), filtered.end());
    }
}

bool Observers::wants(StageKind kind) const {
    return std::any_of(observers_.begin(), observers_.end(),
                       [&](const auto* observer) { return observer->wants(kind); });
}

void Observers::on_stage(const StageView& stage) {
    for (auto* observer : observers_) {
        if (observer->wants(stage.kind)) observer->on_stage(stage);
    }
}

bool Observers::follows_launches() const {
    return std::any_of(observers_.begin(), observers_.end(),
                       [](const auto* observer) { return observer->follows_launches(); });
}

void Observers::on_batch(std::uint64_t done, std::uint64_t count) {
    for (auto* observer : observers_) observer->on_batch(done, count);
}

void Observers::on_retry(std::string_view stage, std::string_view reason) {
    for (auto* observer : observers_) observer->on_retry(stage, reason);
}

namespace {

Failure difference(const char* what, std::string stage, std::size_t path, std::uint32_t spp,
                   std::string_view field, std::string expected, std::string found) {
    Failure failure;
    failure.invariant = "same-as-baseline";
    failure.stage = std::move(stage);
    failure.ray = static_cast<std::uint32_t>(path);
    failure.field = field;
    failure.expected = std::move(expected);
    failure.found = std::move(found);
    failure.sentence = fmt::format("{} of pixel {}, sample {} differ from the baseline's", what,
                                   path / spp, path % spp);
    return failure;
}

/// Where only an answer was asked for: whether something is hit.
bool agree(const Hit& a, const Hit& b, bool occlusion_only) {
    return occlusion_only ? is_hit(a) == is_hit(b) : same_bits(a, b);
}

}  // namespace

std::vector<Failure> compare(const Recording& baseline, const Recording& other, bool occlusion_only,
                             std::uint32_t spp) {
    std::vector<Failure> failures;
    bool rays_differ = false;
    bool hits_differ = false;
    for (const TraversalRecord& expected : baseline.traversals) {
        const auto found = std::find_if(
            other.traversals.begin(), other.traversals.end(), [&](const TraversalRecord& record) {
                return record.bounce == expected.bounce && record.light == expected.light;
            });
        if (found == other.traversals.end()) {
            failures.push_back(difference("the traversal", expected.stage(), 0, spp, "traversals",
                                          "this traversal", "none"));
            continue;
        }
        for (std::size_t i = 0; i < expected.rays.size() && !rays_differ; ++i) {
            const bool both_dead = is_dead(expected.rays[i]) && is_dead(found->rays[i]);
            if (both_dead || same_bits(expected.rays[i], found->rays[i])) continue;
            rays_differ = true;
            failures.push_back(difference("the ray", expected.stage(), i, spp, buffers::rays.name,
                                          exact(expected.rays[i]), exact(found->rays[i])));
        }
        const bool only_occlusion = occlusion_only && expected.is_shadow();
        for (std::size_t i = 0; i < expected.hits.size() && !hits_differ; ++i) {
            if (agree(expected.hits[i], found->hits[i], only_occlusion)) continue;
            hits_differ = true;
            failures.push_back(difference("the hit", expected.stage(), i, spp, buffers::merged.name,
                                          exact(expected.hits[i]), exact(found->hits[i])));
        }
    }
    if (other.traversals.size() != baseline.traversals.size()) {
        failures.push_back(difference("the traversals", "render", 0, spp, "traversals",
                                      std::to_string(baseline.traversals.size()),
                                      std::to_string(other.traversals.size())));
    }
    for (std::size_t i = 0; i < baseline.radiance.size(); ++i) {
        if (same_bits(baseline.radiance[i], other.radiance[i])) continue;
        failures.push_back(difference("the radiance", "reconstruct_image", i, spp,
                                      buffers::radiance.name, exact(baseline.radiance[i]),
                                      exact(other.radiance[i])));
        break;
    }
    if (auto failure = compare_images(baseline.image, other.image, spp)) {
        failures.push_back(std::move(*failure));
    }
    return failures;
}

std::optional<Failure> compare_images(const reference::Image& baseline,
                                      const reference::Image& other, std::uint32_t spp) {
    struct Part {
        const char* what;
        const char* buffer;
        const std::vector<Vec3>& expected;
        const std::vector<Vec3>& found;
    };
    for (const Part& part : {Part{"the image", "image", baseline.pixels, other.pixels},
                             Part{"the variance", "variance", baseline.variance, other.variance}}) {
        if (part.expected.size() != part.found.size()) {
            return difference(part.what, "reconstruct_image", 0, spp, part.buffer,
                              fmt::format("{} pixels", part.expected.size()),
                              fmt::format("{} pixels", part.found.size()));
        }
        for (std::size_t p = 0; p < part.expected.size(); ++p) {
            if (same_bits(part.expected[p], part.found[p])) continue;
            return difference(part.what, "reconstruct_image", p * spp, spp,
                              fmt::format("{}[{}]", part.buffer, p), exact(part.expected[p]),
                              exact(part.found[p]));
        }
    }
    return std::nullopt;
}

}  // namespace scotty::verify
