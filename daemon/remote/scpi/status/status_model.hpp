#pragma once
// StatusModel: status of one session, as in IEEE 488.2 chapter 11 and SCPI-99 volume 1, chapter 5.
#include <cstdint>
#include <string_view>

#include "daemon/remote/scpi/status/device_status.hpp"
#include "daemon/remote/scpi/status/error_queue.hpp"
#include "daemon/remote/scpi/status/status_register.hpp"

namespace shaker::scpi {

/// Bits of the status byte.
namespace stb {
inline constexpr std::uint8_t errors = 1U << 2, questionable = 1U << 3, message_available = 1U << 4,
                              event_status = 1U << 5, master_summary = 1U << 6, operation = 1U << 7;
}
/// Bits of the standard event status register that are not errors.
namespace esr {
inline constexpr std::uint8_t operation_complete = 1U << 0, power_on = 1U << 7;
}

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
