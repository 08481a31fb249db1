#pragma once
// One opened playback PCM: libasound's handle and what was agreed with it. Errors of calls marked real-time
// are libasound's negative numbers; the rest throws DeviceError.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/hardware/alsa_settings.hpp"
#include "drivers/time.hpp"

namespace shaker {

/// What the device gave.
struct AlsaGranted {
    std::string pcm;
    SampleFormat format{};
    int rate_hz = 0;
    int channels = 0;
    int significant_bits = 0;  // of its converter; 0: not told
    int period_frames = 0;
    int buffer_frames = 0;
    bool rewinds = false;    // frames can be taken back, so a ramp lies behind the drive
    int stop_threshold = 0;  // frames of room at which the stream stops
    bool monotonic = false;  // its stamps are CLOCK_MONOTONIC

    /// One line for an operator.
    [[nodiscard]] std::string text() const;
};

/// Frames between the application's end and what is heard, at a time.
struct AlsaDelay {
    std::int64_t frames;
    HostTime at;
};

class AlsaPcm {
public:
    /// Opens without waiting, agrees on exactly what `settings` ask (format, rate, period, buffer; resampling
    /// off) and tries whether frames can be taken back. What is refused is named with the range that the
    /// device allows.
    explicit AlsaPcm(const AlsaSettings& settings);
    AlsaPcm(const AlsaPcm&) = delete;
    AlsaPcm& operator=(const AlsaPcm&) = delete;
    ~AlsaPcm();

    [[nodiscard]] const AlsaGranted& granted() const noexcept;

    // Real-time, as far as libasound is.

    /// Frames written and not played yet; below 0 either an error or how far playing has gone beyond them.
    struct Queued {
        int error;
        std::int64_t frames;
    };
    [[nodiscard]] Queued queued() noexcept;
    /// Empties the device and makes it ready for start().
    [[nodiscard]] int prepare() noexcept;
    [[nodiscard]] int start() noexcept;
    /// Frames taken (all of them when there is room), or an error.
    [[nodiscard]] std::int64_t write(std::span<const std::byte> frames) noexcept;
    [[nodiscard]] std::int64_t write_silence(std::int64_t frames) noexcept;
    /// Takes the last `frames` back, all or none. How many are left to play; -1 when part of those to take
    /// back has been played.
    [[nodiscard]] std::int64_t rewind(std::int64_t frames) noexcept;
    [[nodiscard]] int delay(AlsaDelay& out) noexcept;
    /// Waits for room, for something to read at `wake_fd`, or for the time to pass. An error when the stream
    /// cannot go on.
    [[nodiscard]] int wait(int wake_fd, std::chrono::nanoseconds at_most) noexcept;
    void drop() noexcept;

    /// "what: libasound's words", with the device's name.
    [[noreturn]] void fail(const std::string& what, int error) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
