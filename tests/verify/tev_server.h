/// A stand-in for the viewer tev: takes one connection on the loopback and reads it by tev's
/// protocol, as strictly as can be.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/catch.h"

namespace scotty::verify::test {

/// What a viewer holds: interleaved by channel, row-major from the top left.
struct ShownImage {
    std::int32_t width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> values;
};

class TevServer {
 public:
    /// Called by the server's thread after a packet, with the number of packets so far. False:
    /// hang up, whatever is still on its way.
    using OnPacket = std::function<bool(std::size_t packets)>;

    explicit TevServer(
        OnPacket on_packet = [](std::size_t) { return true; }, int family = AF_INET)
        : on_packet_(std::move(on_packet)) {
        listening_ = socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_storage at{};  // the loopback, and a port of the system's choice
        at.ss_family = static_cast<sa_family_t>(family);
        if (family == AF_INET) {
            reinterpret_cast<sockaddr_in&>(at).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        } else {
            reinterpret_cast<sockaddr_in6&>(at).sin6_addr = in6addr_loopback;
        }
        auto* address = reinterpret_cast<sockaddr*>(&at);
        socklen_t size = family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
        if (listening_ < 0 || bind(listening_, address, size) != 0 || listen(listening_, 1) != 0 ||
            getsockname(listening_, address, &size) != 0) {
            return;  // port 0: there is no such family here
        }
        port_ = ntohs(reinterpret_cast<sockaddr_in&>(at).sin_port);
        thread_ = std::thread([this] { serve(); });
    }
    ~TevServer() { wait(); }
    TevServer(const TevServer&) = delete;
    TevServer& operator=(const TevServer&) = delete;

    std::uint16_t port() const { return port_; }
    std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

    /// Until the connection has ended; one that has not come by now never will.
    void wait() {
        if (listening_ >= 0) shutdown(listening_, SHUT_RDWR);
        if (thread_.joinable()) thread_.join();
        if (listening_ >= 0) close(listening_);
        listening_ = -1;
    }
    // After wait():
    const std::map<std::string, ShownImage>& images() const { return images_; }
    std::size_t packets() const { return packets_; }
    /// What was wrong with the stream; empty where it was well-formed and ended after a packet.
    const std::string& fault() const { return fault_; }

 private:
    /// The fields of one packet, in order.
    class Fields {
     public:
        explicit Fields(const std::vector<char>& packet) : packet_(packet) {}
        template <class T>
        T number() {
            T value;
            if (sizeof(T) > left()) throw std::runtime_error("a packet ends inside a number");
            std::memcpy(&value, packet_.data() + at_, sizeof(T));
            at_ += sizeof(T);
            return value;
        }
        std::string text() {
            const auto* end = static_cast<const char*>(std::memchr(&packet_[at_], 0, left()));
            if (end == nullptr) throw std::runtime_error("a packet ends inside a text");
            std::string text(&packet_[at_], end);
            at_ += text.size() + 1;
            return text;
        }
        std::size_t left() const { return packet_.size() - at_; }

     private:
        const std::vector<char>& packet_;
        std::size_t at_ = 0;
    };

    void serve() {
        const int connection = accept(listening_, nullptr, nullptr);
        if (connection < 0) return;
        try {
            std::uint32_t length = 0;
            while (read_all(connection, &length, sizeof(length), true)) {
                if (length < 5) throw std::runtime_error("a packet of no kind");
                std::vector<char> packet(length - sizeof(length));
                read_all(connection, packet.data(), packet.size(), false);
                take(Fields(packet));
                ++packets_;
                if (!on_packet_(packets_)) break;
            }
        } catch (const std::exception& error) {
            fault_ = error.what();
        }
        close(connection);
    }
    static bool read_all(int from, void* to, std::size_t bytes, bool may_end) {
        for (std::size_t got = 0; got < bytes;) {
            const ssize_t more = recv(from, static_cast<char*>(to) + got, bytes - got, 0);
            if (more == 0 && got == 0 && may_end) return false;
            if (more <= 0) throw std::runtime_error("the stream ends inside a packet");
            got += static_cast<std::size_t>(more);
        }
        return true;
    }
    static void expect(bool holds, const char* what) {
        if (!holds) throw std::runtime_error(what);
    }
    void take(Fields fields) {
        const auto kind = fields.number<std::uint8_t>();
        const auto in_front = fields.number<std::uint8_t>();
        expect(in_front <= 1, "a truth value that is neither 0 nor 1");
        const std::string name = fields.text();
        if (kind == 4) {
            create(name, fields);
        } else if (kind == 6) {
            update(name, fields);
        } else {
            throw std::runtime_error("a packet of kind " + std::to_string(kind));
        }
        expect(fields.left() == 0, "a packet has more than its fields");
    }
    void create(const std::string& name, Fields& fields) {
        ShownImage image;
        image.width = fields.number<std::int32_t>();
        image.height = fields.number<std::int32_t>();
        const auto channels = fields.number<std::int32_t>();
        for (std::int32_t i = 0; i < channels; ++i) image.channels.push_back(fields.text());
        expect(image.width > 0 && image.height > 0, "an image without pixels");
        image.values.assign(static_cast<std::size_t>(image.width) *
                                static_cast<std::size_t>(image.height) * image.channels.size(),
                            0.0f);
        images_[name] = image;
    }
    void update(const std::string& name, Fields& fields) {
        expect(images_.count(name) == 1, "an update of an image that was not created");
        ShownImage& image = images_.at(name);
        const auto channels = fields.number<std::int32_t>();
        expect(channels == static_cast<std::int32_t>(image.channels.size()), "other channels");
        for (const std::string& channel : image.channels) {
            expect(fields.text() == channel, "a channel of another name");
        }
        const auto x = fields.number<std::int32_t>();
        const auto y = fields.number<std::int32_t>();
        const auto width = fields.number<std::int32_t>();
        const auto height = fields.number<std::int32_t>();
        expect(x >= 0 && y >= 0 && width > 0 && height > 0 && x + width <= image.width &&
                   y + height <= image.height,
               "an update beyond the image");
        std::vector<std::int64_t> offsets, strides;
        for (std::int32_t c = 0; c < channels; ++c)
            offsets.push_back(fields.number<std::int64_t>());
        for (std::int32_t c = 0; c < channels; ++c)
            strides.push_back(fields.number<std::int64_t>());
        const std::int64_t pixels = std::int64_t{width} * height;
        std::vector<float> data(fields.left() / sizeof(float));
        for (float& value : data) value = fields.number<float>();
        for (std::size_t c = 0; c < offsets.size(); ++c) {
            for (std::int64_t pixel = 0; pixel < pixels; ++pixel) {
                const std::int64_t from = offsets[c] + pixel * strides[c];
                expect(from >= 0 && from < static_cast<std::int64_t>(data.size()),
                       "an update with too little data");
                const std::int64_t to = (y + pixel / width) * image.width + x + pixel % width;
                image.values[static_cast<std::size_t>(to) * offsets.size() + c] =
                    data[static_cast<std::size_t>(from)];
            }
        }
    }

    OnPacket on_packet_;
    int listening_ = -1;
    std::uint16_t port_ = 0;
    std::map<std::string, ShownImage> images_;
    std::size_t packets_ = 0;
    std::string fault_;
    std::thread thread_;
};

}  // namespace scotty::verify::test
