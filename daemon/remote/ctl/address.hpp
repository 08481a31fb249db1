#pragma once
// Address and token of the daemon.
#include <filesystem>
#include <string>
#include <string_view>

namespace shaker::ctl {

inline constexpr const char* default_url = "http://127.0.0.1:8080";

struct Address {
    std::string host;  // a name or a number, without brackets
    std::string port;
    /// The value of the HTTP header Host: "[::1]:8080".
    [[nodiscard]] std::string text() const;
};

/// Reads "http://bench:8080", "bench" or "[::1]:8080"; the default port is 8080. what: option or variable
/// that the text comes from, named in the InputError.
Address address_of(std::string_view what, std::string_view url);

/// Reads the token from a file of mode 600. InputError with the name of the file if others can read it.
std::string token_of_file(const std::filesystem::path& file);

/// Returns the token unchanged. InputError naming `what` (not the token) if an HTTP header cannot carry it.
std::string checked_token(std::string_view what, std::string token);

}  // namespace shaker::ctl
