#pragma once
// Status as in IEEE 488.2 chapter 11 and SCPI-99 volume 1, chapter 5: of the bench, and of one session.
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "daemon/remote/scpi/error.hpp"

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

/// One session's view of a condition register, with filters for events and a mask for the summary.
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

/// Errors of one session, oldest first, until the client reads them. Bounded: when full, its newest entry
/// becomes -350 and later errors are lost.
class ErrorQueue {
public:
    static constexpr std::size_t capacity = 32;
    static constexpr std::size_t longest_text = 255;  // characters, as in SCPI-99

    struct Entry {
        Code code = Code::none;
        std::string text;  // the standard's text, then ";" and the detail if there is one
    };

    /// Returns the code stored: -350 when the queue was full.
    Code push(Code code, std::string_view detail);
    /// Code::none, "No error" when empty.
    Entry pop();
    void clear() noexcept { entries_.clear(); }
    [[nodiscard]] bool empty() const noexcept { return entries_.empty(); }
    [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }

private:
    std::deque<Entry> entries_;
};

/// Bits of the status byte.
namespace stb {
inline constexpr std::uint8_t errors = 1U << 2, questionable = 1U << 3, message_available = 1U << 4,
                              event_status = 1U << 5, master_summary = 1U << 6, operation = 1U << 7;
}
/// Bits of the standard event status register that are not errors.
namespace esr {
inline constexpr std::uint8_t operation_complete = 1U << 0, power_on = 1U << 7;
}

/// Status of one session.
class StatusModel {
public:
    explicit StatusModel(const DeviceStatus& device)
        : operation{device.operation}, questionable{device.questionable} {}

    StatusRegister operation;
    StatusRegister questionable;
    ErrorQueue errors;

    /// Queues the error and sets the event bit of its class.
    void report(Code code, std::string_view detail);
    /// Number of calls of report().
    [[nodiscard]] std::uint64_t reported() const noexcept { return reported_; }
    void raise_event(std::uint8_t bits) noexcept { events_ = static_cast<std::uint8_t>(events_ | bits); }
    /// *ESR?: returns and clears the events.
    std::uint8_t take_events() noexcept;
    /// *CLS: clears events and errors; keeps masks.
    void clear() noexcept;
    [[nodiscard]] std::uint8_t status_byte(bool message_available) noexcept;

    [[nodiscard]] std::uint8_t event_mask() const noexcept { return event_mask_; }
    void set_event_mask(std::uint8_t mask) noexcept { event_mask_ = mask; }
    [[nodiscard]] std::uint8_t service_mask() const noexcept { return service_mask_; }
    /// Bit 6 cannot be enabled: it reads 0.
    void set_service_mask(std::uint8_t mask) noexcept { service_mask_ = mask & ~stb::master_summary & 0xffU; }

private:
    std::uint64_t reported_ = 0;
    std::uint8_t events_ = esr::power_on, event_mask_ = 0, service_mask_ = 0;
};

}  // namespace shaker::scpi
