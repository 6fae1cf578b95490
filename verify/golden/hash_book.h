/// Hashes of small runs: what their scenes, trees, rays, hits, images and work came to when
/// somebody last approved it (golden/hashes.txt).
///
/// Launches, back ends and oracles can agree on a change of what they share. A hash cannot.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/contract/launch_record.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/wide_bvh.h"
#include "verify/capture/failure.h"
#include "verify/capture/recording.h"

namespace scotty::verify {

/// The name of the check in reports.
inline constexpr const char* kGoldenHash = "golden-hash";

/// What is hashed, as "tree coil --width 8 ...", and its hash.
using Hashes = std::map<std::string, std::uint64_t>;

/// One line a hash: 16 hexadecimal digits and what they are of.
std::string to_text(const Hashes& hashes);
/// Throws bad_input naming file and line.
Hashes read_hashes(const std::filesystem::path& file);

/// XXH64.
std::uint64_t hash_of_text(std::string_view text);

/// Of the contract's tables of parameters (with their defaults), buffers and stages, of the orders
/// that schedules make, and of what the shared numerics compute: "table of ...".
Hashes table_hashes();
/// The last of them (numerics_hashes.cpp).
std::uint64_t hash_of_numerics();
/// Of a scene as the renderer gets it, and of what it was warned of: "scene S", "warnings S"; of a
/// small one also of the tree by median splits: "median-tree S".
Hashes scene_hashes(const std::string& scene, const reference::Scene& data);
/// Of the tree that these parameters make, and of where each triangle's last queue is in it: "tree
/// S
/// --width 8 --leaf-size 4 --queue-levels 0", "last-queues S ...".
Hashes tree_hashes(const std::string& scene, const reference::PipelineParameters& parameters,
                   const reference::WideBvh& bvh);
/// Of everything that a picture is made of, whatever the way to make it: "rays S --size 5x3 ...",
/// "hits ...", "image ...".
Hashes picture_hashes(const std::string& scene, const reference::PipelineParameters& parameters,
                      const Recording& recording);

/// What every launch of a run was: its grid, the shapes of its buffers, the rays and hits that it
/// has queued, in their order. Two runs under one schedule do the same work, so a run that culls
/// less than it did, or takes another way, is seen here, and only here.
class WorkHasher : public reference::StageObserver {
 public:
    void on_batch(std::uint64_t done, std::uint64_t count) override;
    void on_stage(const reference::StageView& stage) override;
    /// What a pipeline says of its launches, without their times, and of its memory.
    void add(const std::vector<reference::LaunchRecord>& launches, std::size_t device_bytes);
    void add(std::string_view text);
    std::uint64_t hash() const { return hash_; }

 private:
    std::uint64_t hash_ = 0;
};

/// What a hash of the CUDA text's work is of; "work" is the emulator's. Only of the first cases, as
/// that text takes its time on a CPU.
inline constexpr const char* kWorkOfText = "work-simt";

/// What the runs of a verification are held against, or what they leave behind to be approved.
class HashBook {
 public:
    /// Nothing is known: runs are recorded.
    HashBook() = default;
    /// `complete`: a run that is not in the book is a failure, as the book has all of these runs.
    HashBook(Hashes golden, bool complete) : golden_(std::move(golden)), complete_(complete) {}

    bool records() const { return !golden_; }
    /// The failures of these hashes, in the order of tables, scene, trees, rays, hits, image and
    /// work, as each makes the next. May be called by several threads at a time.
    std::vector<Failure> look_up(const Hashes& found);

    std::uint64_t compared() const { return compared_; }
    /// How many hashes there are to be compared with.
    std::uint64_t size() const { return golden_ ? golden_->size() : 0; }
    const Hashes& recorded() const { return recorded_; }

 private:
    std::optional<Hashes> golden_;
    bool complete_ = false;
    std::mutex mutex_;  ///< of the two below
    Hashes recorded_;
    std::uint64_t compared_ = 0;
};

}  // namespace scotty::verify
