#include "verify/oracles/hit_check.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "reference/base/assert.h"
#include "verify/base/same_bits.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Adjudication;
using reference::Disagreement;
using reference::Hit;
using reference::Ray;

namespace {

constexpr std::size_t kMaxFailures = 20;

/// Steele, Lea, Flood: "Fast splittable pseudorandom number generators" (SplitMix64), its mixer.
std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

Failure hit_failure(const char* tag, const TraversalRecord& traversal, std::size_t path,
                    std::uint32_t spp, std::string sentence) {
    Failure failure;
    failure.invariant = tag;
    failure.stage = traversal.stage();
    failure.ray = static_cast<std::uint32_t>(path);
    failure.field = buffers::merged.name;
    failure.sentence = fmt::format("{} (pixel {}, sample {})", sentence, path / spp, path % spp);
    return failure;
}

class Check {
 public:
    Check(const reference::Scene& scene, const reference::EmbreeTracer& embree, std::uint32_t spp,
          const HitCheckSettings& settings, HitCheckResult& result)
        : scene_(scene), embree_(embree), spp_(spp), settings_(settings), result_(result) {}

    void against_brute_force(const TraversalRecord& traversal, std::uint64_t keep_below) {
        std::vector<Ray> rays;
        std::vector<std::size_t> paths;
        const std::uint64_t place = std::uint64_t{traversal.bounce} << 32 | traversal.light;
        for (std::size_t i = 0; i < traversal.rays.size(); ++i) {
            if (is_dead(traversal.rays[i])) {
                expect_nothing(traversal, i);
            } else if (mix(mix(settings_.seed ^ mix(place)) ^ i) <= keep_below) {
                rays.push_back(traversal.rays[i]);
                paths.push_back(i);
            }
        }
        std::vector<Hit> truth(rays.size());
        reference::brute_force_closest(scene_, rays, truth);
        result_.brute_force_rays += rays.size();
        for (std::size_t k = 0; k < rays.size(); ++k) {
            const Hit& ours = traversal.hits[paths[k]];
            if (same_bits(ours, truth[k])) continue;
            Failure failure = hit_failure("brute-force", traversal, paths[k], spp_,
                                          "not the hit that testing every triangle gives");
            failure.expected = exact(truth[k]);
            failure.found = exact(ours);
            add(std::move(failure));
        }
    }

    void against_embree(const TraversalRecord& traversal) {
        const std::size_t n = traversal.rays.size();
        std::vector<Hit> theirs(n);
        embree_.closest(traversal.rays, theirs);
        std::vector<std::uint8_t> occluded;
        if (traversal.is_shadow()) {
            occluded.resize(n);
            embree_.occluded(traversal.rays, occluded);
        }
        std::vector<std::size_t> differing;
        for (std::size_t i = 0; i < n; ++i) {
            if (is_dead(traversal.rays[i])) continue;
            ++result_.embree_rays;
            const Hit& ours = traversal.hits[i];
            bool differs = ours.primitive != theirs[i].primitive;
            if (!occluded.empty()) {
                ++result_.occlusion_rays;
                differs = differs || is_hit(ours) != (occluded[i] != 0);
            }
            if (differs) differing.push_back(i);
        }
        std::vector<std::pair<Adjudication, Adjudication>> verdicts(differing.size());
        tbb::parallel_for(std::size_t{0}, differing.size(), [&](std::size_t k) {
            const std::size_t i = differing[k];
            const Hit& ours = traversal.hits[i];
            verdicts[k].first =
                reference::adjudicate_closest(scene_, traversal.rays[i], ours, theirs[i]);
            if (!occluded.empty()) {
                verdicts[k].second = reference::adjudicate_occluded(
                    scene_, traversal.rays[i], is_hit(ours), occluded[i] != 0, theirs[i]);
            }
        });
        for (std::size_t k = 0; k < differing.size(); ++k) {
            count(traversal, differing[k], verdicts[k].first, theirs[differing[k]]);
            count(traversal, differing[k], verdicts[k].second, theirs[differing[k]]);
        }
    }

 private:
    void add(Failure failure) {
        if (result_.failures.size() < kMaxFailures) result_.failures.push_back(std::move(failure));
    }

    void expect_nothing(const TraversalRecord& traversal, std::size_t path) {
        if (!is_hit(traversal.hits[path])) return;
        Failure failure =
            hit_failure("brute-force", traversal, path, spp_, "a dead ray has hit something");
        failure.expected = "no hit";
        failure.found = exact(traversal.hits[path]);
        add(std::move(failure));
    }

    void count(const TraversalRecord& traversal, std::size_t path, const Adjudication& adjudication,
               const Hit& theirs) {
        if (adjudication.verdict == Disagreement::none) return;
        result_.excused[path] = true;
        switch (adjudication.verdict) {
            case Disagreement::tie:
                ++result_.ties;
                break;
            case Disagreement::grazing:
                ++result_.grazing;
                break;
            case Disagreement::embree_wrong:
                ++result_.embree_wrong;
                break;
            case Disagreement::ours_wrong:
            case Disagreement::none:
                ++result_.ours_wrong;
                Failure failure = hit_failure("embree", traversal, path, spp_,
                                              "ours is wrong: " + adjudication.explanation);
                failure.expected = exact(theirs);
                failure.found = exact(traversal.hits[path]);
                add(std::move(failure));
                break;
        }
    }

    const reference::Scene& scene_;
    const reference::EmbreeTracer& embree_;
    std::uint32_t spp_;
    const HitCheckSettings& settings_;
    HitCheckResult& result_;
};

}  // namespace

HitCheckResult& HitCheckResult::operator+=(const HitCheckResult& other) {
    traversals += other.traversals;
    rays += other.rays;
    brute_force_rays += other.brute_force_rays;
    embree_rays += other.embree_rays;
    occlusion_rays += other.occlusion_rays;
    ties += other.ties;
    grazing += other.grazing;
    embree_wrong += other.embree_wrong;
    ours_wrong += other.ours_wrong;
    excused.clear();
    failures.insert(failures.end(), other.failures.begin(), other.failures.end());
    return *this;
}

ImageCheckResult& ImageCheckResult::operator+=(const ImageCheckResult& other) {
    pixels += other.pixels;
    identical += other.identical;
    excused += other.excused;
    failures.insert(failures.end(), other.failures.begin(), other.failures.end());
    return *this;
}

HitCheckResult check_hits(const reference::Scene& scene, const Recording& recording,
                          const reference::EmbreeTracer& embree, std::uint32_t spp,
                          const HitCheckSettings& settings) {
    HitCheckResult result;
    result.excused.assign(recording.radiance.size(), false);
    result.rays = recording.living_rays();
    const double all_tests =
        static_cast<double>(result.rays) * static_cast<double>(scene.triangles.size());
    const double fraction = static_cast<double>(settings.brute_force_tests) / all_tests;
    constexpr double kTwo64 = 18446744073709551616.0;
    const std::uint64_t keep_below =
        fraction < 1.0 ? static_cast<std::uint64_t>(fraction * kTwo64) : ~std::uint64_t{0};
    Check check(scene, embree, spp, settings, result);
    for (const TraversalRecord& traversal : recording.traversals) {
        if (!stage_matches(settings.stage_pattern, traversal.stage())) continue;
        ++result.traversals;
        check.against_brute_force(traversal, keep_below);
        check.against_embree(traversal);
    }
    return result;
}

ImageCheckResult check_image(const reference::Image& ours, const reference::Image& embree,
                             const std::vector<bool>& excused, std::uint32_t spp) {
    SCOTTY_ASSERT(ours.pixels.size(), ==, embree.pixels.size());
    ImageCheckResult result;
    result.pixels = ours.pixels.size();
    for (std::size_t p = 0; p < ours.pixels.size(); ++p) {
        if (same_bits(ours.pixels[p], embree.pixels[p])) {
            ++result.identical;
            continue;
        }
        bool reason = false;
        for (std::size_t s = 0; s < spp; ++s) {
            reason = reason || (p * spp + s < excused.size() && excused[p * spp + s]);
        }
        if (reason) {
            ++result.excused;
            continue;
        }
        Failure failure;
        failure.invariant = "embree-image";
        failure.stage = "reconstruct_image";
        failure.field = fmt::format("image[{}] (x {}, y {})", p, p % ours.width, p / ours.width);
        failure.sentence =
            "the pixel is not the one that the same paths through Embree give, and no ray of it "
            "was adjudicated a tie, grazing or Embree's mistake";
        failure.expected = exact(embree.pixels[p]);
        failure.found = exact(ours.pixels[p]);
        if (result.failures.size() < kMaxFailures) result.failures.push_back(std::move(failure));
    }
    return result;
}

}  // namespace scotty::verify
