#pragma once
// Address and token of the daemon, and the connection to it: requests, each on its own connection, and live
// messages.
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
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

using Clock = std::chrono::steady_clock;

/// Time limit of a request.
inline constexpr std::chrono::seconds patience{5};

struct Link {
    Address at;
    std::string token;   // empty: no token is sent
    std::string client;  // name of this client

    /// GET `path`; returns the body. Throws Refused, NotReached.
    [[nodiscard]] std::string get(const std::string& path) const;
    /// The same as JSON. Throws NotReached if the body is not JSON, because the server is then not shakerd.
    [[nodiscard]] nlohmann::json get_json(const std::string& path) const;
    /// POST /api/<action>; the body is {} or an object. Throws Refused, NotReached.
    void order(const std::string& action, const nlohmann::json& fields,
               std::chrono::milliseconds within = patience) const;
};

/// A unique name: "ctl" and nine random letters.
std::string client_name();

/// Reads the messages of /ws.
class LiveMessages {
public:
    /// Throws Refused, NotReached.
    explicit LiveMessages(const Link& link);
    ~LiveMessages();
    LiveMessages(const LiveMessages&) = delete;
    LiveMessages& operator=(const LiveMessages&) = delete;

    /// The next message, an object with "type"; empty if none came before `until`. NotReached if the
    /// connection closes or is silent for 5 s.
    std::optional<nlohmann::json> next(Clock::time_point until);

private:
    struct Socket;
    std::unique_ptr<Socket> socket_;
};

}  // namespace shaker::ctl
