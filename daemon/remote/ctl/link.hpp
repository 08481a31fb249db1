#pragma once
// The daemon as this client reaches it: requests on a connection each, and its live messages.
#include <chrono>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "daemon/remote/ctl/address.hpp"

namespace shaker::ctl {

using Clock = std::chrono::steady_clock;

/// With a daemon that does not answer.
inline constexpr std::chrono::seconds patience{5};

struct Link {
    Address at;
    std::string token;   // empty: none is shown
    std::string client;  // what this client calls itself

    /// The body of what is at `path`. Refused, NotReached.
    [[nodiscard]] std::string get(const std::string& path) const;
    /// The same as JSON; NotReached where it is none, since no shakerd is there then.
    [[nodiscard]] nlohmann::json get_json(const std::string& path) const;
    /// POST /api/<action>, its body {} or an object. Refused, NotReached.
    void order(const std::string& action, const nlohmann::json& fields,
               std::chrono::milliseconds within = patience) const;
};

/// A name that no other client has: "ctl" and nine letters.
std::string client_name();

/// The messages of /ws.
class LiveMessages {
public:
    /// Refused, NotReached.
    explicit LiveMessages(const Link& link);
    ~LiveMessages();
    LiveMessages(const LiveMessages&) = delete;
    LiveMessages& operator=(const LiveMessages&) = delete;

    /// The next one, an object with "type"; none where there was none until then. NotReached when the daemon
    /// goes or says nothing for 5 s.
    std::optional<nlohmann::json> next(Clock::time_point until);

private:
    struct Socket;
    std::unique_ptr<Socket> socket_;
};

}  // namespace shaker::ctl
