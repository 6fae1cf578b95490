#include "verify/view/view_library.h"

#include "verify/base/loaded_module.h"

namespace scotty::verify {

const ViewModule& view_module() {
    static const ViewModule& module = *reinterpret_cast<ViewModuleEntry>(
        module_entry({"scotty-view.so", "SCOTTY_VIEW_MODULE", kViewModuleEntry,
                      "a view needs a web server, libjpeg-turbo and libpng, and its module"}))();
    return module;
}

}  // namespace scotty::verify
