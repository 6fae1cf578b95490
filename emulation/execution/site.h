/// A place where a thread waits or left: one constant for each place in a kernel's text.
///
/// Places are compared by address. Each word of the dialect makes one, so that two words in a line
/// are two places.
#pragma once

#include <cstdint>

namespace scotty::emulation::simt {

/// This file's path as the compiler sees it: the beginning shared by all such paths.
inline constexpr const char* kSiteHeader = __FILE__;

enum class SiteKind : std::uint8_t { barrier, collective, exit };

struct Site {
    const char* file;
    std::uint32_t line;
    SiteKind kind;
};

/// The mark of a thread that has left its kernel.
inline constexpr Site kLeft{"", 0, SiteKind::exit};

}  // namespace scotty::emulation::simt

/// The Site of this place. The lambda has no captures, because g++ 12 destroys captures inside an
/// await expression twice.
#define SCOTTY_SITE(kind)                                                   \
    ([]() -> const ::scotty::emulation::simt::Site& {                       \
        static constexpr ::scotty::emulation::simt::Site site{              \
            __FILE__, __LINE__, ::scotty::emulation::simt::SiteKind::kind}; \
        return site;                                                        \
    }())
