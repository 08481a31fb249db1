#include "daemon/remote/access/access.hpp"

#include <algorithm>
#include <cctype>
#include <random>

#include "daemon/remote/access/server_clock.hpp"

namespace shaker::access {

namespace {

// "[::1]:8080" or "bench:8080" without the port.
std::string_view name_of(std::string_view host) {
    const auto bracket = host.find(']');
    const auto colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
    return host.substr(0, colon);
}

}  // namespace

std::string random_identity() {
    constexpr std::string_view digits = "0123456789abcdef";
    std::random_device chance;
    std::uniform_int_distribution<std::size_t> place{0, digits.size() - 1};
    std::string identity;
    while (identity.size() < 16) identity += digits[place(chance)];
    return identity;
}

bool Access::host_allowed(std::string_view host) const {
    const std::string_view name = name_of(host);
    return std::ranges::any_of(hosts, [&](const std::string& h) {
        return std::ranges::equal(
            h, name, [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
    });
}

bool Access::origin_allowed(std::string_view origin, std::string_view host) const {
    if (origin.empty()) return true;
    for (const std::string_view scheme : {"http://", "https://"})
        if (origin.starts_with(scheme) && origin.substr(scheme.size()) == host) return true;
    return false;
}

bool Access::token_allowed(std::string_view given) const noexcept {
    if (token.empty()) return true;
    unsigned differ = given.size() == token.size() ? 0 : 1;
    for (std::size_t i = 0; i < token.size(); ++i) {
        const char c = i < given.size() ? given[i] : '\0';
        differ |= static_cast<unsigned>(static_cast<unsigned char>(c) ^ static_cast<unsigned char>(token[i]));
    }
    return differ == 0;
}

Aborts::Receipt Aborts::give(const std::string& by) {
    const std::uint64_t number = output_.stop(by);
    if (given_) given_(by);
    return [obeyed = output_.obeyed, number, given = ServerClock::now()] {
        if (obeyed() >= number) return Answer::obeyed;
        return ServerClock::now() - given < patience ? Answer::none : Answer::silent;
    };
}

}  // namespace shaker::access
