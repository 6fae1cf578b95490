/// The web server: HTTP for the page and what it saves, WebSocket for frames and messages.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "verify/view_module/view_module.h"

namespace scotty::verify {

std::unique_ptr<ViewServer> make_server(const ViewServerOptions& options, ViewHost& host,
                                        std::string& error);
int judge_request_bytes(std::string_view bytes, const ViewServerOptions& options);

}  // namespace scotty::verify
