#pragma once
// ControlLock: the client that may change the bench, for SYSTem:LOCK and the page's "take control".
#include <string>
#include <utility>

namespace shaker::access {

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

}  // namespace shaker::access
