/// Compares two runs, kernel launch by kernel launch, bit for bit.
///
/// docs/captures.md says what counts as equal, and docs/design.md why. With early-out `immediate` a
/// level's queues and gathered hits depend on timing: both runs then have to keep the invariants
/// (verify/invariants/invariants.h), which are the set bounds of the contract.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reference/contract/stage_observer.h"
#include "verify/capture/capture.h"

namespace scotty::verify {

/// In order of gravity: a stage's verdict is the worst of its buffers'.
enum class Verdict : std::uint8_t {
    identical,         ///< the same bytes, unused memory excepted
    reordered,         ///< other bytes, the same canonical form, in a buffer with free order
    within_tolerance,  ///< fast arithmetic: within the array's tolerance (verify/diff/tolerance.h)
    within_bounds,     ///< depends on timing (`immediate`); each run keeps the set bounds
    not_comparable,    ///< depends on timing, and the capture holds too little to check the bounds
    differs
};
const char* to_string(Verdict verdict);

/// The place where two runs part.
struct Divergence {
    std::string stage;
    std::uint32_t launch = reference::kNotApplicable;
    std::uint32_t level = reference::kNotApplicable;
    std::uint32_t node = reference::kNotApplicable;    ///< breadth-first id; position without a BVH
    std::uint32_t block = reference::kNotApplicable;   ///< logical block that wrote it
    std::uint32_t thread = reference::kNotApplicable;  ///< of the block: the ray's thread
    std::uint32_t ray = reference::kNotApplicable;
    std::string buffer;
    /// As the capture's own program calls them.
    std::optional<std::uint64_t> own_node, own_ray;
    std::string field;   ///< "direction.x"; empty if an element is one number
    bool input = false;  ///< the difference is in the stage's input
    std::string a, b;    ///< hexadecimal and decimal
    std::optional<std::uint64_t> ulps;
    std::string sentence;
    std::uint32_t pixel_x = reference::kNotApplicable;  ///< the origin of the ray
    std::uint32_t pixel_y = reference::kNotApplicable;
    std::uint32_t sample = reference::kNotApplicable;
    std::string replay;  ///< the command that runs the stage again
    /// Kernel, thread and line that wrote B's value, if B checks its kernels' accesses.
    std::string written_by;
};

struct BufferResult {
    std::string name;
    bool input = false;
    Verdict verdict = Verdict::identical;
    std::uint64_t different = 0;  ///< elements, or entries of queues and hit lists
};

struct NonFinite {
    bool in_b = false;
    std::string stage;
    std::uint32_t launch = 0;
    std::string buffer;
    std::uint64_t values = 0;
    std::uint32_t first_row = 0;  ///< ray id, or pixel of an image
    std::string field;
    std::string value;
};

struct StageResult {
    std::string name;
    reference::StageKind kind = reference::StageKind::primary_rays;
    std::uint32_t launch = 0;
    Verdict verdict = Verdict::identical;
    bool missing = false;  ///< on one side; the divergence says on which
    std::vector<BufferResult> buffers;
    std::optional<Divergence> first;
    std::vector<NonFinite> non_finite;

    bool failed() const { return verdict == Verdict::differs || !non_finite.empty(); }
};

struct DiffReport {
    std::string a, b;  ///< what was compared: a directory, or "a run of the emulator"
    std::string a_backend, b_backend;
    bool isolated = false;
    std::vector<StageResult> stages;
    /// Of a capture of another program (verify/diff/foreign.h): what it does not hold, what is
    /// wrong with its tree, and how often a difference is one that rounding may make.
    std::vector<std::string> not_given, tree_violations;
    std::uint64_t excused = 0;
    std::uint64_t not_compared = 0;  ///< on one side only, because only that side was asked for it

    bool passed() const;
    /// The divergence of the first stage that failed; null if none has one.
    const Divergence* first() const;
    std::uint64_t non_finite_values() const;
    const NonFinite* first_non_finite() const;
};

struct DiffOptions {
    std::vector<std::string> patterns;  ///< stages to compare; empty: all
    std::string b_backend;              ///< for the replay command
    /// Backend::written_by of B's back end.
    std::function<std::string(const void*)> written_by;
    /// A stage alone: inputs are the capture's own, and bounds over a whole run do not apply.
    bool isolated = false;
    /// B's arithmetic, which may differ from A's.
    reference::Arithmetic b_arithmetic = reference::Arithmetic::exact;
    /// If A goes with the command: what to run again instead of replaying a stage of A.
    std::string rerun;
};

/// Compares stages with a capture's as they come.
class Differ : public reference::StageObserver {
 public:
    /// `a` is borrowed. Reads its pipeline input if it has one; without it, nodes are named by
    /// their position in the level.
    Differ(const Capture& a, DiffOptions options);
    ~Differ() override;

    void on_stage(const reference::StageView& b) override;
    void on_retry(std::string_view stage, std::string_view reason) override;
    /// Adds a stage of B of which only the index is left, compared by hash.
    void add_by_hash(const StageRecord& b);
    /// Adds a stage of A that B could not run, and the reason.
    void add_error(const StageRecord& stage, const std::string& what);

    /// B's run has failed: the stage of A after the last one seen is the one that could not run.
    void add_end(const std::string& what);

    /// Completes the report. `covers`: whether B was asked for a stage of that name.
    DiffReport finish(const std::function<bool(std::string_view)>& covers);

 private:
    class State;
    std::unique_ptr<State> state_;
};

/// Throws bad_input naming the difference if two captures cannot be compared: another scene, BVH or
/// parameter. The hit capacity may differ.
void expect_comparable(const Capture& a, const Capture& b);

/// If one of them has no buffers any more (an index travels lighter), compares by hash, which finds
/// the stage and buffer that part first, but not the place in it.
DiffReport diff_captures(const Capture& a, const Capture& b, DiffOptions options = {});
/// Compares by the indices' hashes alone: no buffer is read.
DiffReport diff_by_hash(const Capture& a, const Capture& b, DiffOptions options = {});

/// The report for people: non-finite values, the first divergence, a table by stage kind.
std::string to_text(const DiffReport& report);
nlohmann::ordered_json to_json(const DiffReport& report);
nlohmann::ordered_json to_json(const StageResult& stage);
/// "launch 12 bounce0/level3/intersect, level 3, node 40, block 7, ray 1234 ..." and the rest.
std::string to_text(const Divergence& divergence);

}  // namespace scotty::verify
