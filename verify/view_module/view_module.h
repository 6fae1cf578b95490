/// What `scotty view` needs of libraries that nothing else needs: a web server (Boost.Beast), JPEG
/// (libjpeg-turbo) and PNG (libpng). No type of theirs is here: a module, loaded when a view is
/// started, so that no other command waits for them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace scotty::verify {

struct WebResponse {
    int status = 200;
    std::string type = "text/html; charset=utf-8";
    std::string body;
    std::string download;  ///< the name under which a browser saves it; empty: it shows it
};

using ViewerId = std::uint64_t;

/// A picture on its way to all viewers.
struct ViewFrame {
    std::uint64_t number = 0;  ///< counts frames, from 1
    std::uint64_t state = 0;   ///< of the session, that it shows
    std::string payload;
};

/// Who answers. Its functions are called by the server's threads, each viewer's in order, and throw
/// nothing.
class ViewHost {
 public:
    virtual ~ViewHost() = default;
    /// A GET behind the token: "" is the page, "camera" what the page saves, and so on. May take
    /// its time.
    virtual WebResponse get(const std::string& path) = 0;
    virtual void joined(ViewerId viewer) = 0;
    virtual void left(ViewerId viewer) = 0;
    /// A text message of at most kMostMessageBytes.
    virtual void received(ViewerId viewer, std::string_view text) = 0;
    /// What stands before a frame's payload for this viewer.
    virtual std::string frame_header(ViewerId viewer, const ViewFrame& frame) = 0;
};

inline constexpr std::size_t kMostMessageBytes = 16384;
inline constexpr std::size_t kMostHeaderBytes = 8192;
/// Messages that a viewer may send within a second, after which it is cut off.
inline constexpr unsigned kMostMessages = 1000;
inline constexpr std::size_t kMostConnections = 64;
/// Texts that wait for a viewer that does not read, after which it is cut off.
inline constexpr std::size_t kMostWaitingTexts = 256;
/// Frames that a viewer has been sent and has not acknowledged; then the newest waits.
inline constexpr unsigned kFramesUnderway = 2;

/// Listens from construction to destruction. All functions may be called by any thread.
class ViewServer {
 public:
    virtual ~ViewServer() = default;
    virtual std::uint16_t port() const = 0;
    virtual void send(ViewerId viewer, std::string text) = 0;
    /// To all viewers; one that another has overtaken before it was written is dropped.
    virtual void tell_newest(std::string text) = 0;
    /// To all viewers, each as soon as it has acknowledged an earlier one; a frame that a newer one
    /// has overtaken by then is dropped.
    virtual void offer(std::shared_ptr<const ViewFrame> frame) = 0;
    /// The viewer has shown a frame.
    virtual void acknowledged(ViewerId viewer) = 0;
};

struct ViewServerOptions {
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;  ///< 0: any that is free
    std::string token;       ///< the first part of every path
};

/// Pixels are 8-bit RGB, row-major.
class ViewModule {
 public:
    virtual ~ViewModule() = default;
    /// Returns null and says why in `error`.
    virtual std::unique_ptr<ViewServer> listen(const ViewServerOptions& options, ViewHost& host,
                                               std::string& error) const = 0;
    /// Empty where it fails. `quality` is 1 to 100.
    virtual std::string jpeg(const std::uint8_t* rgb, int width, int height, int quality) const = 0;
    virtual std::string png(const std::uint8_t* rgb, int width, int height) const = 0;
    /// What the server does with a request that consists of these bytes, as a status code, and, for
    /// a fuzzer, with messages of a viewer, without a socket.
    virtual int judge_request(std::string_view bytes, const ViewServerOptions& options) const = 0;
};

/// The name of the module's one function, of type ViewModuleEntry. It changes with the interface.
inline constexpr const char* kViewModuleEntry = "scotty_view_module_1";
using ViewModuleEntry = const ViewModule* (*)();

}  // namespace scotty::verify
