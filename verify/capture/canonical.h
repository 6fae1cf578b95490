/// Canonical forms: what of a buffer the contract fixes, and what is unused memory or free order.
///
/// A queue buffer is laid out in regions, one a node; only the first count entries of a region are
/// in use, in whatever order blocks came. A queue of pairs is one such region. A multi-intersection
/// buffer holds each ray's hits in whatever order leaves came. Unused memory is never compared,
/// hashed or stored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/owned_buffer.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_observer.h"

namespace scotty::verify {

/// The regions of a buffer whose order is free, in elements of the buffer.
struct Regions {
    struct Region {
        std::size_t begin = 0;
        std::size_t room = 0;     ///< elements
        std::size_t count = 0;    ///< of them in use, never more than room
        std::size_t claimed = 0;  ///< what the counter says: more than room where it overflowed
    };
    std::vector<Region> regions;
    std::size_t element_bytes = 4;
};

/// Regions of "queue", "child_queue" or "hits" as the stage's other buffers tell them, and the one
/// of "pairs" or "child_pairs"; none for any other buffer and where those are missing. `output`:
/// which of the stage's lists it is in. Offsets that lead out of the buffer are cut off at its end.
Regions regions_of(const reference::StageView& stage, const reference::BufferView& buffer,
                   bool output);

/// The buffer's bytes with unused memory overwritten: ids and primitives by kNone, t by +infinity.
std::vector<std::byte> without_unused(const reference::BufferView& buffer, const Regions& regions);

/// Of each region the count and the elements in use, sorted; all bytes where the order is fixed.
/// Hits of one ray sort by t, then primitive; pairs by node, then ray.
std::vector<std::byte> canonical_bytes(const reference::BufferView& buffer, const Regions& regions);

/// An element, by its index in the buffer: an id, a hit as t bits << 32 | primitive, or a pair as
/// node << 32 | ray.
std::uint64_t entry_of(const reference::BufferView& buffer, const Regions& regions,
                       std::size_t element);

/// The elements in use of one region, sorted, each as entry_of() has it.
std::vector<std::uint64_t> sorted_entries(const reference::BufferView& buffer,
                                          const Regions& regions, std::size_t region);

/// All of a stage's outputs in canonical form, one after the other: equal where nothing that is
/// fixed differs. Under early-out `immediate` nothing that traversal gathers is: empty then.
std::string canonical_outcome(const reference::StageView& stage,
                              const std::vector<reference::OwnedBuffer>& outputs,
                              const reference::PipelineParameters& parameters);

}  // namespace scotty::verify
