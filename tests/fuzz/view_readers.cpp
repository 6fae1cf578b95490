/// What strangers can send to a view: requests, WebSocket frames, messages.
#include <boost/beast/_experimental/test/stream.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "reference/base/error.h"
#include "tests/fuzz/readers.h"
#include "verify/view/messages.h"
#include "verify/view_module/server.h"
#include "verify/view_module/socket_limits.h"

namespace scotty::tests {
namespace {

namespace beast = boost::beast;
namespace fs = std::filesystem;

[[noreturn]] void refuse(const char* what) { throw reference::Error::bad_input(what, "refused"); }

void read_request(const fs::path& /*folder*/, std::string_view bytes) {
    const verify::ViewServerOptions options{"127.0.0.1", 0, "token"};
    if (verify::judge_request_bytes(bytes, options) != 200) refuse("request");
}

void read_message(const fs::path& /*folder*/, std::string_view bytes) {
    const verify::ViewMessage message = verify::parse_message(bytes);
    if (const auto* look = std::get_if<verify::LookAt>(&message.what)) verify::camera_of(*look);
}

/// The bytes are what a client sends behind its handshake.
void read_socket(const fs::path& folder, std::string_view bytes) {
    boost::asio::io_context context;
    beast::test::stream near(context);
    beast::test::stream far(context);
    near.connect(far);
    near.append({bytes.data(), bytes.size()});
    far.close();
    beast::websocket::stream<beast::test::stream> socket(std::move(near));
    verify::set_socket_limits(socket);
    beast::http::request<beast::http::empty_body> request{beast::http::verb::get, "/", 11};
    request.set(beast::http::field::host, "localhost");
    request.set(beast::http::field::upgrade, "websocket");
    request.set(beast::http::field::connection, "upgrade");
    request.set(beast::http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    request.set(beast::http::field::sec_websocket_version, "13");
    beast::error_code error;
    socket.accept(request, error);
    bool accepted = false;
    while (!error) {
        beast::flat_buffer buffer;
        socket.read(buffer, error);
        if (error) break;
        const auto data = buffer.cdata();
        try {
            read_message(folder, {static_cast<const char*>(data.data()), data.size()});
            accepted = true;
        } catch (const reference::Error& refused) {
            if (refused.kind() != reference::ErrorKind::bad_input) throw;
        }
    }
    if (!accepted) refuse("socket");
}

}  // namespace

const std::vector<Reader>& view_readers() {
    static const std::vector<Reader> readers{{"view_request", read_request},
                                             {"view_message", read_message},
                                             {"view_socket", read_socket}};
    return readers;
}

}  // namespace scotty::tests
