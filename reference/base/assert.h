/// Contracts between parts of the suite: SCOTTY_ASSERT(count, <=, capacity) prints both values.
///
/// Always on, in release builds too: it stands outside inner loops. A violation is an internal
/// error (exit code 70), thrown so that tests can see it.
#pragma once

#include <sstream>

#include "reference/base/error.h"

#define SCOTTY_ASSERT(left, comparison, right)                                         \
    do {                                                                               \
        const auto& scotty_left = (left);                                              \
        const auto& scotty_right = (right);                                            \
        if (!(scotty_left comparison scotty_right)) {                                  \
            std::ostringstream scotty_text;                                            \
            scotty_text << __FILE__ << ":" << __LINE__                                 \
                        << ": broken contract: " #left " " #comparison " " #right " (" \
                        << scotty_left << " vs " << scotty_right << ")";               \
            throw ::scotty::reference::Error::internal(scotty_text.str());             \
        }                                                                              \
    } while (false)
