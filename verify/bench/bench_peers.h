/// Other tracers' programs on the rays of a benchmark: `scotty bench cuda SCENE --peers FOLDER`.
///
/// Every executable file of the folder is a peer. It is started as
///
///     PEER SCENE.scn RAYS.ray HITS WARM_UPS REPEATS
///
/// with files as in verify/capture/ray_file.h, builds what it needs, traces the rays WARM_UPS +
/// REPEATS times, writes the hits (HITS has no header), prints a line "seconds X" for each of the
/// REPEATS rounds, and ends with exit code 0. What a round's time has in it is the peer's own
/// choice; ours is the traversal of rays that lie where it reads them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "verify/base/scratch_folder.h"
#include "verify/bench/bench_subject.h"
#include "verify/bench/measure.h"
#include "verify/capture/ray_file.h"

namespace scotty::verify {

/// A peer on the rays of one kind.
struct PeerRays {
    std::string kind;  ///< as BenchRays calls it
    std::uint64_t rays = 0;
    Spread seconds{};           ///< of tracing all of them; zero where it failed
    std::uint64_t wrong = 0;    ///< hits that are neither right nor a tie or a grazing edge
    std::uint64_t excused = 0;  ///< ties and grazing edges
    std::string failure;        ///< why there are no figures; empty if there are

    double rate() const { return static_cast<double>(rays) / seconds.median; }
};

struct Peer {
    std::string name;  ///< the program's file name
    std::vector<PeerRays> kinds;

    /// All kinds added up. Its failure is the first one.
    PeerRays all() const;
};

/// The programs in a folder, in the order of their names. Throws bad_input where there is none.
std::vector<std::string> peer_names(const std::filesystem::path& folder);

/// The peers of a folder, on one scene.
class PeerRuns {
 public:
    /// Throws as peer_names().
    PeerRuns(const std::filesystem::path& folder, const reference::Scene& scene,
             const BenchSettings& settings);

    /// Runs every peer on these rays. `expected`: Embree's hits, one per ray, from which those that
    /// differ are adjudicated. A peer that fails is noted, and the others run.
    void run(const std::string& kind, const RayFile& rays,
             std::span<const reference::HitCandidate> expected);

    const std::vector<Peer>& peers() const { return peers_; }

 private:
    PeerRays run_one(const Peer& peer, const std::string& kind, const RayFile& rays,
                     std::span<const reference::HitCandidate> expected) const;

    std::filesystem::path folder_;
    const reference::Scene& scene_;
    const BenchSettings& settings_;
    ScratchFolder scratch_;
    std::vector<Peer> peers_;
};

/// `ours`: seconds of the subject on the same kinds, in the peers' order, and last of all of them.
std::string table(const std::vector<Peer>& peers, std::span<const Spread> ours);
nlohmann::json to_json(const std::vector<Peer>& peers, std::span<const Spread> ours);

}  // namespace scotty::verify
