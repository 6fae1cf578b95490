/// Shared by the parts of the diff (diff*.cpp).
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reference/contract/wide_bvh.h"
#include "verify/capture/canonical.h"
#include "verify/capture/capture.h"
#include "verify/capture/finite.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

using reference::Field;
using reference::Row;

/// A value as reports show it: "0x3f800001 (1.00000012)".
std::string value_text(std::uint32_t bits, bool is_float);
/// Floats between two: 0 for equal ones, 1 for neighbours, and for +0 and -0. None with a NaN.
std::optional<std::uint64_t> ulps_between(std::uint32_t a, std::uint32_t b);

/// Two versions of one buffer.
struct BufferPair {
    const reference::StageView& a_stage;
    const reference::BufferView& a;
    const reference::StageView& b_stage;
    const reference::BufferView& b;
    bool output;
};

struct Comparison {
    Verdict verdict = Verdict::identical;
    std::uint64_t different = 0;
    // The first difference, if there is one.
    std::size_t row = 0;
    std::uint32_t entry_ray =
        reference::kNotApplicable;  ///< queue, pairs: the ray that it is about
    std::uint32_t entry_inner = reference::kNotApplicable;      ///< pairs: its inner node
    std::uint32_t entry_primitive = reference::kNotApplicable;  ///< hits: the hit's primitive
    std::string field, a, b, sentence;
    std::optional<std::uint64_t> ulps;
    std::optional<std::size_t> word;  ///< in B's buffer: the value that should not be there
};

Comparison compare_ordered(const BufferPair& pair);
Comparison compare_queues(const BufferPair& pair);
Comparison compare_hit_lists(const BufferPair& pair);
Comparison compare_pairs(const BufferPair& pair);
/// Compares only whether something is hit.
Comparison compare_occlusion(const BufferPair& pair);
/// Calls the one of the above that the buffer's order needs.
Comparison compare(const BufferPair& pair);

/// Finds a value that must be finite and is not, by the rules of verify/capture/finite.h.
std::optional<NonFinite> find_non_finite(const reference::StageView& stage,
                                         const reference::BufferView& output);

/// Finds nodes, blocks and pixels from indices.
class Places {
 public:
    /// `bvh` may be null. Both are borrowed.
    Places(const Capture& capture, const reference::WideBvh* bvh);

    /// Fills in level, node, block, ray, pixel and sample of the pair's first difference.
    void fill(Divergence& out, const BufferPair& pair, const Comparison& first);
    /// Pixel and sample of out.ray.
    void fill_provenance(Divergence& out, std::uint32_t batch);

 private:
    std::uint32_t node_id(std::uint32_t level, std::size_t position) const;
    /// Fills in the logical block and thread that take a ray of a node of the stage's level.
    void fill_thread(Divergence& out, const BufferPair& pair, std::uint32_t node);
    /// The same for a ray of an inner node, with queues of pairs.
    void fill_pair_thread(Divergence& out, const BufferPair& pair, std::uint32_t inner);
    std::uint32_t node_of_inner(std::uint32_t inner) const;
    std::uint32_t last_queue_of(std::uint32_t primitive);

    const Capture& capture_;
    const reference::WideBvh* bvh_;
    std::vector<std::uint32_t> last_queues_;  ///< by primitive; made on first use
    struct Origins {
        std::vector<std::uint32_t> pixel, sample;
    };
    std::map<std::uint32_t, Origins> origins_;  ///< by batch
};

}  // namespace scotty::verify
