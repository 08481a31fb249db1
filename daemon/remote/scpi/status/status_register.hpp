#pragma once
// StatusRegister: one session's view of a condition register, with filters for events and a mask for the
// summary.
#include <array>
#include <cstdint>

#include "daemon/remote/scpi/status/device_status.hpp"

namespace shaker::scpi {

class StatusRegister {
public:
    static constexpr std::uint16_t usable = 0x7fff;  // SCPI keeps bit 15 at 0

    /// Earlier changes are no events. The register must outlive this object.
    explicit StatusRegister(const ConditionRegister& condition);

    [[nodiscard]] std::uint16_t condition() const noexcept { return condition_->bits(); }
    /// Returns and clears the events.
    std::uint16_t take_event() noexcept;
    /// True if an enabled event is set: its bit of the status byte.
    [[nodiscard]] bool summary() noexcept;
    void clear_event() noexcept { take_event(); }
    /// STATus:PRESet: enables nothing, and makes each change from 0 to 1 an event. Keeps events.
    void preset() noexcept;

    [[nodiscard]] std::uint16_t enabled() const noexcept { return enabled_; }
    [[nodiscard]] std::uint16_t rising() const noexcept { return rising_; }
    [[nodiscard]] std::uint16_t falling() const noexcept { return falling_; }
    void enable(std::uint16_t mask) noexcept { enabled_ = mask & usable; }
    /// A new filter applies to later changes.
    void filter_rising(std::uint16_t mask) noexcept;
    void filter_falling(std::uint16_t mask) noexcept;

private:
    void update() noexcept;

    const ConditionRegister* condition_;
    std::uint64_t changes_seen_;
    std::array<std::uint64_t, 15> rises_seen_, falls_seen_;
    std::uint16_t event_ = 0, enabled_ = 0, rising_ = usable, falling_ = 0;
};

}  // namespace shaker::scpi
