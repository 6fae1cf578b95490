#include "verify/render/tev_display.h"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>

#include "reference/base/assert.h"
#include "reference/base/error.h"

namespace scotty::verify {

using reference::Error;

namespace {

constexpr const char* kTevPort = "14158";
constexpr const char* kTakesNothing = "it does not take what it is sent";

/// Kinds of packets; those of tev that are used here.
enum class TevPacket : std::uint8_t { create_image = 4, update_image_v3 = 6 };

/// So many pixels at most in a packet: an update of a large image is several of them.
constexpr std::uint32_t kPixelsOfPacket = 1u << 20;

constexpr std::string_view kChannels[3] = {"R", "G", "B"};

template <class T>
void put(std::string& packet, T value) {
    static_assert(std::is_arithmetic_v<T> && std::endian::native == std::endian::little);
    packet.append(reinterpret_cast<const char*>(&value), sizeof(value));
}
void put_text(std::string& packet, std::string_view text) {
    packet += text;
    packet += '\0';
}

/// Length (to be filled in), kind, whether to put the image in front, and its name.
std::string begin_packet(TevPacket kind, bool in_front, const std::string& name) {
    std::string packet(sizeof(std::uint32_t), '\0');
    put(packet, static_cast<std::uint8_t>(kind));
    put(packet, static_cast<std::uint8_t>(in_front ? 1 : 0));
    put_text(packet, name);
    return packet;
}

bool took_too_long(int error) { return error == EAGAIN || error == EINPROGRESS; }

}  // namespace

DisplayAddress parse_display(const std::string& text) {
    const auto refuse = [&](const char* why) {
        return Error::bad_input("--display",
                                fmt::format("expected HOST:PORT such as localhost:{} or [::1]:{}, "
                                            "found '{}': {}",
                                            kTevPort, kTevPort, text, why));
    };
    DisplayAddress address{text, kTevPort};
    std::string rest;
    if (text.starts_with('[')) {
        const std::size_t end = text.find(']');
        if (end == std::string::npos) throw refuse("the bracket is not closed");
        address.host = text.substr(1, end - 1);
        rest = text.substr(end + 1);
        if (!rest.empty() && rest[0] != ':') throw refuse("a colon follows the bracket");
    } else if (const std::size_t colon = text.find(':'); colon != std::string::npos) {
        address.host = text.substr(0, colon);
        rest = text.substr(colon);
        if (rest.find(':', 1) != std::string::npos) {
            throw refuse("an IPv6 address stands in brackets");
        }
    }
    if (address.host.empty()) throw refuse("there is no host");
    if (rest.empty()) return address;
    address.port = rest.substr(1);
    unsigned port = 0;
    const char* end = address.port.data() + address.port.size();
    const auto [stopped, error] = std::from_chars(address.port.data(), end, port);
    if (error != std::errc() || stopped != end || port < 1 || port > 65535) {
        throw refuse("a port is a number of 1..65535");
    }
    return address;
}

std::string to_string(const DisplayAddress& address) {
    const bool ipv6 = address.host.find(':') != std::string::npos;
    return (ipv6 ? "[" + address.host + "]:" : address.host + ":") + address.port;
}

TevDisplay::TevDisplay(const DisplayAddress& address, std::string name, std::uint32_t width,
                       std::uint32_t height, std::chrono::milliseconds patience)
    : address_(to_string(address)), name_(std::move(name)), width_(width), height_(height) {
    addrinfo wanted{};
    wanted.ai_socktype = SOCK_STREAM;
    addrinfo* list = nullptr;
    if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &wanted, &list)) {
        fail(fmt::format("{}; check the host's name", gai_strerror(error)));
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owned(list, freeaddrinfo);
    timeval limit{};
    limit.tv_sec = patience.count() / 1000;
    limit.tv_usec = patience.count() % 1000 * 1000;
    int error = 0;
    for (const addrinfo* to = list; to != nullptr; to = to->ai_next) {
        socket_.descriptor = socket(to->ai_family, to->ai_socktype | SOCK_CLOEXEC, to->ai_protocol);
        if (socket_.descriptor < 0) {
            error = errno;
            continue;
        }
        setsockopt(socket_.descriptor, SOL_SOCKET, SO_SNDTIMEO, &limit,
                   sizeof(limit));  // connect()'s too
        setsockopt(socket_.descriptor, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
        if (connect(socket_.descriptor, to->ai_addr, to->ai_addrlen) == 0) break;
        error = errno;
        socket_.close();
    }
    if (socket_.descriptor < 0) {
        fail(
            fmt::format("{}; start tev there first (its option --host says where it "
                        "listens), or see that the port is open",
                        took_too_long(error) ? "nobody answers" : std::strerror(error)));
    }
    std::string packet = begin_packet(TevPacket::create_image, true, name_);
    put(packet, static_cast<std::int32_t>(width_));
    put(packet, static_cast<std::int32_t>(height_));
    put(packet, std::int32_t{3});
    for (const std::string_view channel : kChannels) put_text(packet, channel);
    send_packet(std::move(packet));
}

TevDisplay::Socket::~Socket() { close(); }

void TevDisplay::Socket::close() {
    if (descriptor >= 0) ::close(descriptor);
    descriptor = -1;
}

void TevDisplay::update(const reference::Image& image) {
    SCOTTY_ASSERT(image.width, ==, width_);
    SCOTTY_ASSERT(image.height, ==, height_);
    static_assert(sizeof(reference::Vec3) == 3 * sizeof(float));
    const std::uint32_t rows_of_packet = std::max(1u, kPixelsOfPacket / width_);
    for (std::uint32_t y = 0; y < height_; y += rows_of_packet) {
        const std::uint32_t rows = std::min(rows_of_packet, height_ - y);
        std::string packet = begin_packet(TevPacket::update_image_v3, false, name_);
        put(packet, std::int32_t{3});
        for (const std::string_view channel : kChannels) put_text(packet, channel);
        put(packet, std::int32_t{0});
        put(packet, static_cast<std::int32_t>(y));
        put(packet, static_cast<std::int32_t>(width_));
        put(packet, static_cast<std::int32_t>(rows));
        for (std::int64_t offset = 0; offset < 3; ++offset) put(packet, offset);
        for (int channel = 0; channel < 3; ++channel) put(packet, std::int64_t{3});  // strides
        packet.append(reinterpret_cast<const char*>(&image.pixels[std::size_t{y} * width_]),
                      std::size_t{rows} * width_ * sizeof(reference::Vec3));
        send_packet(std::move(packet));
    }
}

void TevDisplay::finish() {
    expect_listener();
    shutdown(socket_.descriptor, SHUT_WR);
    char nothing = 0;
    for (;;) {
        const ssize_t got = recv(socket_.descriptor, &nothing, 1, 0);
        if (got < 0 && errno != EINTR) {
            fail(took_too_long(errno) ? kTakesNothing : std::strerror(errno));
        }
        if (got != 0) continue;
        int error = 0;  // it may have hung up before it had everything
        socklen_t size = sizeof(error);
        getsockopt(socket_.descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
        if (error != 0) fail(std::strerror(error));
        return;
    }
}

/// A viewer says nothing before it hangs up.
void TevDisplay::expect_listener() const {
    char nothing = 0;
    if (recv(socket_.descriptor, &nothing, 1, MSG_PEEK | MSG_DONTWAIT) == 0) fail("it has hung up");
}

void TevDisplay::send_packet(std::string packet) const {
    const auto length = static_cast<std::uint32_t>(packet.size());
    std::memcpy(packet.data(), &length, sizeof(length));
    expect_listener();
    for (std::string_view rest = packet; !rest.empty();) {
        const ssize_t sent = send(socket_.descriptor, rest.data(), rest.size(), MSG_NOSIGNAL);
        if (sent > 0) {
            rest.remove_prefix(static_cast<std::size_t>(sent));
        } else if (errno != EINTR) {
            fail(took_too_long(errno) ? kTakesNothing : std::strerror(errno));
        }
    }
}

void TevDisplay::fail(const std::string& what) const {
    throw Error::missing_environment(fmt::format("the display {}: {}", address_, what));
}

}  // namespace scotty::verify
