#pragma once
// WatchedContact: an abort input whose openings are timed.
#include <atomic>
#include <chrono>
#include <memory>
#include <utility>

#include "drivers/devices.hpp"

namespace shaker::commissioning {

/// Present state and first opening of a contact. Thread safety: any thread.
class ContactWatch {
public:
    using Clock = std::chrono::steady_clock;
    /// Forgets the opening.
    void restart() noexcept { opened_ = 0; }
    void note(bool open) noexcept {
        open_ = open;
        Clock::rep none = 0;
        if (open) opened_.compare_exchange_strong(none, Clock::now().time_since_epoch().count());
    }
    /// At the newest reading, or unreadable.
    [[nodiscard]] bool open() const noexcept { return open_; }
    /// First reading of an open contact since restart(). A contact may bounce.
    [[nodiscard]] Clock::time_point opened_at() const noexcept {
        return Clock::time_point{Clock::duration{opened_}};
    }

private:
    std::atomic<bool> open_{false};
    std::atomic<Clock::rep> opened_{0};
};

/// Passes on the readings of another input.
class WatchedContact final : public AbortInput {
public:
    /// watch: outlives this object.
    WatchedContact(std::unique_ptr<AbortInput> input, ContactWatch& watch)
        : input_{std::move(input)}, watch_{watch} {}
    [[nodiscard]] Contact read(std::chrono::milliseconds wait) noexcept override {
        const Contact contact = input_->read(wait);
        watch_.note(contact != Contact::closed);
        return contact;
    }

private:
    std::unique_ptr<AbortInput> input_;
    ContactWatch& watch_;
};

}  // namespace shaker::commissioning
