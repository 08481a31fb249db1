#pragma once
// The device seam: Dac, Accelerometer, Camera, AbortInput, and the Rig that owns them.
// Hardware, simulated and replayed rigs implement it; code above does not know which.
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/mixer/mixer.hpp"
#include "drivers/response/sensor_response.hpp"
#include "drivers/view.hpp"

namespace shaker {

/// Counts since the device was opened. The unit is one DAC sample, one accelerometer sample (three axes)
/// or one picture.
struct DeviceCounts {
    std::uint64_t taken = 0;      // delivered; DAC: played
    std::uint64_t lost = 0;       // missing; DAC: duration of underruns
    std::uint64_t incidents = 0;  // number of underruns, overruns, time-outs and broken transfers
    std::uint64_t reopened = 0;   // number of times the device was closed and opened again
};

struct DacInfo {
    std::string name;
    double rate_hz = 48000;
    double full_scale_V = 1;
    std::size_t block_frames = 240;  // samples per write(); 240 are 5 ms at 48 kHz
    std::int64_t queue_frames = 0;   // most samples of the drive that wait to be played after write()
    std::int64_t kept_frames = 0;    // of these, samples that take_back() leaves; all: none can be taken back
    /// Ramp to zero that is played behind the queue if write() is not called again.
    std::int64_t ramp_frames = 0;
    double enable_before_s = 0;  // time from the start of the enable tone to the drive; 0: no such tone
    double pulse_hz = 0;         // of trigger pulses that no camera of the rig asks for; 0: none
    [[nodiscard]] bool takes_back() const noexcept { return kept_frames < queue_frames; }
};

/// Analogue output that feeds the shaker. Its sample counter is the master time.
class Dac {
public:
    virtual ~Dac() = default;
    [[nodiscard]] virtual DacInfo info() const = 0;
    /// Any thread.
    [[nodiscard]] virtual DeviceCounts counts() const noexcept { return {}; }
    /// Queues one block: the drive in volts and, on the second channel, the camera trigger (1 on the
    /// first sample of an exposure, else 0; same length). Returns when the block's first sample
    /// leaves the converter or, on hardware with a queue, as soon as there is room. Blocks; one
    /// thread. Throws DeviceError when the device has failed permanently.
    virtual PlayTime write(std::span<const double> volts, std::span<const double> trigger) = 0;
    /// Takes back up to `most` of the samples that were written last and are not played yet, and leaves
    /// DacInfo::kept_frames. Returns how many; the next write() continues behind the last sample that stays.
    /// 0 if the DAC cannot or if it fails: then all queued samples are played. Real-time; thread of write().
    [[nodiscard]] virtual std::int64_t take_back(std::int64_t /*most*/) noexcept { return 0; }
    /// The samples of later write() calls, and the ramp behind them, have the enable tone of the amplifier if
    /// `on`. Without a channel for it nothing happens. Real-time; thread of write().
    virtual void enable(bool /*on*/) noexcept {}
    /// Silences the output and unblocks write(). Safe from any thread.
    virtual void stop() noexcept = 0;
};

struct AccelerometerInfo {
    std::string name;
    double rate_hz = 4000;  // nominal, on its own clock
    int axes = 3;           // that it measures: x, x and y, or all; counts and gains of the others are 0
    /// The constant part of the reading is gravity and offset. False: no gravity, as of an IEPE sensor, whose
    /// output has no constant part.
    bool gravity = true;
    SensorResponse response{};  // of all axes; no lower corner with gravity
    bool dac_clock = false;     // its samples have the clock of the DAC: the rate is exact on master time
    std::array<double, 3> offset_counts{};          // see acceleration()
    std::array<double, 3> mps2_per_count{1, 1, 1};  // negative where counts fall as acceleration rises
    /// [i][k]: m/s^2 on axis i per count on axis k, i != k; 0 without a calibration.
    std::array<std::array<double, 3>, 3> cross_mps2_per_count{};
    double first_sample_s = 0;  // s, sensor clock at tick 0
    /// Largest error in s of the sensor's stamps against master time, either sign.
    double clock_uncertainty_s = 0.02;
    /// A sample at or beyond +-range is saturated.
    double range_mps2 = std::numeric_limits<double>::infinity();
    double block_s = 0;                   // s, sampling time per delivered block, approximate; 0: unknown
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes; all 0: derived from the motion
    std::string calibration{};            // content of the calibration file in force; empty: none

    /// One sample in m/s^2: (count + offset_counts) * mps2_per_count for each axis, and the cross axes'
    /// share. Frame: right-handed axes of the sensor, as its maker marks them. Sign: specific force, a_sensor
    /// - g_vector, as a MEMS sensor reports it. With `gravity`, at rest an axis that points up reads +g
    /// (about +9.8 m/s^2), one that points down -g, a level one 0. An acceleration of the base
    /// towards +axis reads positive. Use: shaker_axis (unit vector towards the base's +x, in these axes)
    /// times this vector is a_base - g sin(tilt), where tilt > 0 means that +x points downhill. The constant
    /// part is gravity and offset; the harmonic estimator, the aligner and the guards separate it from the
    /// motion.
    [[nodiscard]] std::array<double, 3> acceleration(
        const std::array<std::int32_t, 3>& counts) const noexcept {
        std::array<double, 3> c{}, a{};
        for (std::size_t k = 0; k < 3; ++k) c[k] = counts[k] + offset_counts[k];
        for (std::size_t i = 0; i < 3; ++i) {
            a[i] = c[i] * mps2_per_count[i];
            for (std::size_t k = 0; k < 3; ++k) a[i] += cross_mps2_per_count[i][k] * c[k];
        }
        return a;
    }
};

class Accelerometer {
public:
    virtual ~Accelerometer() = default;
    [[nodiscard]] virtual AccelerometerInfo info() const = 0;
    /// Any thread.
    [[nodiscard]] virtual DeviceCounts counts() const noexcept { return {}; }
    /// The next block in order. Waits at most `wait`; false when none arrived in that time or the
    /// recording has ended. One thread.
    virtual bool read(AccelBlock& block, std::chrono::milliseconds wait) = 0;
    /// Samples that have arrived since the last call while their ticks may still be unknown, in order, so
    /// that their levels are checked at once; read() delivers each of them later. Writes at most
    /// counts.size(); returns how many. Devices that know the tick of each sample on arrival have none.
    /// Thread of read().
    virtual std::size_t read_early(std::span<std::array<std::int32_t, 3>> /*counts*/) noexcept { return 0; }
    /// True when no more data will come: the recording has ended or the device was stopped.
    [[nodiscard]] virtual bool ended() const noexcept = 0;
    virtual void stop() noexcept = 0;
};

class Camera {
public:
    virtual ~Camera() = default;
    /// Geometry and targets; view().camera is the camera's name.
    [[nodiscard]] virtual const View& view() const = 0;
    /// Any thread.
    [[nodiscard]] virtual DeviceCounts counts() const noexcept { return {}; }
    /// The next frame in order. Waits at most `wait`; null when none arrived in that time or the
    /// recording has ended. One thread.
    virtual FramePtr read(std::chrono::milliseconds wait) = 0;
    [[nodiscard]] virtual bool ended() const noexcept = 0;
    virtual void stop() noexcept = 0;
};

enum class Contact { closed, open, unreadable };

/// Abort input: a normally closed contact that stops the drive.
class AbortInput {
public:
    virtual ~AbortInput() = default;
    /// State of the contact; open also if it was open since the last call. Waits at most `wait` for a change.
    /// One thread.
    [[nodiscard]] virtual Contact read(std::chrono::milliseconds wait) noexcept = 0;
};

/// What the operator should check when a device fails a test, in the words of its kind. One question or
/// clause each, without a full stop.
struct DeviceAdvice {
    std::string_view silent = "is it connected and switched on?";  // no data arrived
    std::string_view rate_off = "is its clock good?";              // no crystal is that far off
    bool operator==(const DeviceAdvice&) const = default;
};
struct RigAdvice {
    DeviceAdvice dac{}, accelerometer{};
    std::vector<DeviceAdvice> cameras{};  // in the order of Rig::cameras; may be shorter
};

/// Owner of the devices of a bench. Footage of other laboratories has no Dac; a rig for tracking only has
/// no accelerometer.
struct Rig {
    std::string name;
    std::unique_ptr<Dac> dac;
    std::unique_ptr<Accelerometer> accelerometer;
    std::vector<std::unique_ptr<Camera>> cameras;
    RigAdvice advice{};
    std::unique_ptr<AbortInput> abort_input{};  // null: none
    std::vector<MixerDevice> mixers{};          // of the sound cards
};

/// Sample counts of a device at the end of a run.
struct DeviceReport {
    std::string device;  // the device's name
    std::string what;    // unit of the counts: "samples", "frames"
    DeviceCounts counts;
};

/// Counts of DAC, accelerometer and cameras, in this order. Missing devices have no entry.
inline std::vector<DeviceReport> device_reports(const Rig& rig) {
    std::vector<DeviceReport> reports;
    if (rig.dac) reports.push_back({rig.dac->info().name, "samples", rig.dac->counts()});
    if (rig.accelerometer)
        reports.push_back({rig.accelerometer->info().name, "samples", rig.accelerometer->counts()});
    for (const auto& camera : rig.cameras)
        reports.push_back({"camera \"" + camera->view().camera + "\"", "frames", camera->counts()});
    return reports;
}

}  // namespace shaker
