/// Properties that hold for random values (RapidCheck), as assertions of a Catch2 test.
/// RapidCheck's own header for Catch2 asks for version 2, which Debian 13 has not.
#pragma once

#include <rapidcheck.h>

#include <string>
#include <utility>

#include "tests/catch.h"

namespace scotty::tests {

/// `property` takes what RapidCheck makes, and RC_ASSERTs. A failure prints the smallest example.
template <class Property>
void check_property(const std::string& what, Property&& property) {
    INFO(what);
    CHECK(rc::check(what, std::forward<Property>(property)));
}

}  // namespace scotty::tests
