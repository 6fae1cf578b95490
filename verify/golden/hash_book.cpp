#include "verify/golden/hash_book.h"

#include <fmt/format.h>
#ifndef XXH_INLINE_ALL
#define XXH_INLINE_ALL
#endif
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/scene.h"

namespace scotty::verify {

using reference::Error;
using reference::ParameterGroup;
using reference::PipelineParameters;

namespace {

constexpr std::array kParts{"table", "scene", "tree", "rays", "hits", "image", "work", kWorkOfText};
constexpr std::size_t kDigits = 16;

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
    return {{fmt::format("scene {}", scene), fingerprint(data)}};
}

Hashes tree_hashes(const std::string& scene, const PipelineParameters& parameters,
                   const reference::WideBvh& bvh) {
    const std::string options = reference::options_of(parameters, {ParameterGroup::tree});
    return {{named("tree", scene, options), fingerprint(bvh)}};
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

void WorkHasher::on_stage(const reference::StageView& stage) {
    hash_ = hash_of(stage.name.data(), stage.name.size(), hash_);
    for (const auto& counts : {reference::buffers::child_counts, reference::buffers::hit_counts}) {
        const auto values = stage.get(counts);
        hash_ = hash_of(values.data(), values.size_bytes(), hash_);
    }
}

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
