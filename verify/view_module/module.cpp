/// The module: server and codecs behind the interface.
#include "verify/view_module/encode.h"
#include "verify/view_module/server.h"
#include "verify/view_module/view_module.h"

namespace scotty::verify {
namespace {

class Module final : public ViewModule {
 public:
    std::unique_ptr<ViewServer> listen(const ViewServerOptions& options, ViewHost& host,
                                       std::string& error) const override {
        return make_server(options, host, error);
    }
    std::string jpeg(const std::uint8_t* rgb, int width, int height, int quality) const override {
        return encode_jpeg(rgb, width, height, quality);
    }
    std::string png(const std::uint8_t* rgb, int width, int height) const override {
        return encode_png(rgb, width, height);
    }
    int judge_request(std::string_view bytes, const ViewServerOptions& options) const override {
        return judge_request_bytes(bytes, options);
    }
};

}  // namespace
}  // namespace scotty::verify

/// kViewModuleEntry.
extern "C" __attribute__((visibility("default"))) const scotty::verify::ViewModule*
scotty_view_module_1() {
    static const scotty::verify::Module module;
    return &module;
}
