#pragma once
// Which session may change what the bench does: SYSTem:LOCK.
#include <string>
#include <utility>

namespace shaker::scpi {

class Session;

/// One for all sessions. While nobody holds it anyone may change settings.
class ControlLock {
public:
    /// Whether `who` holds it now.
    bool request(const Session& who, std::string name) {
        if (holder_ == nullptr) {
            holder_ = &who;
            name_ = std::move(name);
        }
        return holder_ == &who;
    }
    void release(const Session& who) noexcept {
        if (holder_ != &who) return;
        holder_ = nullptr;
        name_.clear();
    }
    [[nodiscard]] bool allows(const Session& who) const noexcept {
        return holder_ == nullptr || holder_ == &who;
    }
    /// Empty while nobody holds it.
    [[nodiscard]] const std::string& owner() const noexcept { return name_; }

private:
    const Session* holder_ = nullptr;
    std::string name_;
};

}  // namespace shaker::scpi
