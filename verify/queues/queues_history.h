/// A ray's whole way through a captured run: every queue it waited in, every child it was pushed
/// to or kept out of and why, every hit it gathered, and what became of its path.
///
/// What was done is read from the buffers; what had to be done is recomputed
/// (verify/invariants/expected.h). Where the two part, the outcome is `lost` or `extra`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "verify/queues/queues.h"

namespace scotty::verify {

enum class Outcome : std::uint8_t {
    missed,  ///< the ray does not enter the child's box
    culled,  ///< it enters beyond the nearest hit known
    pushed,
    lost,   ///< it enters, and is not in the child's queue
    extra,  ///< it is in the child's queue, and must not be
    tested  ///< with a queue of pairs: it enters a leaf, which the launch itself has tested
};
const char* to_string(Outcome outcome);

enum class LeafOutcome : std::uint8_t {
    none,      ///< no triangle is hit
    beyond,    ///< the hit is farther than the nearest one known
    buffered,  ///< packed mode: it became the ray's nearest
    passed,    ///< packed mode: there was a nearer one already
    lost,      ///< there is a hit, and it was not buffered
    other      ///< buffered, but it is not the leaf's closest
};
const char* to_string(LeafOutcome outcome);

struct GatheredHit {
    std::uint32_t slot = 0;  ///< of the ray's buffer; 0 in packed mode
    reference::HitCandidate hit{};
    bool won = false;  ///< it became the ray's hit at the merge
};

/// What a launch has found for the ray in a leaf.
struct LeafVisit {
    LeafOutcome leaf_outcome = LeafOutcome::none;
    reference::HitCandidate closest{};  ///< of the leaf's triangles, recomputed
    std::vector<GatheredHit> hits;      ///< what the launch buffered for the ray from this leaf
};

struct ChildVisit {
    std::uint32_t node = 0;
    Outcome outcome = Outcome::missed;
    std::optional<float> entry;             ///< where it enters; none where it misses the box
    std::optional<std::uint32_t> position;  ///< in the child's queue
    std::uint32_t times = 0;                ///< in the child's queue; 1 where all is well
    std::optional<LeafVisit> tested;        ///< what came of the leaf
};

/// The ray as one entry of one node's queue; of a leaf or a subtree also what was found there.
struct Visit : LeafVisit {
    std::string stage;
    std::uint32_t launch = 0, level = 0, node = 0;
    std::uint32_t position = 0;  ///< in the node's queue
    std::uint32_t block = 0, thread = 0;
    bool leaf = false;                 ///< rays are not pushed on
    bool subtree = false;              ///< that kind of leaf: each ray goes on depth first
    std::optional<float> minimum;      ///< that it was culled by; none without early-out
    std::vector<ChildVisit> children;  ///< of an inner node, in order of their ids
};

struct TraversalHistory {
    std::string name;  ///< "bounce0/light1"
    std::uint32_t bounce = reference::kNotApplicable, light = reference::kNotApplicable;
    std::optional<reference::Ray> ray;
    std::vector<Visit> visits;
    std::vector<GatheredHit> stray;  ///< buffered hits from no leaf that the ray was in
    std::vector<std::string> gaps;   ///< launches that were not captured
    std::optional<std::uint32_t> merge_launch;
    std::optional<reference::Hit> merged;
    std::uint32_t winner_node = reference::kNone;  ///< the leaf of the hit that won
};

struct LightHistory {
    std::uint32_t light = 0;
    std::optional<reference::Ray> shadow_ray;  ///< dead: there was nothing to ask
    std::optional<reference::Vec3> potential;  ///< radiance if nothing is in the way
    TraversalHistory traversal;
    std::optional<reference::Vec3> radiance;  ///< of the path, after resolve_light
};

/// One vertex of the path: what the ray met, its light, and where it went on to.
struct BounceHistory {
    std::uint32_t bounce = 0;
    TraversalHistory traversal;
    std::vector<LightHistory> lights;
    std::optional<std::uint32_t> flags;  ///< after scene_rays: reference::kPathAlive ...
    std::optional<reference::Ray> next;  ///< dead where the path ended
    std::optional<reference::Vec3> throughput;
    std::optional<reference::Vec3> radiance;  ///< of the path, after scene_rays
};

struct RayHistory {
    std::uint32_t batch = 0, ray = 0;
    std::optional<Provenance> from;
    /// Early-out `immediate`: minima are those that the launch left behind, not those it read.
    bool minimum_is_later = false;
    std::vector<BounceHistory> bounces;
    std::optional<reference::Vec3> radiance;  ///< handed to reconstruct_image
    std::optional<reference::Vec3> pixel;     ///< of the image, after the last pass
};

/// True where there is a ray and it is not dead.
bool is_alive(const std::optional<reference::Ray>& ray);

/// The histories of some rays of one batch, in the order asked for; every launch is read once.
/// `wanted`: only what these launches tell; of a traversal all from its first level on, because the
/// hits that a launch has added are found by what was there before it. Throws bad_input where there
/// is no such batch or ray, saying how many there are.
std::vector<RayHistory> histories(const Queues& queues, std::uint32_t batch,
                                  const std::vector<std::uint32_t>& rays,
                                  const std::function<bool(const StageRecord&)>& wanted = {});

}  // namespace scotty::verify
