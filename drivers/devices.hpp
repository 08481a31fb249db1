#pragma once
// The seam: three small device classes and the Rig that owns them. Hardware, simulated and replayed rigs are
// behind it; nothing above it knows which.
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/view.hpp"

namespace shaker {

/// What a device has counted since it was opened. Samples are frames of the DAC or of the accelerometer (all
/// axes together), or pictures.
struct DeviceCounts {
    std::uint64_t taken = 0;      // samples handed on (by a DAC: played)
    std::uint64_t lost = 0;       // samples that should have come and did not (of a DAC: time it stood empty)
    std::uint64_t incidents = 0;  // underruns, overruns, time-outs, broken transfers: each once
    std::uint64_t reopened = 0;   // the device was closed and opened again
};

struct DacInfo {
    std::string name;
    double rate_hz = 48000;
    double full_scale_V = 1;
    std::size_t block_frames = 240;  // samples a write; 5 ms at 48 kHz
};

/// Feeds the shaker; its sample counter is the master time.
class Dac {
public:
    virtual ~Dac() = default;
    [[nodiscard]] virtual DacInfo info() const = 0;
    /// Any thread.
    [[nodiscard]] virtual DeviceCounts counts() const noexcept { return {}; }
    /// Queues one block: the drive in volts and, on the second channel, the camera trigger (1 on the first
    /// sample of an exposure, else 0; same length). Returns when its first sample leaves the converter
    /// or, on hardware that queues, as soon as there was room. Blocks; one thread.
    /// A device that fails for good throws DeviceError.
    virtual PlayTime write(std::span<const double> volts, std::span<const double> trigger) = 0;
    /// Silences the output and unblocks write(). Safe from any thread.
    virtual void stop() noexcept = 0;
};

struct AccelerometerInfo {
    std::string name;
    double rate_hz = 4000;                  // nominal, on its own clock
    std::array<double, 3> offset_counts{};  // acceleration = (count + offset) mps2_per_count, each axis
    std::array<double, 3> mps2_per_count{1, 1, 1};
    double first_sample_s = 0;          // its own clock at tick 0
    double clock_uncertainty_s = 0.02;  // its stamps may be early or late by up to this against master time
    double range_mps2 = std::numeric_limits<double>::infinity();  // a sample there is saturated
    double block_s = 0;                                           // of sampling that comes at a time, about
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes, or all 0: find it from the motion

    /// One sample in m/s^2, sensor axes.
    [[nodiscard]] std::array<double, 3> acceleration(
        const std::array<std::int32_t, 3>& counts) const noexcept {
        std::array<double, 3> a{};
        for (std::size_t k = 0; k < 3; ++k) a[k] = (counts[k] + offset_counts[k]) * mps2_per_count[k];
        return a;
    }
};

class Accelerometer {
public:
    virtual ~Accelerometer() = default;
    [[nodiscard]] virtual AccelerometerInfo info() const = 0;
    /// Any thread.
    [[nodiscard]] virtual DeviceCounts counts() const noexcept { return {}; }
    /// Its sign of life: samples that came, also those whose place in time is still being decided. Any
    /// thread.
    [[nodiscard]] virtual std::uint64_t heard() const noexcept { return counts().taken; }
    /// The next block in order. Waits at most `wait`; false when none came or the recording has ended. One
    /// thread.
    virtual bool read(AccelBlock& block, std::chrono::milliseconds wait) = 0;
    /// Nothing will come any more (end of a recording, or stopped).
    [[nodiscard]] virtual bool ended() const noexcept = 0;
    virtual void stop() noexcept = 0;
};

class Camera {
public:
    virtual ~Camera() = default;
    /// What this camera sees; view().camera is its name.
    [[nodiscard]] virtual const View& view() const = 0;
    /// Any thread.
    [[nodiscard]] virtual DeviceCounts counts() const noexcept { return {}; }
    /// The next frame in order. Waits at most `wait`; null when none came or the recording has ended. One
    /// thread.
    virtual FramePtr read(std::chrono::milliseconds wait) = 0;
    [[nodiscard]] virtual bool ended() const noexcept = 0;
    virtual void stop() noexcept = 0;
};

/// Owner of what a bench has. A session that shakerd did not record has no Dac; one for tracking only has no
/// accelerometer.
struct Rig {
    std::string name;
    std::unique_ptr<Dac> dac;
    std::unique_ptr<Accelerometer> accelerometer;
    std::vector<std::unique_ptr<Camera>> cameras;
};

}  // namespace shaker
