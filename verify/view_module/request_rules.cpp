#include "verify/view_module/request_rules.h"

#include <algorithm>
#include <cctype>

namespace scotty::verify {
namespace {

constexpr std::size_t kMostTarget = 512;

bool all_of(std::string_view text, int (*kind)(int)) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [kind](char c) {
        return kind(static_cast<unsigned char>(c)) != 0;
    });
}

/// The host without its port; nothing where it has no such form.
std::optional<std::string_view> without_port(std::string_view host) {
    std::size_t end = host.size();
    if (host.starts_with('[')) {
        end = host.find(']');
        if (end == std::string_view::npos) return std::nullopt;
        ++end;
    } else {
        end = std::min(host.find(':'), host.size());
    }
    const std::string_view port = host.substr(end);
    if (!port.empty() &&
        (port[0] != ':' || port.size() > 6 || !all_of(port.substr(1), std::isdigit)))
        return std::nullopt;
    return host.substr(0, end);
}

bool is_numeric(std::string_view name) {
    if (name.starts_with('[') && name.ends_with(']')) {
        name = name.substr(1, name.size() - 2);
        return !name.empty() && name.find_first_not_of("0123456789abcdefABCDEF:.") == name.npos;
    }
    return std::count(name.begin(), name.end(), '.') == 3 &&
           name.find_first_not_of("0123456789.") == name.npos;
}

}  // namespace

bool is_loopback(std::string_view address) {
    return address == "127.0.0.1" || address == "localhost" || address == "::1" ||
           address == "[::1]";
}

bool is_allowed_host(std::string_view host, bool beyond_loopback) {
    const auto name = without_port(host);
    if (!name) return false;
    return is_loopback(*name) || (beyond_loopback && is_numeric(*name));
}

bool is_allowed_origin(std::string_view origin, bool beyond_loopback) {
    constexpr std::string_view kScheme = "http://";
    if (!origin.starts_with(kScheme)) return false;
    return is_allowed_host(origin.substr(kScheme.size()), beyond_loopback);
}

bool is_token(std::string_view given, std::string_view token) {
    if (given.size() != token.size() || token.empty()) return false;
    unsigned differences = 0;
    for (std::size_t i = 0; i < token.size(); ++i) {
        differences |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(token[i]);
    }
    return differences == 0;
}

RequestVerdict judge(const RequestHead& head, const ViewServerOptions& options) {
    const bool beyond = !is_loopback(options.address);
    if (head.method != "GET") return {405, {}, "only GET is answered"};
    if (head.has_body) return {413, {}, "a request has no body here"};
    if (!head.host || !is_allowed_host(*head.host, beyond)) {
        return {403, {}, "this host name is not one of the loopback's"};
    }
    if (head.origin && !is_allowed_origin(*head.origin, beyond)) {
        return {403, {}, "pages of other origins are not served"};
    }
    std::string_view target = head.target;
    if (target.size() > kMostTarget) return {414, {}, "the address is too long"};
    target = target.substr(0, target.find('?'));
    if (!target.starts_with('/')) return {400, {}, "the address does not begin with /"};
    target.remove_prefix(1);
    const std::size_t slash = std::min(target.find('/'), target.size());
    if (!is_token(target.substr(0, slash), options.token)) {
        return {404, {}, "nothing is here; the link that scotty view printed has a token in it"};
    }
    return {200, std::string(target.substr(std::min(slash + 1, target.size()))), {}};
}

}  // namespace scotty::verify
