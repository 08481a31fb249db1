#pragma once
// CapturePcm: one opened capture PCM with the parameters agreed with libasound. Functions marked real-time
// return libasound's negative error numbers; all others throw DeviceError.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/hardware/alsa_input/settings.hpp"
#include "drivers/time.hpp"

namespace shaker::alsa_input {

class CapturePcm {
public:
    /// Opens without waiting for data and sets exactly the requested format, rate, period and buffer
    /// (resampling off); period and buffer are the nearest ones, a period of at most a block of the sensor.
    /// The fewest channels of the device that contain those of the settings. An error names the refused value
    /// and what the device allows.
    explicit CapturePcm(const InputSettings& settings);
    CapturePcm(const CapturePcm&) = delete;
    CapturePcm& operator=(const CapturePcm&) = delete;
    ~CapturePcm();

    [[nodiscard]] std::size_t frame_bytes() const noexcept;
    /// Bits of the converter; 0: unknown.
    [[nodiscard]] int significant_bits() const noexcept;
    /// The card's long name; empty without a card.
    [[nodiscard]] const std::string& card() const noexcept;
    /// One line for an operator.
    [[nodiscard]] std::string text() const;

    // Real-time, as far as libasound is.

    /// Empties the device and starts it.
    [[nodiscard]] int start() noexcept;
    /// Number of frames read, at most as many as there is room for; 0: none waits.
    [[nodiscard]] std::int64_t read(std::span<std::byte> room) noexcept;
    /// Frames captured and not read yet, at a time.
    struct Waiting {
        std::int64_t frames = 0;
        HostTime at{};
    };
    [[nodiscard]] int waiting(Waiting& out) noexcept;
    /// Waits for a period of frames.
    void wait(std::chrono::milliseconds at_most) noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::alsa_input
