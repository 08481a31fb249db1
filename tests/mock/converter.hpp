#pragma once
// Converter: the mock DAC behind the PCM plug-in. Runs on its own clock and plays the stream of a libasound
// client, or silence.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "drivers/time.hpp"

namespace shaker::mock {

/// The clock that the mock devices share with the drivers.
inline HostTime host_now() { return HostTime{std::chrono::steady_clock::now().time_since_epoch()}; }

struct ConverterCounts {
    std::uint64_t frames = 0;     // played from a stream (silence written by a client included)
    std::uint64_t streams = 0;    // started
    std::uint64_t underruns = 0;  // streams that ran empty, or were made to, and were not closed then
    std::uint64_t replayed = 0;   // old samples repeated by a stream without new ones
    std::uint64_t missed = 0;     // overwritten before take(): the owner is seconds late
};

/// The owner's side. Its samples are the timeline: sample n is output at epoch + n / (rate (1 + 1e-6 ppm)) of
/// CLOCK_MONOTONIC; the epoch is the time of construction. take(): one thread; all others: any thread.
class Converter {
public:
    /// Creates `file`, which the plug-in maps, and removes it at the end; in /dev/shm it never touches a
    /// disk. With `log`, every sample taken is appended to that file as two int32 (codes of channels 1 and 2,
    /// left-justified, native endian): timeline sample n is at byte 8 n. Throws DeviceError when a file
    /// cannot be created.
    Converter(const std::filesystem::path& file, double rate_hz, double ppm,
              const std::filesystem::path& log = {});
    Converter(const Converter&) = delete;
    Converter& operator=(const Converter&) = delete;
    ~Converter();

    /// Number of samples that have ended at `now`: take() may take all before this one.
    [[nodiscard]] std::int64_t due(HostTime now) const noexcept;
    [[nodiscard]] HostTime time_of(std::int64_t sample) const noexcept;
    /// Number of samples taken; the next take() begins with this one.
    [[nodiscard]] std::int64_t taken() const noexcept;
    /// The next samples in order, as shares of full scale; the spans have the same length, `third` may be
    /// empty. Call at least every 5 s at 48 kHz, or samples are overwritten and counted as missed.
    void take(std::span<double> first, std::span<double> second, std::span<double> third = {});

    /// Stops the running stream, as after an underrun.
    void cause_underrun() noexcept;
    /// Removes the device for its client until plug(); the output is silent.
    void unplug() noexcept;
    void plug() noexcept;
    /// Halts playback from now on for `duration`: the output is silent and the client's position does not
    /// advance. At most 256 times.
    void stall(Seconds duration) noexcept;

    [[nodiscard]] ConverterCounts counts() const noexcept;
    /// Timeline sample at which each stream began, for streams that take() has passed.
    [[nodiscard]] std::vector<std::int64_t> stream_starts() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::mock
