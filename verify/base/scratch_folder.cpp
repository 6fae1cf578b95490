#include "verify/base/scratch_folder.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <mutex>
#include <string>
#include <system_error>

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kSlots = 64;

/// What a signal handler may read: no std::string, no lock.
struct Slot {
    enum State { free, being_named, used };
    std::atomic<int> state{free};
    char path[512] = {};
};
std::array<Slot, kSlots>& slots() {
    static std::array<Slot, kSlots> all;
    return all;
}

/// Calls only what POSIX lets a handler call.
extern "C" void remove_scratch_folders(int signal) {
    for (Slot& slot : slots()) {
        if (slot.state.load() != Slot::used) continue;
        const pid_t child = fork();
        if (child == 0) {
            execl("/bin/rm", "rm", "-rf", "--", slot.path, static_cast<char*>(nullptr));
            _exit(1);
        }
        if (child > 0) waitpid(child, nullptr, 0);
    }
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

}  // namespace

void remove_scratch_folders_on_signals() {
    slots();  // made before a handler asks
    for (const int each : {SIGINT, SIGTERM}) {
        struct sigaction now {};
        sigaction(each, nullptr, &now);
        if (now.sa_handler != SIG_DFL) continue;
        struct sigaction removing {};
        removing.sa_handler = remove_scratch_folders;
        sigaction(each, &removing, nullptr);
    }
}

ScratchFolder::ScratchFolder() {
    static std::atomic<int> made{0};
    path_ = fs::temp_directory_path() / fmt::format("scotty-{}-{}", getpid(), made++);
    remove_scratch_folders_on_signals();
    const std::string text = path_.string();
    for (std::size_t i = 0; i < kSlots && text.size() < sizeof Slot::path; ++i) {
        Slot& slot = slots()[i];
        int expected = Slot::free;
        if (!slot.state.compare_exchange_strong(expected, Slot::being_named)) continue;
        std::memcpy(slot.path, text.c_str(), text.size() + 1);
        slot.state.store(Slot::used);
        slot_ = static_cast<int>(i);
        break;
    }
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    if (slot_ >= 0) slots()[static_cast<std::size_t>(slot_)].state.store(Slot::free);
}

}  // namespace scotty::verify
