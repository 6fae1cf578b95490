#include "emulation/simt/interleave/replayer.h"

#include <algorithm>

#include "reference/base/error.h"

namespace scotty::emulation::simt {

void Replayer::begin(const Launch& launch) {
    const Interleaving& i = interleaving_;
    if (i.kernel == launch.kernel && i.blocks == launch.blocks && i.threads == launch.threads)
        return;
    const auto name = [](const std::string& kernel, std::uint32_t blocks, std::uint32_t threads) {
        return "kernel " + kernel + " in " + std::to_string(blocks) + " blocks of " +
               std::to_string(threads) + " threads";
    };
    throw reference::Error::bad_input(
        "--schedule", "expected a launch of " + name(i.kernel, i.blocks, i.threads) + ", found " +
                          name(launch.kernel, launch.blocks, launch.threads));
}

const Switch* Replayer::find(std::uint32_t block, std::uint32_t access) const {
    const auto found = std::find_if(
        interleaving_.switches.begin(), interleaving_.switches.end(),
        [&](const Switch& change) { return change.block == block && change.access == access; });
    return found == interleaving_.switches.end() ? nullptr : &*found;
}

bool Replayer::stops(std::uint32_t block, std::uint32_t access, const Touch&) {
    return find(block, access) != nullptr;
}

std::uint32_t Replayer::choose(const std::vector<BlockState>& blocks, std::uint32_t current) {
    const Switch* change = find(current, blocks[current].over ? 0 : blocks[current].accesses);
    if (change != nullptr && blocks[change->to].can_run()) return change->to;
    return next_by_default(blocks, current);
}

std::string outcome_of(const InterleavedRun& run, Interleaver& interleaver) {
    try {
        return run(interleaver);
    } catch (const reference::Error& error) {
        if (error.kind() != reference::ErrorKind::internal) throw;
        return std::string("error: ") + error.what();
    }
}

std::string replay(const MemoryChecker& memory, const InterleavedRun& run,
                   const Interleaving& interleaving) {
    Interleaver interleaver(memory);
    Replayer replayer(interleaving);
    interleaver.use(replayer);
    return outcome_of(run, interleaver);
}

}  // namespace scotty::emulation::simt
