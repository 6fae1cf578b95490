#include "verify/golden/hash_book.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#ifndef XXH_INLINE_ALL
#define XXH_INLINE_ALL
#endif
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "reference/base/error.h"
#include "reference/bvh/binary_bvh.h"
#include "reference/contract/last_queues.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/scene.h"

namespace scotty::verify {

using reference::Error;
using reference::ParameterGroup;
using reference::PipelineParameters;

namespace {

constexpr std::array kParts{"table",    "scene", "warnings", "median-tree", "tree", "last-queues",
                            "refusals", "rays",  "hits",     "image",       "work", kWorkOfText};
constexpr std::size_t kDigits = 16;
/// Median splits are what a tree is built by where Embree gives up, which no scene makes it do: of
/// small scenes they are made for their hash alone.
constexpr std::size_t kMostMedianTriangles = 1000;

/// XXH64, going on from what was hashed before.
std::uint64_t hash_of(const void* data, std::size_t bytes, std::uint64_t before) {
    return XXH64(data, bytes, before);
}
template <class T>
std::uint64_t hash_of(const std::vector<T>& values, std::uint64_t before) {
    return hash_of(values.data(), values.size() * sizeof(T), before);
}

std::string named(const char* part, const std::string& scene, const std::string& options) {
    return fmt::format("{} {} {}", part, scene, options);
}

std::size_t rank_of(const std::string& what) {
    const std::string_view part = std::string_view(what).substr(0, what.find(' '));
    return static_cast<std::size_t>(
        std::distance(kParts.begin(), std::find(kParts.begin(), kParts.end(), part)));
}

Failure golden_failure(const std::string& what) {
    Failure failure;
    failure.invariant = kGoldenHash;
    failure.stage = what.substr(0, what.find(' '));
    failure.field = what;
    return failure;
}

constexpr const char* kWayOut =
    "where that is meant: scotty golden propose hashes && scotty golden approve hashes --reason "
    "\"...\"";

}  // namespace

std::string to_text(const Hashes& hashes) {
    std::string text;
    for (const auto& [what, hash] : hashes) text += fmt::format("{:016x} {}\n", hash, what);
    return text;
}

Hashes read_hashes(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw Error::bad_input(file.string(), "cannot be read");
    Hashes hashes;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        const bool is_hex = line.size() > kDigits + 1 && line[kDigits] == ' ' &&
                            line.find_first_not_of("0123456789abcdef") == kDigits;
        if (!is_hex) {
            throw Error::bad_input(
                file.string(),
                fmt::format("line {}: expected {} hexadecimal digits and what they are the hash "
                            "of, found '{:.60}'",
                            number, kDigits, line));
        }
        hashes[line.substr(kDigits + 1)] = std::stoull(line.substr(0, kDigits), nullptr, 16);
    }
    return hashes;
}

std::uint64_t hash_of_text(std::string_view text) { return hash_of(text.data(), text.size(), 0); }

Hashes scene_hashes(const std::string& scene, const reference::Scene& data) {
    Hashes hashes{{fmt::format("scene {}", scene), fingerprint(data)}};
    hashes[fmt::format("warnings {}", scene)] =
        hash_of_text(fmt::format("{}", fmt::join(data.warnings, "\n")));
    if (data.triangles.size() > kMostMedianTriangles) return hashes;
    const reference::BinaryBvh median = reference::build_median_bvh(data);
    hashes[fmt::format("median-tree {}", scene)] = hash_of(median.nodes, hash_of(median.order, 0));
    return hashes;
}

Hashes tree_hashes(const std::string& scene, const PipelineParameters& parameters,
                   const reference::WideBvh& bvh) {
    const std::string options = reference::options_of(parameters, {ParameterGroup::tree});
    return {{named("tree", scene, options), fingerprint(bvh)},
            {named("last-queues", scene, options), hash_of(reference::last_queues(bvh), 0)}};
}

Hashes picture_hashes(const std::string& scene, const PipelineParameters& parameters,
                      const Recording& recording) {
    std::uint64_t rays = 0;
    std::uint64_t hits = 0;
    for (const TraversalRecord& traversal : recording.traversals) {
        const std::array place{traversal.bounce, traversal.light};
        rays = hash_of(traversal.rays, hash_of(place.data(), sizeof place, rays));
        hits = hash_of(traversal.hits, hits);
    }
    std::uint64_t image = hash_of(recording.radiance, 0);
    image = hash_of(recording.image.pixels, image);
    image = hash_of(recording.image.variance, image);
    const std::string picture = reference::options_of(parameters, {ParameterGroup::picture});
    const std::string filter =
        parameters.filter == reference::Filter::none
            ? ""
            : fmt::format(" --filter {} --filter-threshold {}", to_string(parameters.filter),
                          parameters.filter_threshold);
    return {{named("rays", scene, picture), rays},
            {named("hits", scene, picture), hits},
            {named("image", scene, picture + filter), image}};
}

void WorkHasher::on_batch(std::uint64_t done, std::uint64_t count) {
    const std::array both{done, count};
    hash_ = hash_of(both.data(), sizeof both, hash_);
}

void WorkHasher::on_stage(const reference::StageView& stage) {
    namespace buffers = reference::buffers;
    add(stage.name);
    const std::array grid{stage.blocks, stage.threads};
    hash_ = hash_of(grid.data(), sizeof grid, hash_);
    for (const auto* shown : {&stage.inputs, &stage.outputs}) {
        for (const reference::BufferView& buffer : *shown) {
            // How much room queues and hit lists have is not their work.
            if (reference::buffer_info(buffer.name).order != reference::BufferOrder::ordered) {
                add(fmt::format("{} {}", buffer.name, buffer.shape.size()));
            } else {
                add(fmt::format("{} {}", buffer.name, fmt::join(buffer.shape, " ")));
            }
        }
    }
    const auto lengths = stage.get(buffers::child_counts);
    const auto offsets = stage.get(buffers::child_offsets);
    const auto queue = stage.get(buffers::child_queue);
    hash_ = hash_of(lengths.data(), lengths.size_bytes(), hash_);
    for (std::size_t node = 0; node < lengths.size() && node < offsets.size(); ++node) {
        if (offsets[node] > queue.size() || lengths[node] > queue.size() - offsets[node]) continue;
        hash_ = hash_of(queue.data() + offsets[node], lengths[node] * sizeof(std::uint32_t), hash_);
    }
    if (const auto pairs = stage.get(buffers::child_pairs); !pairs.empty()) {
        hash_ = hash_of(pairs.data(), pairs.size_bytes(), hash_);
    }
    const auto counts = stage.get(buffers::hit_counts);
    const auto hits = stage.get(buffers::hits);
    hash_ = hash_of(counts.data(), counts.size_bytes(), hash_);
    for (std::size_t ray = 0; ray < counts.size(); ++ray) {
        const std::size_t slots = hits.size() / counts.size();
        const std::size_t used = std::min<std::size_t>(counts[ray], slots);
        hash_ = hash_of(hits.data() + ray * slots, used * sizeof(reference::HitCandidate), hash_);
    }
}

void WorkHasher::add(const std::vector<reference::LaunchRecord>& launches,
                     std::size_t device_bytes) {
    for (const reference::LaunchRecord& launch : launches) {
        add(fmt::format("{} {} {} {} {} {} {}", static_cast<int>(launch.kind), launch.batch,
                        launch.bounce, launch.light, launch.level, launch.blocks, launch.items));
    }
    add(std::to_string(device_bytes));
}

void WorkHasher::add(std::string_view text) { hash_ = hash_of(text.data(), text.size(), hash_); }

std::vector<Failure> HashBook::look_up(const Hashes& found) {
    std::vector<std::string> order;
    for (const auto& [what, hash] : found) order.push_back(what);
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return rank_of(a) < rank_of(b); });
    const std::lock_guard lock(mutex_);
    std::vector<Failure> failures;
    for (const std::string& what : order) {
        const std::uint64_t hash = found.at(what);
        if (records()) {
            recorded_[what] = hash;
            continue;
        }
        const auto golden = golden_->find(what);
        if (golden == golden_->end()) {
            if (!complete_ || what.starts_with(kWorkOfText)) continue;
            Failure& failure = failures.emplace_back(golden_failure(what));
            failure.sentence =
                fmt::format("golden/hashes.txt has no hash of this run; {}", kWayOut);
            continue;
        }
        ++compared_;
        if (golden->second == hash) continue;
        Failure& failure = failures.emplace_back(golden_failure(what));
        failure.expected = fmt::format("{:016x}", golden->second);
        failure.found = fmt::format("{:016x}", hash);
        failure.sentence = fmt::format(
            "the {} of this run {} not what golden/hashes.txt has, though every check and oracle "
            "agrees; {}",
            failure.stage, failure.stage == "rays" || failure.stage == "hits" ? "are" : "is",
            kWayOut);
    }
    return failures;
}

}  // namespace scotty::verify
