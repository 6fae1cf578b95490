/// The viewer's protocol, against a server that reads it strictly.
#include <cstring>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/verify/tev_server.h"
#include "verify/render/tev_display.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
using reference::Image;
using reference::Vec3;

Image gradient(std::uint32_t width, std::uint32_t height) {
    Image image{width, height, {}};
    for (std::uint32_t i = 0; i < width * height; ++i) {
        const auto at = static_cast<float>(i);
        image.pixels.emplace_back(at, -0.5f * at, 1.0f / (at + 3.0f));
    }
    return image;
}

bool shows(const TevServer& server, const std::string& name, const Image& image) {
    const auto found = server.images().find(name);
    if (found == server.images().end()) return false;
    const ShownImage& shown = found->second;
    return shown.width == static_cast<std::int32_t>(image.width) &&
           shown.height == static_cast<std::int32_t>(image.height) &&
           shown.values.size() == 3 * image.pixels.size() &&
           std::memcmp(shown.values.data(), image.pixels.data(), 4 * shown.values.size()) == 0;
}

DisplayAddress address_of(const TevServer& server) {
    return {"127.0.0.1", std::to_string(server.port())};
}

}  // namespace

TEST_CASE("display: an address is a host and a port, and IPv6 stands in brackets",
          "[verify][display]") {
    for (const auto& [text, expected] : {std::pair{"localhost:14158", "localhost:14158"},
                                         {"10.0.0.1:1", "10.0.0.1:1"},
                                         {"viewer.example", "viewer.example:14158"},
                                         {"[::1]:65535", "[::1]:65535"},
                                         {"[fe80::2%eth0]", "[fe80::2%eth0]:14158"}}) {
        CHECK(to_string(parse_display(text)) == expected);
    }
    for (const char* text :
         {"", ":14158", "host:", "host:0", "host:65536", "host:-1", "host:port", "host:80x",
          "host:99999999999", "::1", "::1:14158", "[::1", "[::1]80", "[]:80", "a:1:2"}) {
        INFO(text);
        CHECK_THROWS_WITH(parse_display(text),
                          ContainsSubstring("--display") && ContainsSubstring("localhost:14158"));
    }
}

TEST_CASE("display: what the viewer holds is the last image sent, bit for bit",
          "[verify][display]") {
    const Image image = gradient(7, 5);
    TevServer server;
    TevDisplay display(address_of(server), "coil.exr", 7, 5);
    display.update(Image{7, 5, std::vector<Vec3>(35, Vec3(9.0f))});
    display.update(image);
    display.finish();
    server.wait();
    CHECK(server.fault() == "");
    CHECK(server.packets() == 3);
    CHECK(server.images().size() == 1);
    CHECK(server.images().at("coil.exr").channels == std::vector<std::string>{"R", "G", "B"});
    CHECK(shows(server, "coil.exr", image));
}

TEST_CASE("display: an image of many pixels goes in several packets", "[verify][display]") {
    for (const auto& [width, height] : {std::pair{2000u, 1200u}, {40000u, 53u}}) {
        const Image image = gradient(width, height);
        TevServer server;
        TevDisplay display(address_of(server), "large", width, height);
        display.update(image);
        display.finish();
        server.wait();
        CHECK(server.fault() == "");
        CHECK(server.packets() == 1 + 3);
        CHECK(shows(server, "large", image));
    }
}

TEST_CASE("display: IPv6", "[verify][display]") {
    TevServer server([](std::size_t) { return true; }, AF_INET6);
    if (server.port() == 0) {
        WARN("not run: no IPv6 here");
        return;
    }
    const Image image = gradient(3, 2);
    TevDisplay display(parse_display("[::1]:" + std::to_string(server.port())), "six", 3, 2);
    display.update(image);
    display.finish();
    server.wait();
    CHECK(server.fault() == "");
    CHECK(shows(server, "six", image));
}

TEST_CASE("display: where nobody listens the address is named, and the way out",
          "[verify][display]") {
    DisplayAddress nobody;
    {
        TevServer gone;
        nobody = address_of(gone);
    }
    CHECK_THROWS_WITH(TevDisplay(nobody, "x", 1, 1), ContainsSubstring(to_string(nobody)) &&
                                                         ContainsSubstring("refused") &&
                                                         ContainsSubstring("start tev"));
    CHECK_THROWS_WITH(
        TevDisplay({"no host", "14158"}, "x", 1, 1),
        ContainsSubstring("no host:14158") && ContainsSubstring("check the host's name"));
}

TEST_CASE("display: a viewer that hangs up half-way is an error and no signal",
          "[verify][display]") {
    TevServer server([](std::size_t packets) { return packets < 2; });
    TevDisplay display(address_of(server), "x", 1000, 1000);
    const Image image = gradient(1000, 1000);
    const auto until_it_fails = [&] {
        for (int i = 0; i < 100; ++i) display.update(image);
    };
    CHECK_THROWS_WITH(until_it_fails(), ContainsSubstring(to_string(address_of(server))));
}

TEST_CASE("display: one lost image at the end is noticed", "[verify][display]") {
    TevServer server([](std::size_t packets) { return packets < 2; });
    TevDisplay display(address_of(server), "x", 2, 2);
    display.update(gradient(2, 2));
    server.wait();  // it has hung up
    const auto to_the_end = [&] {
        display.update(gradient(2, 2));
        display.finish();
    };
    CHECK_THROWS_WITH(to_the_end(), ContainsSubstring(to_string(address_of(server))));
}

TEST_CASE("display: a viewer that takes nothing is given up", "[verify][display]") {
    // Nobody accepts: the system makes the connection, and takes what fits its buffers.
    const int listening = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(at);
    REQUIRE(bind(listening, reinterpret_cast<sockaddr*>(&at), size) == 0);
    REQUIRE(listen(listening, 1) == 0);
    REQUIRE(getsockname(listening, reinterpret_cast<sockaddr*>(&at), &size) == 0);
    const DisplayAddress address{"127.0.0.1", std::to_string(ntohs(at.sin_port))};
    TevDisplay display(address, "x", 1000, 1000, std::chrono::milliseconds(20));
    const Image image = gradient(1000, 1000);
    const auto until_it_fails = [&] {
        for (int i = 0; i < 100; ++i) display.update(image);
    };
    CHECK_THROWS_WITH(until_it_fails(), ContainsSubstring("does not take what it is sent"));
    CHECK_THROWS_WITH(display.finish(), ContainsSubstring("does not take what it is sent"));
    close(listening);
}

}  // namespace scotty::verify::test
