#include "emulation/execution/launch_error.h"

#include <string_view>

namespace scotty::emulation::simt {

namespace {

/// Makes a path relative to the root of the sources, as far as site.h's own path tells the root.
std::string_view from_root(std::string_view file) {
    constexpr std::string_view kHere = kSiteHeader;
    constexpr std::string_view kFromRoot = "emulation/execution/site.h";
    constexpr std::string_view kRoot = kHere.substr(0, kHere.size() - kFromRoot.size());
    return file.substr(0, kRoot.size()) == kRoot ? file.substr(kRoot.size()) : file;
}

}  // namespace

std::string thread_list(const std::vector<std::uint32_t>& threads) {
    std::string text;
    for (std::size_t i = 0; i < threads.size();) {
        std::size_t last = i;
        while (last + 1 < threads.size() && threads[last + 1] == threads[last] + 1) ++last;
        if (!text.empty()) text += ", ";
        text += std::to_string(threads[i]);
        if (last > i) text += (last > i + 1 ? "-" : ", ") + std::to_string(threads[last]);
        i = last + 1;
    }
    return text;
}

std::string to_text(const ThreadGroup& group) {
    const bool one = group.threads.size() == 1;
    const std::string who = (one ? "thread " : "threads ") + thread_list(group.threads);
    const auto place = [](const Site& site) {
        return std::string(from_root(site.file)) + ":" + std::to_string(site.line);
    };
    switch (group.stop->kind) {
        case SiteKind::barrier:
            return who + (one ? " waits" : " wait") + " at the barrier " + place(*group.stop);
        case SiteKind::collective:
            return who + (one ? " waits" : " wait") + " at the warp collective " +
                   place(*group.stop);
        default:
            break;
    }
    return who + (one ? " has" : " have") + " left the kernel at " +
           (group.left_at == nullptr ? "its end" : place(*group.left_at));
}

}  // namespace scotty::emulation::simt
