#pragma once
// The seam: three small device classes and the Rig that owns them. Hardware, simulated and replayed rigs are
// behind it; nothing above it knows which.
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/view.hpp"

namespace shaker {

struct DacInfo {
    std::string name;
    double rate_hz = 48000;
    double full_scale_V = 1;
};

/// Feeds the shaker; its sample counter is the master time.
class Dac {
public:
    virtual ~Dac() = default;
    [[nodiscard]] virtual DacInfo info() const = 0;
    /// Queues one block: the drive in volts and, on the second channel, the camera trigger (1 on the first
    /// sample of an exposure, else 0; same length). Returns when its first sample leaves the converter.
    /// Blocks; one thread.
    virtual PlayTime write(std::span<const double> volts, std::span<const double> trigger) = 0;
    /// Silences the output and unblocks write(). Safe from any thread.
    virtual void stop() noexcept = 0;
};

struct AccelerometerInfo {
    std::string name;
    double rate_hz = 4000;  // nominal, on its own clock
    double mps2_per_count = 1;
    double first_sample_s = 0;            // its own clock at tick 0
    double clock_uncertainty_s = 0.02;    // its stamps may be early or late by up to this against master time
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes, or all 0: find it from the motion
};

class Accelerometer {
public:
    virtual ~Accelerometer() = default;
    [[nodiscard]] virtual AccelerometerInfo info() const = 0;
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
