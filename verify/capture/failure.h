/// What a check has to say when it fails: where, what was expected, what was found.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reference/contract/invariant_names.h"
#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"

namespace scotty::verify {

namespace invariant = reference::invariant;

/// One violation. Numbers that do not apply are kNotApplicable, words that do not are empty.
struct Failure {
    std::string invariant;
    std::string stage;
    std::uint32_t launch = reference::kNotApplicable;
    std::uint32_t level = reference::kNotApplicable;
    std::uint32_t node = reference::kNotApplicable;    ///< breadth-first node id
    std::uint32_t block = reference::kNotApplicable;   ///< logical block of the launch
    std::uint32_t thread = reference::kNotApplicable;  ///< of the block
    std::uint32_t ray = reference::kNotApplicable;
    std::string field;
    std::string expected;  ///< floats as hex and decimal
    std::string found;
    std::string sentence;
    const void* shown_at = nullptr;  ///< where the value found lies, while its stage is shown
    std::string
        written_by;  ///< "thread 3 of block 7 of kernel K at FILE:LINE", where that is known
};

/// "launch 12 bounce1/level3/intersect, node 40, block 7, ray 1234: sentence (field: expected ..,
/// found ..)" on one line.
std::string to_string(const Failure& failure);

/// A float exactly and legibly: "0x1.8p+1 (3)".
std::string exact(float value);
std::string exact(const reference::Vec3& value);
std::string exact(const reference::Hit& hit);
std::string exact(const reference::Ray& ray);

/// `pattern` with * and ? against the whole name; without them a part of the name will do.
/// An empty pattern matches everything.
bool stage_matches(const std::string& pattern, const std::string& name);

}  // namespace scotty::verify
