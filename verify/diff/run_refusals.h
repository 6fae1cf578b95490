/// What a pipeline must not run: launches with spoiled inputs, rays that no kernel can rely on, and
/// trees that lead more rays to a queue than it has room for. What the errors say is added to
/// `said`, where there is one.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "verify/backends/backend.h"
#include "verify/capture/capture.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

/// Spoils what a launch that is run alone is handed, as the tables of the contract describe it: a
/// buffer that is missing, cut short, too long or of other elements; the first, the middle and the
/// last of what indexes something, just beyond its range; a level and a batch that are not there.
/// One launch of every kind; of levels the first and the last. Each must be refused with an error
/// that names the launch, and the buffer.
std::vector<Failure> check_stage_refusals(const Capture& capture, const Backend& backend,
                                          std::string* said = nullptr);

/// Each ray of the contract's list of faults (pipeline_interface.h) as the last of `rays`, which
/// are sound: refused by its number.
std::vector<Failure> check_ray_refusals(const PipelineInput& input, const Backend& backend,
                                        std::span<const reference::Ray> rays,
                                        std::string* said = nullptr);

/// Two children of the root become one, in a copy of the tree: rays that enter both overflow its
/// queue, which must be an error that names the node, its room and what was pushed. Nothing where
/// no ray enters the root, or the tree has no queues of nodes below it.
std::vector<Failure> check_queue_refusal(const PipelineInput& input, const Backend& backend,
                                         std::span<const reference::Ray> rays,
                                         std::string* said = nullptr);

}  // namespace scotty::verify
