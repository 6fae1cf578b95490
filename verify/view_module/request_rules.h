/// Which requests are answered at all. No Beast in here: strings and rules.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "verify/view_module/view_module.h"

namespace scotty::verify {

/// "127.0.0.1", "localhost" and "[::1]", with any port: ssh forwards to others. Where the server
/// listens beyond loopback, numeric addresses as well. A name that somebody else's DNS answers is
/// never allowed.
bool is_allowed_host(std::string_view host, bool beyond_loopback);
/// The origin of a page of ours: "http://" and an allowed host.
bool is_allowed_origin(std::string_view origin, bool beyond_loopback);
bool is_loopback(std::string_view address);

/// In a time that does not tell how much of it is right.
bool is_token(std::string_view given, std::string_view token);

struct RequestHead {
    std::string_view method, target;
    std::optional<std::string_view> host, origin;
    bool has_body = false;
};

struct RequestVerdict {
    int status = 200;    ///< 200, or what it is refused with
    std::string path;    ///< behind the token, without a query
    std::string reason;  ///< one sentence, for the client
};
RequestVerdict judge(const RequestHead& head, const ViewServerOptions& options);

}  // namespace scotty::verify
