#pragma once
// What all doors of the daemon share: who may come in, who holds control, and aborts, which work for
// everyone.
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace shaker::access {

/// Access rules of the HTTP side: allowed host names, origins of pages, token for other machines.
struct Access {
    std::vector<std::string>
        hosts;          // host names of the daemon, without a port; include "localhost" and "127.0.0.1"
    std::string token;  // empty: no token is required

    /// Rejects a page of another site that reaches the daemon under its own name (DNS rebinding): that name
    /// is in `Host`.
    [[nodiscard]] bool host_allowed(std::string_view host) const;
    /// True if the page's origin is the host it was loaded from, or without an origin (not a page).
    [[nodiscard]] bool origin_allowed(std::string_view origin, std::string_view host) const;
    /// Comparison in constant time: the duration does not depend on the number of correct characters.
    [[nodiscard]] bool token_allowed(std::string_view given) const noexcept;
};

/// 16 random hexadecimal digits, different at each start of the daemon.
std::string random_identity();

/// Refusal of an order while `owner` holds the lock.
inline std::string held_text(const std::string& owner) {
    return "control is held by " + owner +
           "; release it there, or close that page or connection (a page keeps it for 10 s); abort works for "
           "everyone";
}

/// One for all clients. A client is known by its address and port. While nobody holds the lock, any client
/// may change settings.
class ControlLock {
public:
    /// Requests the lock; true if `who` holds it now.
    bool request(const std::string& who) {
        if (owner_.empty()) owner_ = who;
        return owner_ == who;
    }
    void release(const std::string& who) noexcept {
        if (owner_ == who) owner_.clear();
    }
    [[nodiscard]] bool allows(const std::string& who) const noexcept {
        return owner_.empty() || owner_ == who;
    }
    /// Holder of the lock; empty: nobody.
    [[nodiscard]] const std::string& owner() const noexcept { return owner_; }

private:
    std::string owner_;
};

/// Gives the aborts of all clients to the output and watches that the output obeys them. Used on the thread
/// that serves the clients; no function waits.
class Aborts {
public:
    enum class Answer : std::uint8_t {
        none,    // not yet, and still within `patience`
        obeyed,  // the output ramps to zero, or was silent and latched already
        silent,  // the output did not answer in time
    };
    /// The answer to one abort. Call it until it is not `none`.
    using Receipt = std::function<Answer()>;
    struct Output {
        std::function<std::uint64_t(const std::string& by)> stop;  // stops the drive; number of this abort
        std::function<std::uint64_t()> obeyed;  // number of the newest abort that the output has obeyed
    };

    static constexpr std::chrono::milliseconds patience{100};
    static constexpr const char* silent_text = "the output does not answer: cut the amplifier";

    explicit Aborts(Output output) : output_{std::move(output)} {}

    /// Stops the drive at once. by: name of the client.
    Receipt give(const std::string& by);
    /// Sets a function that is called after each abort: what waits to be ordered by other clients is dropped.
    void after(std::function<void(const std::string& by)> given) { given_ = std::move(given); }

private:
    Output output_;
    std::function<void(const std::string& by)> given_;
};

}  // namespace shaker::access
