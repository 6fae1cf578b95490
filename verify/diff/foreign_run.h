/// Shared by the parts of the diff with another program's run (foreign*.cpp).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "verify/backends/backend.h"
#include "verify/capture/capture.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

/// The capture's tree, as its program numbers it.
struct ForeignTree {
    PipelineInput input;
    std::vector<std::uint64_t> node_ids;  ///< by breadth-first id
    std::vector<std::uint32_t> leaf_of;   ///< node id by primitive
    std::vector<std::string> violations;  ///< of validate()
};
/// Throws bad_input where the capture's input cannot be used.
ForeignTree read_foreign_tree(const Capture& capture);

/// What is known of one traversal while its stages are judged, by ray unless stated otherwise.
struct ForeignQuery {
    std::string prefix;  ///< "bounce0/light1/"
    bool asks_any = false;
    std::vector<reference::Ray> rays;
    std::vector<bool> sound;         ///< finite, with a direction: it can be judged
    std::vector<std::uint64_t> ids;  ///< the program's own; behind them those of no ray
    std::vector<reference::Hit> truth;
    std::vector<std::vector<reference::HitCandidate>> leaf_hits;  ///< on the capture's queues
    std::vector<bool> given;                                      ///< by node: its queue is
    bool has_hits = false, has_answers = false;

    std::uint32_t count() const { return static_cast<std::uint32_t>(rays.size()); }
};

/// One stage's verdict, as its differences are found; the first leads.
class ForeignVerdict {
 public:
    ForeignVerdict(const Capture& capture, const ForeignTree& tree, const ForeignQuery& query,
                   const reference::StageView& stage);

    /// `node` is a breadth-first id; kNotApplicable where there is none.
    void fail(const char* buffer, std::uint32_t node, std::uint32_t ray, std::string sentence,
              std::string found, std::string expected,
              std::uint32_t block = reference::kNotApplicable);
    void excuse(const char* buffer) {
        buffer_named(buffer).verdict = excused(buffer);
        ++excused_;
    }
    /// The buffer was judged; it is identical until something else is said.
    void judged(const char* buffer) { buffer_named(buffer); }
    bool is_judged() const { return !result_.buffers.empty(); }
    bool has_first() const { return result_.first.has_value(); }
    /// So many that the next need not be told from rounding.
    bool has_many(const char* buffer) { return buffer_named(buffer).different >= 1000; }
    std::uint64_t excused_count() const { return excused_; }
    StageResult take();

 private:
    BufferResult& buffer_named(const char* name);
    Verdict excused(const char* buffer) {
        return std::max(buffer_named(buffer).verdict, Verdict::within_tolerance);
    }

    const Capture& capture_;
    const ForeignTree& tree_;
    const ForeignQuery& query_;
    StageResult result_;
    reference::StageView stage_;
    std::uint64_t excused_ = 0;
};

/// Judges the queues that a level has written, and notes what its leaves must find.
void judge_foreign_level(const reference::StageView& stage, const ForeignTree& tree,
                         const Backend& backend, bool culls, ForeignQuery& query,
                         ForeignVerdict& verdict);
/// Judges gathered hits and answers.
void judge_foreign_hits(const reference::StageView& stage, const ForeignTree& tree, bool culls,
                        const ForeignQuery& query, ForeignVerdict& verdict);

}  // namespace scotty::verify
