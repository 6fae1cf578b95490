/// The one file that includes Boost.Beast.
#include "verify/view_module/server.h"

#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <thread>
#include <utility>

#include "verify/view_module/request_rules.h"
#include "verify/view_module/socket_limits.h"

namespace scotty::verify {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

/// A client has so long for a request, and to take an answer.
constexpr std::chrono::seconds kPatience{20};
/// A kernel buffer holds no more of a viewer's frames than about this.
constexpr int kSendBuffer = 1 << 18;

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

RequestHead head_of(const Request& request) {
    RequestHead head;
    head.method = view_of(request.method_string());
    head.target = view_of(request.target());
    if (const auto host = request.find(http::field::host); host != request.end()) {
        head.host = view_of(host->value());
    }
    if (const auto origin = request.find(http::field::origin); origin != request.end()) {
        head.origin = view_of(origin->value());
    }
    const auto length = request.find(http::field::content_length);
    head.has_body = request.chunked() || (length != request.end() && length->value() != "0");
    // Two hosts would be two answers to the question which of them is allowed.
    if (request.count(http::field::host) != 1) head.host.reset();
    return head;
}

using Parser = http::request_parser<http::empty_body>;
void set_limits(Parser& parser) {
    parser.header_limit(kMostHeaderBytes);
    parser.body_limit(0);
}

Response answer_to(const WebResponse& from, unsigned version, bool keep_alive) {
    Response out{static_cast<http::status>(from.status), version};
    out.set(http::field::content_type, from.type);
    out.set(http::field::cache_control, "no-store");
    out.set("X-Content-Type-Options", "nosniff");
    out.set("Referrer-Policy", "no-referrer");
    out.set("Cross-Origin-Resource-Policy", "same-origin");
    out.set("X-Frame-Options", "SAMEORIGIN");
    if (!from.download.empty()) {
        out.set(http::field::content_disposition, "attachment; filename=\"" + from.download + "\"");
    }
    out.body() = from.body;
    out.keep_alive(keep_alive);
    out.prepare_payload();
    return out;
}

class Server;

/// One viewer, from its handshake on. All of it runs in the server's thread.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
    Viewer(Server& server, beast::tcp_stream&& stream, ViewerId id)
        : server_(server), socket_(std::move(stream)), id_(id) {}

    void start(const Request& request);
    void send(std::string text) {
        if (closing_) return;
        if (texts_.size() >= kMostWaitingTexts) return cut_off();
        texts_.push_back(std::move(text));
        write();
    }
    void tell_newest(std::shared_ptr<const std::string> text) {
        newest_text_ = std::move(text);
        write();
    }
    void offer(std::shared_ptr<const ViewFrame> frame) {
        newest_ = std::move(frame);
        write();
    }
    void acknowledge() {
        if (underway_ > 0) --underway_;
        write();
    }
    void cut_off() {
        closing_ = true;
        beast::get_lowest_layer(socket_).close();
    }

 private:
    void read();
    void take();
    void write();
    void leave();

    Server& server_;
    websocket::stream<beast::tcp_stream> socket_;
    ViewerId id_;
    beast::flat_buffer buffer_;
    std::deque<std::string> texts_;
    std::shared_ptr<const std::string> newest_text_;
    std::shared_ptr<const ViewFrame> newest_, writing_frame_;
    std::string writing_;
    unsigned underway_ = 0;
    bool open_ = false, busy_ = false, closing_ = false;
    Clock::time_point second_{};
    unsigned messages_ = 0;  ///< of that second
};

/// A connection until it is a viewer's.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
    Connection(Server& server, tcp::socket&& socket);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;
    void read();
    void cut_off() {
        if (!handed_on_) stream_.close();
    }

 private:
    void take();
    void answer(const WebResponse& response, bool keep);

    Server& server_;
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_{kMostHeaderBytes};
    std::optional<Parser> parser_;
    Response response_;
    bool handed_on_ = false;
};

class Server final : public ViewServer {
 public:
    Server(ViewServerOptions options, ViewHost& host)
        : options_(std::move(options)), host_(host), acceptor_(context_) {
        const tcp::endpoint endpoint(asio::ip::make_address(options_.address), options_.port);
        acceptor_.open(endpoint.protocol());
        acceptor_.set_option(asio::socket_base::reuse_address(true));
        acceptor_.bind(endpoint);
        acceptor_.listen();
        port_ = acceptor_.local_endpoint().port();
        accept();
        thread_ = std::thread([this] { context_.run(); });
    }
    ~Server() override {
        asio::post(context_, [this] {
            beast::error_code ignored;
            acceptor_.close(ignored);
            closing_ = true;
            for (const auto& [id, viewer] : viewers_) viewer->cut_off();
            context_.stop();
        });
        thread_.join();
        answers_.join();
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::uint16_t port() const override { return port_; }
    void send(ViewerId id, std::string text) override {
        asio::post(context_, [this, id, text = std::move(text)]() mutable {
            const auto found = viewers_.find(id);
            if (found != viewers_.end()) found->second->send(std::move(text));
        });
    }
    void tell_newest(std::string text) override {
        asio::post(context_, [this, told = std::make_shared<const std::string>(std::move(text))] {
            for (const auto& [id, viewer] : viewers_) viewer->tell_newest(told);
        });
    }
    void offer(std::shared_ptr<const ViewFrame> frame) override {
        asio::post(context_, [this, frame = std::move(frame)] {
            newest_ = frame;
            for (const auto& [id, viewer] : viewers_) viewer->offer(frame);
        });
    }
    void acknowledged(ViewerId id) override {
        asio::post(context_, [this, id] {
            const auto found = viewers_.find(id);
            if (found != viewers_.end()) found->second->acknowledge();
        });
    }

    const ViewServerOptions& options() const { return options_; }
    ViewHost& host() { return host_; }
    asio::thread_pool& answers() { return answers_; }
    std::size_t connections = 0;

    void upgrade(beast::tcp_stream&& stream, const Request& request) {
        const ViewerId id = ++last_id_;
        std::make_shared<Viewer>(*this, std::move(stream), id)->start(request);
    }
    void joined(ViewerId id, const std::shared_ptr<Viewer>& viewer) {
        viewers_[id] = viewer;
        host_.joined(id);
        if (newest_) viewer->offer(newest_);
    }
    void left(ViewerId id) {
        if (viewers_.erase(id) != 0) host_.left(id);
    }

 private:
    void accept() {
        acceptor_.async_accept([this](beast::error_code error, tcp::socket socket) {
            if (!acceptor_.is_open()) return;
            if (!error && connections + viewers_.size() < kMostConnections) {
                beast::error_code ignored;
                socket.set_option(tcp::no_delay(true), ignored);
                socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
                std::make_shared<Connection>(*this, std::move(socket))->read();
            }
            if (!error) return accept();
            // Out of file descriptors, say: not at once again.
            retry_.expires_after(std::chrono::milliseconds(100));
            retry_.async_wait([this](beast::error_code stopped) {
                if (!stopped) accept();
            });
        });
    }

    ViewServerOptions options_;
    ViewHost& host_;
    asio::io_context context_{1};
    asio::steady_timer retry_{context_};
    asio::thread_pool answers_{1};
    tcp::acceptor acceptor_;
    std::uint16_t port_ = 0;
    std::map<ViewerId, std::shared_ptr<Viewer>> viewers_;
    std::shared_ptr<const ViewFrame> newest_;
    ViewerId last_id_ = 0;
    bool closing_ = false;
    std::thread thread_;
};

Connection::Connection(Server& server, tcp::socket&& socket)
    : server_(server), stream_(std::move(socket)) {
    ++server_.connections;
}
Connection::~Connection() { --server_.connections; }

void Connection::read() {
    parser_.emplace();
    set_limits(*parser_);
    stream_.expires_after(kPatience);
    http::async_read_header(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t) {
            if (!error) return self->take();
            if (error == http::error::header_limit) {
                self->answer({431, "text/plain", "the header is too long\n", {}}, false);
            } else if (error.category() == beast::error_code(http::error::bad_method).category() &&
                       error != http::error::end_of_stream) {
                self->answer({400, "text/plain", "this is no request\n", {}}, false);
            }
        });
}

void Connection::take() {
    const Request& request = parser_->get();
    const RequestVerdict verdict = judge(head_of(request), server_.options());
    if (verdict.status != 200) {
        return answer({verdict.status, "text/plain", verdict.reason + "\n", {}}, false);
    }
    if (websocket::is_upgrade(request)) {
        if (verdict.path != "socket") {
            return answer({404, "text/plain", "the socket is elsewhere\n", {}}, false);
        }
        handed_on_ = true;
        stream_.expires_never();
        return server_.upgrade(std::move(stream_), request);
    }
    // What takes its time does not hold up the frames.
    const bool keep = request.keep_alive();
    asio::post(server_.answers(), [self = shared_from_this(), path = verdict.path, keep] {
        asio::post(self->stream_.get_executor(),
                   [self, keep, response = self->server_.host().get(path)] {
                       self->answer(response, keep);
                   });
    });
}

void Connection::answer(const WebResponse& response, bool keep) {
    response_ = answer_to(response, 11, keep);
    stream_.expires_after(kPatience);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                          if (error) return;
                          if (self->response_.keep_alive()) return self->read();
                          beast::error_code ignored;
                          self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                      });
}

void Viewer::start(const Request& request) {
    set_socket_limits(socket_);
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
        if (error) return;
        self->open_ = true;
        self->server_.joined(self->id_, self);
        self->read();
    });
}

void Viewer::leave() {
    closing_ = true;
    server_.left(id_);
}

void Viewer::read() {
    socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
        if (error) return self->leave();
        self->take();
    });
}

void Viewer::take() {
    const auto now = Clock::now();
    if (now - second_ > std::chrono::seconds(1)) {
        second_ = now;
        messages_ = 0;
    }
    if (++messages_ > kMostMessages || !socket_.got_text()) {
        cut_off();
        return leave();
    }
    const auto data = buffer_.cdata();
    server_.host().received(id_, {static_cast<const char*>(data.data()), data.size()});
    buffer_.consume(buffer_.size());
    read();
}

void Viewer::write() {
    if (busy_ || closing_ || !open_) return;
    const auto written = [self = shared_from_this()](beast::error_code error, std::size_t) {
        self->busy_ = false;
        self->writing_frame_.reset();
        if (error) return self->cut_off();
        self->write();
    };
    if (!texts_.empty()) {
        busy_ = true;
        writing_ = std::move(texts_.front());
        texts_.pop_front();
        socket_.text(true);
        return socket_.async_write(asio::buffer(writing_), written);
    }
    if (newest_text_) {
        busy_ = true;
        writing_ = *std::exchange(newest_text_, nullptr);
        socket_.text(true);
        return socket_.async_write(asio::buffer(writing_), written);
    }
    if (!newest_ || underway_ >= kFramesUnderway) return;
    busy_ = true;
    ++underway_;
    writing_frame_ = std::exchange(newest_, nullptr);
    writing_ = server_.host().frame_header(id_, *writing_frame_);
    socket_.binary(true);
    socket_.async_write(std::array<asio::const_buffer, 2>{asio::buffer(writing_),
                                                          asio::buffer(writing_frame_->payload)},
                        written);
}

}  // namespace

std::unique_ptr<ViewServer> make_server(const ViewServerOptions& options, ViewHost& host,
                                        std::string& error) {
    try {
        return std::make_unique<Server>(options, host);
    } catch (const std::exception& caught) {  // Boost's errors
        error = caught.what();
        return nullptr;
    }
}

int judge_request_bytes(std::string_view bytes, const ViewServerOptions& options) {
    Parser parser;
    set_limits(parser);
    beast::error_code error;
    while (!bytes.empty() && !parser.is_header_done()) {
        const std::size_t used = parser.put(asio::buffer(bytes.data(), bytes.size()), error);
        if (error == http::error::need_more) return 0;
        if (error == http::error::header_limit) return 431;
        if (error) return 400;
        bytes.remove_prefix(used);
    }
    if (!parser.is_header_done()) return 0;
    return judge(head_of(parser.get()), options).status;
}

}  // namespace scotty::verify
