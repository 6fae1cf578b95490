/// A picture in the image viewer tev while it is rendered, through tev's network protocol.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "reference/contract/image.h"

namespace scotty::verify {

struct DisplayAddress {
    std::string host;  ///< a name or an address, IPv6 without its brackets
    std::string port;
};

/// "HOST:PORT", "HOST" (port 14158, tev's own), "[::1]:PORT". Throws bad_input naming what was
/// expected.
DisplayAddress parse_display(const std::string& text);
/// As parse_display() takes it, port included.
std::string to_string(const DisplayAddress& address);

/// A connection to one viewer, for one image.
///
/// The protocol is tev's src/Ipc.cpp (github.com/Tom94/tev): packets of a 32-bit length that counts
/// itself, a byte for the kind, and fields; numbers are little-endian, strings end in a zero.
/// Everything here throws missing_environment naming the address when there is no viewer, when it
/// is gone, or when it has taken nothing for as long as `patience`. No signal is raised.
class TevDisplay {
 public:
    /// Connects, and has the viewer make a black image of that name and put it in front. An image
    /// of the same name is replaced.
    TevDisplay(const DisplayAddress& address, std::string name, std::uint32_t width,
               std::uint32_t height,
               std::chrono::milliseconds patience = std::chrono::milliseconds(2000));

    /// Sends all pixels: linear radiance, of the size that was given.
    void update(const reference::Image& image);
    /// Waits until the viewer has taken everything. Nothing can be sent afterwards.
    void finish();

 private:
    struct Socket {
        int descriptor = -1;
        Socket() = default;
        ~Socket();
        Socket(const Socket&) = delete;
        Socket& operator=(const Socket&) = delete;
        void close();
    };
    void send_packet(std::string packet) const;
    void expect_listener() const;
    [[noreturn]] void fail(const std::string& what) const;

    std::string address_, name_;
    std::uint32_t width_, height_;
    Socket socket_;
};

}  // namespace scotty::verify
