#pragma once
// One session's view of a condition register: which changes count as events, which events are summed up.
#include <array>
#include <cstdint>

#include "daemon/remote/scpi/device_status.hpp"

namespace shaker::scpi {

class StatusRegister {
public:
    static constexpr std::uint16_t usable = 0x7fff;  // SCPI keeps bit 15 at 0

    /// Changes before this are no events. The register must outlive this.
    explicit StatusRegister(const ConditionRegister& condition);

    [[nodiscard]] std::uint16_t condition() const noexcept { return condition_->bits(); }
    /// Events since they were last taken.
    std::uint16_t take_event() noexcept;
    /// Whether an enabled event is there: its bit of the status byte.
    [[nodiscard]] bool summary() noexcept;
    void clear_event() noexcept { take_event(); }
    /// STATus:PRESet: nothing is enabled, each change from 0 to 1 is an event. Events stay.
    void preset() noexcept;

    [[nodiscard]] std::uint16_t enabled() const noexcept { return enabled_; }
    [[nodiscard]] std::uint16_t rising() const noexcept { return rising_; }
    [[nodiscard]] std::uint16_t falling() const noexcept { return falling_; }
    void enable(std::uint16_t mask) noexcept { enabled_ = mask & usable; }
    /// A changed filter is for changes from now on.
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
