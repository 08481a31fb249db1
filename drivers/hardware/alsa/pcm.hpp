#pragma once
// AlsaPcm: one opened playback PCM with the parameters agreed with libasound. Functions marked real-time
// return libasound's negative error numbers; all others throw DeviceError.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/time.hpp"

namespace shaker::alsa {

/// Parameters granted by the device.
struct AlsaGranted {
    std::string pcm;
    SampleFormat format{};
    int rate_hz = 0;
    int channels = 0;
    int significant_bits = 0;  // of its converter; 0: unknown
    int period_frames = 0;
    int buffer_frames = 0;
    bool rewinds = false;    // frames can be taken back, so a ramp is queued behind the drive
    int queue_frames = 0;    // most samples of the drive that wait to be played
    int kept_frames = 0;     // of these, samples that stay when a hard stop takes the queue back
    int stop_threshold = 0;  // free frames at which the stream stops
    bool monotonic = false;  // its stamps are CLOCK_MONOTONIC

    /// One line for an operator.
    [[nodiscard]] std::string text() const;
};

/// Number of frames between the last frame written and the frame being played, at a time.
struct AlsaDelay {
    std::int64_t frames;
    HostTime at;
};

class AlsaPcm {
public:
    /// Opens without waiting, sets exactly the requested format, rate, period and buffer (resampling off),
    /// and tests whether frames can be taken back. An error names the refused value and the range that the
    /// device allows.
    explicit AlsaPcm(const AlsaSettings& settings);
    AlsaPcm(const AlsaPcm&) = delete;
    AlsaPcm& operator=(const AlsaPcm&) = delete;
    ~AlsaPcm();

    [[nodiscard]] const AlsaGranted& granted() const noexcept;

    // Real-time, as far as libasound is.

    /// Frames written and not played yet. Negative: an error, or the number of frames by which playback has
    /// overtaken them.
    struct Queued {
        int error;
        std::int64_t frames;
    };
    [[nodiscard]] Queued queued() noexcept;
    /// Empties the device and prepares it for start().
    [[nodiscard]] int prepare() noexcept;
    [[nodiscard]] int start() noexcept;
    /// Number of frames written (all of them if there is room), or an error.
    [[nodiscard]] std::int64_t write(std::span<const std::byte> frames) noexcept;
    [[nodiscard]] std::int64_t write_silence(std::int64_t frames) noexcept;
    /// Takes back the last `frames`, all or none. Returns the number of frames left to play; -1 when fewer
    /// than `least` are left, or some of those to take back have been played.
    [[nodiscard]] std::int64_t rewind(std::int64_t frames, std::int64_t least = 0) noexcept;
    /// Most frames that the device lets rewind() take back now; 0 after an error.
    [[nodiscard]] std::int64_t rewindable() noexcept;
    [[nodiscard]] int delay(AlsaDelay& out) noexcept;
    /// Waits for room, for data at `wake_fd`, or for the time-out. Returns an error when the stream cannot
    /// continue.
    [[nodiscard]] int wait(int wake_fd, std::chrono::nanoseconds at_most) noexcept;
    void drop() noexcept;

    /// Throws "what: libasound's text" with the device's name.
    [[noreturn]] void fail(const std::string& what, int error) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::alsa
