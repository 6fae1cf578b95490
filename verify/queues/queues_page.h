/// The page of the queue debugger: the model as a document with arrays, and the document as a page.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "verify/queues/queues.h"

namespace scotty::verify {

struct PageRequest {
    /// What is shown first; without a launch the first divergence. The launches around it are
    /// embedded first.
    std::optional<std::uint32_t> launch, node, ray;
    std::optional<std::pair<std::uint32_t, std::uint32_t>> pixel;
    /// Characters that the page's arrays may take; counts are embedded whatever they take.
    std::size_t room = 7'500'000;
};

/// What the page draws from. `b` may be null. Judged before it is written: verdicts of the diff,
/// invariants of both runs, outcomes of all visits and the alignment of queues; the page only
/// looks them up. Arrays are numbers of "pool" (page_arrays.h); docs/debugging-queues.md names the
/// rest.
nlohmann::json queues_page_data(const Queues& a, const Queues* b, const PageRequest& request);

/// One file, no network.
std::string queues_page(const Queues& a, const Queues* b, const PageRequest& request);

}  // namespace scotty::verify
