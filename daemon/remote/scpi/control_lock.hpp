#pragma once
// Which client may change what the bench does: SYSTem:LOCK, and the page's "take control".
#include <string>
#include <utility>

namespace shaker::scpi {

/// One for all clients, each known by a name of its own: an address and port. While nobody holds it anyone
/// may change settings.
class ControlLock {
public:
    /// Whether `who` holds it now.
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
    /// Empty while nobody holds it.
    [[nodiscard]] const std::string& owner() const noexcept { return owner_; }

private:
    std::string owner_;
};

}  // namespace shaker::scpi
