/// Names of the invariants, as reports, tests and the table of stages call them.
#pragma once

namespace scotty::reference::invariant {

inline constexpr const char* kNonFinite = "non-finite";
inline constexpr const char* kHandOver = "hand-over";  ///< a stage reads what the one before wrote
inline constexpr const char* kScan = "scan";
inline constexpr const char* kSlotWrittenOnce = "slot-written-once";
inline constexpr const char* kNoDuplicate = "no-duplicate";
inline constexpr const char* kNothingExtra = "nothing-extra";
inline constexpr const char* kRequiredPresent = "required-present";
inline constexpr const char* kInputOrder = "input-order";
inline constexpr const char* kCountEqualsPushes = "count-equals-pushes";
inline constexpr const char* kConservation = "conservation";
inline constexpr const char* kLeafHits = "leaf-hits";
inline constexpr const char* kMinimum = "minimum";
inline constexpr const char* kMerge = "merge";
inline constexpr const char* kResolveLight = "resolve-light";
inline constexpr const char* kRayRecord = "ray-record";
inline constexpr const char* kPathState = "path-state";
inline constexpr const char* kPixels = "pixels";
inline constexpr const char* kShading = "shading";
inline constexpr const char* kFilter = "filter";
inline constexpr const char* kUnwatched = "same-unwatched";  ///< a render that nobody watches

}  // namespace scotty::reference::invariant
