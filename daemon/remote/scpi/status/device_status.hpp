#pragma once
// State of the bench for all sessions: the condition registers of STATus:OPERation and STATus:QUEStionable.
#include <array>
#include <cstddef>
#include <cstdint>

namespace shaker::scpi {

enum class Operation : std::uint8_t {
    calibrating = 0,
    settling = 1,
    sweeping = 3,
    recording = 4,
    waiting_trigger = 5,
    equaliser_active = 7,
    output_on = 8,
    cameras_locked = 9,
    reduction_steady = 10,
    sequence_running = 14,
};

enum class Questionable : std::uint8_t {
    drive_limited = 0,
    clock_fit = 2,
    frequency = 5,
    phase = 6,
    calibration = 8,
    abort_latched = 9,
    open_channel = 10,
    data_loss = 11,
    tracking_lost = 12,
};

/// 15 bits, with the number of times each was set and cleared: late readers still see both.
class ConditionRegister {
public:
    void set(std::uint8_t bit, bool on) noexcept {
        const auto mask = static_cast<std::uint16_t>(1U << bit);
        if (((bits_ & mask) != 0) == on) return;
        bits_ = static_cast<std::uint16_t>(bits_ ^ mask);
        ++(on ? rises_ : falls_).at(bit);
        ++changes_;
    }
    [[nodiscard]] std::uint16_t bits() const noexcept { return bits_; }
    [[nodiscard]] std::uint64_t changes() const noexcept { return changes_; }
    [[nodiscard]] const std::array<std::uint64_t, 15>& rises() const noexcept { return rises_; }
    [[nodiscard]] const std::array<std::uint64_t, 15>& falls() const noexcept { return falls_; }

private:
    std::uint16_t bits_ = 0;
    std::uint64_t changes_ = 0;
    std::array<std::uint64_t, 15> rises_{}, falls_{};
};

/// One for all sessions; changed by the thread that runs them.
struct DeviceStatus {
    ConditionRegister operation;
    ConditionRegister questionable;
    std::uint64_t trips = 0;  // since the start of the bench

    void set(Operation bit, bool on) noexcept { operation.set(static_cast<std::uint8_t>(bit), on); }
    void set(Questionable bit, bool on) noexcept { questionable.set(static_cast<std::uint8_t>(bit), on); }
};

}  // namespace shaker::scpi
