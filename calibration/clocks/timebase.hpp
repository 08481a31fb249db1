#pragma once
// The one time base: every device's ticks on master time, from the stamps of all devices.
#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/clocks/clock_tracker.hpp"
#include "calibration/clocks/exposure_clock.hpp"
#include "drivers/data.hpp"
#include "drivers/time.hpp"
#include "drivers/view.hpp"

namespace shaker::calibration {

/// The devices whose clocks a Timebase follows.
struct TimebaseDevices {
    double dac_rate_hz = 0;            // nominal; 0: no DAC
    double accelerometer_rate_hz = 0;  // nominal; 0: no accelerometer
    double first_sample_s = 0;         // master time of the accelerometer's tick 0 when no DAC plays
    bool dac_clock = false;            // the accelerometer has the clock of the DAC
    std::vector<View> cameras;
};

/// A device's clock relative to the host's clock, from all stamps until now.
struct ClockFit {
    double ppm = 0;          // rate above nominal, 1e-6; NaN: the nominal rate is unknown
    double ppm_sigma = 0;    // standard deviation of ppm; infinite before the first stamp
    Seconds delay{};         // mean delay of the stamps minus the shortest one; NaN before the first stamp
    std::size_t stamps = 0;  // number of stamps, including those of lost time
    std::size_t jumps = 0;   // number of shifts: underruns of the DAC, jumps of a camera's stamps
};

/// Master time is exact: t = n / f_s, with n the DAC's sample count and f_s its nominal rate. Every clock,
/// the DAC's too, is mapped to host time by its stamps. Two maps lead from a device's tick to master time:
///
///     accelerometer tick --> host time --> DAC sample --> master time
///
/// Add every stamp once, in order for each device. The order between devices does not matter, so the stamps
/// of a recording give the same Timebase to the bit. Results use the newest maps, so they change slightly
/// with later stamps.
///
/// An accelerometer with the clock of the DAC has the DAC's rate by construction: its stamps determine one
/// constant, its delay.
///
/// Assumption: stamps are late, never early. The shortest delay of a device's stamps remains in its map,
/// because stamps cannot reveal it. Without a DAC (footage of others) an accelerometer's ticks are counted
/// from first_sample_s.
///
/// A recording holds the stamps since its begin. Between begin_recording() and end_recording() the same
/// stamps also give recorded(), the time base that a replay of the recording has.
/// Thread safety: one thread.
class Timebase {
public:
    Timebase() : Timebase{TimebaseDevices{}} {}
    explicit Timebase(const TimebaseDevices& devices);

    /// Adds a played block. Lost time restarts the fit of the DAC's offset and keeps its rate.
    void add(const PlayTime& played) noexcept;
    /// Adds a block. Its arrival is the stamp of its last sample.
    void add(const AccelBlock& block) noexcept;
    /// Source of the mid-exposure of a frame.
    enum class FrameTime {
        all_stamps,     // the stamps of the whole run
        stamps_so_far,  // final at once: a recording stores the time with the frame
        frame           // the frame carries it; its stamps are used for the camera's rate only
    };
    /// Adds the next frame. Frames that do not carry their time are numbered from 0 for mid_exposure().
    void add(std::size_t camera, const FrameStamp& frame, FrameTime time = FrameTime::all_stamps);

    void begin_recording();
    /// The time base from the stamps since begin_recording(); outside of a recording from all stamps.
    [[nodiscard]] const Timebase& recorded() const noexcept {
        return recording_.empty() ? *this : recording_.front();
    }
    /// Ends the recording and returns recorded().
    Timebase end_recording();

    /// True when the DAC's clock is known.
    [[nodiscard]] bool dac_ready() const noexcept { return dac_.map().has_value(); }
    /// True when the clocks of DAC and accelerometer are known.
    [[nodiscard]] bool ready() const noexcept { return dac_.map() && accelerometer_.map(); }

    [[nodiscard]] MasterTime at(DacTick tick) const noexcept {
        return master_time(tick, devices_.dac_rate_hz);
    }
    /// NaN while the clocks are not ready().
    [[nodiscard]] MasterTime at(AccelTick tick) const noexcept;
    /// Host time at which a DAC sample left the converter; empty while the DAC's clock is not known.
    [[nodiscard]] std::optional<HostTime> heard(DacTick tick) const noexcept;
    /// Middle of the exposure of the added frame `number`; NaN while the DAC's clock is not known.
    [[nodiscard]] MasterTime mid_exposure(std::size_t camera, std::size_t number, const FrameStamp& frame);
    /// Number of added frames, without those that carry their mid-exposure.
    [[nodiscard]] std::size_t frames(std::size_t camera) const { return cameras_.at(camera).clock.frames(); }
    /// Call it after the last stamp: the lag of triggered frames behind their pulses is then determined again
    /// from the final maps.
    void settle();

    [[nodiscard]] double dac_rate_hz() const noexcept { return devices_.dac_rate_hz; }
    [[nodiscard]] ClockFit dac() const noexcept;
    [[nodiscard]] ClockFit accelerometer() const noexcept;
    /// Count of exposures relative to the arrival of frames. A triggered camera runs at the DAC's rate.
    [[nodiscard]] ClockFit camera(std::size_t camera) const;
    /// A camera's own clock relative to the arrival of frames, since its last jump; empty without such a
    /// clock.
    [[nodiscard]] std::optional<ClockFit> camera_stamps(std::size_t camera) const;
    [[nodiscard]] std::size_t cameras() const noexcept { return cameras_.size(); }

private:
    struct FrameClock {
        ExposureClock clock;
        std::size_t stamps = 0;
    };

    TimebaseDevices devices_;
    ClockTracker<DacClock> dac_;
    ClockTracker<AccelerometerClock> accelerometer_;
    std::vector<FrameClock> cameras_;
    std::size_t plays_ = 0, blocks_ = 0, underruns_ = 0;
    std::vector<Timebase> recording_;  // one, or none outside of a recording
};

}  // namespace shaker::calibration
