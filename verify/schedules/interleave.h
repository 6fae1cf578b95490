/// A captured stage under other orders of its blocks' accesses: `scotty replay --interleave`.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "emulation/simt/interleave/explorer.h"
#include "verify/capture/capture.h"

namespace scotty::verify {

struct InterleaveReport {
    std::string stage;
    std::uint32_t blocks = 0;
    emulation::simt::ExploreOptions options;
    emulation::simt::Exploration exploration;
    std::string saved;   ///< the file of the failing schedule
    std::string replay;  ///< command that runs it

    bool passed() const { return exploration.complete && !exploration.failing; }
};

/// Compares every order of one stage (or those within the bound) with one block after the other, in
/// canonical form. A failing order is shrunk and saved to `save`. Throws as replay_stage() does.
InterleaveReport interleave_stage(const Capture& capture, const std::string& stage,
                                  const emulation::simt::ExploreOptions& options,
                                  const std::filesystem::path& save);

/// One saved order: whether its outcome equals that of one block after the other.
struct InterleavedReplay {
    std::string stage;
    emulation::simt::Interleaving interleaving;
    bool same = false;
    std::string error;  ///< what the launch threw
};
InterleavedReplay replay_interleaved(const Capture& capture, const std::string& stage,
                                     const std::filesystem::path& file);

std::string to_text(const InterleaveReport& report);
nlohmann::json to_json(const InterleaveReport& report);
std::string to_text(const InterleavedReplay& replay);
nlohmann::json to_json(const InterleavedReplay& replay);

}  // namespace scotty::verify
