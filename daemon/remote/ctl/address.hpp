#pragma once
// Where the daemon is, and what lets this client in.
#include <filesystem>
#include <string>
#include <string_view>

namespace shaker::ctl {

inline constexpr const char* default_url = "http://127.0.0.1:8080";

struct Address {
    std::string host;  // a name or a number, without brackets
    std::string port;
    /// As a header Host has it: "[::1]:8080".
    [[nodiscard]] std::string text() const;
};

/// Of "http://bench:8080", "bench" or "[::1]:8080"; without a port it is the daemon's own, 8080. what: the
/// option or variable it comes from, for the InputError.
Address address_of(std::string_view what, std::string_view url);

/// The token in a file that only its owner may use. InputError naming the file otherwise.
std::string token_of_file(const std::filesystem::path& file);

/// The token as it is; InputError naming `what` where a header could not carry it. The token is not told.
std::string checked_token(std::string_view what, std::string token);

}  // namespace shaker::ctl
