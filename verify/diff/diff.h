/// Two runs held against each other, kernel launch by kernel launch, bit for bit.
///
/// What counts as equal: docs/captures.md, after docs/design.md section 5. With early-out
/// `immediate` what a level queues and gathers depends on timing: both runs are then held to the
/// invariants (verify/invariants/invariants.h), which are the set bounds of the contract.
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

/// In order of gravity: a stage's verdict is its buffers' worst.
enum class Verdict : std::uint8_t {
    identical,         ///< the same bytes, unused memory apart
    reordered,         ///< other bytes, the same canonical form, in a buffer whose order is free
    within_tolerance,  ///< fast arithmetic: by the array's tolerance (verify/diff/tolerance.h)
    within_bounds,     ///< depends on timing (`immediate`); each run keeps the set bounds
    not_comparable,    ///< depends on timing, and the capture holds too little to check the bounds
    differs
};
const char* to_string(Verdict verdict);

/// Where two runs part.
struct Divergence {
    std::string stage;
    std::uint32_t launch = reference::kNotApplicable;
    std::uint32_t level = reference::kNotApplicable;
    std::uint32_t node = reference::kNotApplicable;    ///< breadth-first id; position without a BVH
    std::uint32_t block = reference::kNotApplicable;   ///< logical block that wrote it
    std::uint32_t thread = reference::kNotApplicable;  ///< of the block: the ray's
    std::uint32_t ray = reference::kNotApplicable;
    std::string buffer;
    std::string field;   ///< "direction.x"; empty where an element is one number
    bool input = false;  ///< the stage was handed it so
    std::string a, b;    ///< hexadecimal and decimal
    std::optional<std::uint64_t> ulps;
    std::string sentence;
    std::uint32_t pixel_x = reference::kNotApplicable;  ///< where the ray came from
    std::uint32_t pixel_y = reference::kNotApplicable;
    std::uint32_t sample = reference::kNotApplicable;
    std::string replay;  ///< the command that runs the stage again
    /// Kernel, thread and line that wrote B's value, where B checks what its kernels touch.
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
    std::uint64_t not_compared = 0;  ///< on one side only, because only that side was asked for it

    bool passed() const;
    /// Of the first stage that failed; null where none has one.
    const Divergence* first() const;
    std::uint64_t non_finite_values() const;
    const NonFinite* first_non_finite() const;
};

struct DiffOptions {
    std::vector<std::string> patterns;  ///< stages to compare; none: all
    std::string b_backend;              ///< for the replay command
    /// Backend::written_by of who runs B.
    std::function<std::string(const void*)> written_by;
    /// A stage alone: inputs are the capture's own, and bounds over a whole run do not apply.
    bool isolated = false;
    /// B's, where it is not A's.
    reference::Arithmetic b_arithmetic = reference::Arithmetic::exact;
    /// Where A goes with the command: what to run again instead of replaying a stage of A.
    std::string rerun;
};

/// Compares stages with a capture's as they come.
class Differ : public reference::StageObserver {
 public:
    /// `a` is borrowed. Reads its pipeline input where it has one: without, nodes are named by
    /// their position in the level.
    Differ(const Capture& a, DiffOptions options);
    ~Differ() override;

    void on_stage(const reference::StageView& b) override;
    void on_retry(std::string_view stage, std::string_view reason) override;
    /// A stage of B of which only the index is left: compared by hash.
    void add_by_hash(const StageRecord& b);
    /// A stage of A that B could not run, and why.
    void add_error(const StageRecord& stage, const std::string& what);

    /// B's run has failed: the stage of A behind the last that came is the one that could not be
    /// run.
    void add_end(const std::string& what);

    /// Closes the books. `covers`: whether B was asked for a stage of that name.
    DiffReport finish(const std::function<bool(std::string_view)>& covers);

 private:
    class State;
    std::unique_ptr<State> state_;
};

/// Throws bad_input naming what differs where two captures cannot be compared: another scene, BVH
/// or parameter. The hit capacity may differ.
void expect_comparable(const Capture& a, const Capture& b);

/// Where one of them has no buffers any more (an index travels lighter), by hash: which stage and
/// buffer part first, but not where in it.
DiffReport diff_captures(const Capture& a, const Capture& b, DiffOptions options = {});
/// The same by the indices' hashes alone, whatever else there is: no buffer is read.
DiffReport diff_by_hash(const Capture& a, const Capture& b, DiffOptions options = {});

/// The report for people: non-finite values, the first divergence, a table by stage kind.
std::string to_text(const DiffReport& report);
nlohmann::ordered_json to_json(const DiffReport& report);
nlohmann::ordered_json to_json(const StageResult& stage);
/// "launch 12 bounce0/level3/intersect, level 3, node 40, block 7, ray 1234 ..." and what follows.
std::string to_text(const Divergence& divergence);

}  // namespace scotty::verify
