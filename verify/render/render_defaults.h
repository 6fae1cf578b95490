/// The parameters that a picture is rendered with where nobody asks for others: the fastest of each
/// back end. `scotty verify` has its own, which reach as much of the code as they can.
#pragma once

#include <array>
#include <functional>
#include <string_view>

#include "reference/contract/pipeline_parameters.h"
#include "verify/backends/backend.h"

namespace scotty::verify {

/// The options whose defaults are the back end's.
inline constexpr std::array<std::string_view, 5> kBackendDefaults{
    "--width", "--queue-levels", "--early-out", "--hit-mode", "--batch-rays"};

/// Sets those parameters of which `is_given` is false, by the options' names ("--width"). None of
/// them changes a bit of the picture. docs/performance.md has what was measured.
void set_render_defaults(const Backend& backend, reference::PipelineParameters& parameters,
                         const std::function<bool(std::string_view option)>& is_given);

}  // namespace scotty::verify
