/// Loads the module with the web server, when a view is started.
#pragma once

#include "verify/view_module/view_module.h"

namespace scotty::verify {

/// lib/cuda-scotty/scotty-view.so, or what SCOTTY_VIEW_MODULE names. Throws missing_environment
/// that says which file or library is missing.
const ViewModule& view_module();

}  // namespace scotty::verify
