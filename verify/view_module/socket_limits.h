/// What a viewer's socket may do; the fuzzer's has the same limits.
#pragma once

#include <boost/beast/websocket.hpp>
#include <chrono>

#include "verify/view_module/view_module.h"

namespace scotty::verify {

template <class Stream>
void set_socket_limits(boost::beast::websocket::stream<Stream>& socket) {
    auto timeouts =
        boost::beast::websocket::stream_base::timeout::suggested(boost::beast::role_type::server);
    timeouts.idle_timeout = std::chrono::seconds(60);
    timeouts.keep_alive_pings = true;
    socket.set_option(timeouts);
    socket.read_message_max(kMostMessageBytes);
    socket.auto_fragment(false);
    socket.write_buffer_bytes(1 << 16);
}

}  // namespace scotty::verify
