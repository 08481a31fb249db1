#pragma once
// The mock DAC behind the PCM plug-in: a converter that runs for ever on a clock of its own and plays what
// a client of libasound gives it, silence when there is none.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "drivers/time.hpp"

namespace shaker {

struct ConverterCounts {
    std::uint64_t frames = 0;     // played from a stream (silence that a client wrote is counted too)
    std::uint64_t streams = 0;    // started
    std::uint64_t underruns = 0;  // streams that ran dry, or were made to, and were not closed then
    std::uint64_t replayed = 0;   // old samples that a stream repeated for want of new ones
    std::uint64_t missed = 0;     // overwritten before take() came for them: the owner is seconds late
};

/// Owner's side. Its samples are the timeline: sample n is put out at epoch + n / (rate (1 + 1e-6 ppm)) of
/// CLOCK_MONOTONIC, the epoch being the instant of construction. take() by one thread, the rest by any.
class Converter {
public:
    /// Creates `file` for the plug-in to map (and removes it at the end): in /dev/shm it never meets a disk.
    /// With `log`, every sample taken is appended to that file as two int32 (both channels' codes,
    /// left-justified, native endian): timeline sample n lies at byte 8 n. Throws DeviceError when a file
    /// cannot be made.
    Converter(const std::filesystem::path& file, double rate_hz, double ppm,
              const std::filesystem::path& log = {});
    Converter(const Converter&) = delete;
    Converter& operator=(const Converter&) = delete;
    ~Converter();

    /// How many samples are over at `now`: take() may be asked for all before this one.
    [[nodiscard]] std::int64_t due(HostTime now) const noexcept;
    [[nodiscard]] HostTime time_of(std::int64_t sample) const noexcept;
    /// Samples taken so far: the next take() begins with this one.
    [[nodiscard]] std::int64_t taken() const noexcept;
    /// The next samples in order, as shares of full scale; both spans are of one length. At least every 5 s
    /// at 48 kHz, or samples are overwritten and counted as missed.
    void take(std::span<double> first, std::span<double> second);

    /// The stream that runs stops, as if it had run dry.
    void cause_underrun() noexcept;
    /// The device is gone for its client until plug(); the output is silent.
    void unplug() noexcept;
    void plug() noexcept;
    /// Playing stands still from now on for so long: the output is silent, the client's position does not
    /// move. At most 256 times.
    void stall(Seconds duration) noexcept;

    [[nodiscard]] ConverterCounts counts() const noexcept;
    /// Timeline sample at which each stream began, of those that take() has passed.
    [[nodiscard]] std::vector<std::int64_t> stream_starts() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker
