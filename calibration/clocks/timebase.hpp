#pragma once
// The one time base: every device's ticks on master time, from the stamps of all devices.
#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/clocks/clock_tracker.hpp"
#include "calibration/clocks/exposure_clock.hpp"
#include "drivers/data.hpp"
#include "drivers/ticks.hpp"
#include "drivers/view.hpp"

namespace shaker::calibration {

/// The devices whose clocks a Timebase follows.
struct TimebaseDevices {
    double dac_rate_hz = 0;            // nominal; 0: no DAC
    double accelerometer_rate_hz = 0;  // nominal; 0: no accelerometer
    double first_sample_s = 0;         // master time of the accelerometer's tick 0 when no DAC plays
    std::vector<View> cameras;
};

/// A device's clock against the host's clock, by the stamps so far.
struct ClockFit {
    double ppm = 0;          // rate above nominal, 1e-6; NaN: the nominal rate is unknown
    double ppm_sigma = 0;    // standard deviation of ppm; infinite before the first stamp
    Seconds delay{};         // mean delay of the stamps beyond the shortest one; NaN before the first stamp
    std::size_t stamps = 0;  // that were given, those of lost time included
    std::size_t jumps = 0;   // times the clock lost its place: a DAC that ran empty, stamps that jumped
};

/// Master time is the DAC's sample count over its nominal rate: exact. Every other clock is fitted to host
/// time by its stamps, the DAC's as well, and two maps in a row lead from a device's tick over host time to
/// the DAC's sample:
///
///     accelerometer tick --> host time --> DAC sample --> master time
///
/// Give it every stamp once, each device's in order. The devices do not depend on one another: only the
/// order within a device counts, so a recording's stamps give the same Timebase, to the bit. An answer uses
/// the newest maps, so it changes a little with later stamps.
///
/// Stamps can only be late. The shortest delay of a device's stamps stays in its map: no stamp shows it.
/// Without a DAC (footage of others) an accelerometer's ticks are counted from first_sample_s.
///
/// A recording holds the stamps since its begin. Between begin_recording() and end_recording() the same
/// stamps also give recorded(), the time base that a replay of the recording will have. One thread.
class Timebase {
public:
    Timebase() : Timebase{TimebaseDevices{}} {}
    explicit Timebase(const TimebaseDevices& devices);

    /// A block was played. After lost time the DAC's offset is found again; its rate is kept.
    void add(const PlayTime& played) noexcept;
    /// A block arrives when its last sample has been taken.
    void add(const AccelBlock& block) noexcept;
    /// Source of the mid-exposure of a frame.
    enum class FrameTime {
        all_stamps,     // of the run, when it is over
        stamps_so_far,  // for good: a recording holds the time with the frame
        frame           // carries it: its stamp shows the rate of the camera only
    };
    /// The next frame. Frames that do not carry their time are numbered from 0 for mid_exposure().
    void add(std::size_t camera, const FrameStamp& frame, FrameTime time = FrameTime::all_stamps);

    void begin_recording();
    /// By the stamps since begin_recording(); outside of a recording by all.
    [[nodiscard]] const Timebase& recorded() const noexcept {
        return recording_.empty() ? *this : recording_.front();
    }
    /// Returns recorded().
    Timebase end_recording();

    /// The DAC's clock is known.
    [[nodiscard]] bool dac_ready() const noexcept { return dac_.map().has_value(); }
    /// The clocks of DAC and accelerometer are known.
    [[nodiscard]] bool ready() const noexcept { return dac_.map() && accelerometer_.map(); }

    [[nodiscard]] MasterTime at(DacTick tick) const noexcept {
        return master_time(tick, devices_.dac_rate_hz);
    }
    /// NaN while the clocks are not ready().
    [[nodiscard]] MasterTime at(AccelTick tick) const noexcept;
    /// When a DAC sample was heard; empty while the DAC's clock is not known.
    [[nodiscard]] std::optional<HostTime> heard(DacTick tick) const noexcept;
    /// Middle of the exposure of frame `number`, which has been added; NaN while the DAC's clock is not
    /// known.
    [[nodiscard]] MasterTime mid_exposure(std::size_t camera, std::size_t number, const FrameStamp& frame);
    /// Number of added frames without those that carried their own time.
    [[nodiscard]] std::size_t frames(std::size_t camera) const { return cameras_.at(camera).clock.frames(); }
    /// All stamps are there: how far the frames of triggered cameras lag behind their pulses is found again
    /// by the final maps.
    void settle();

    [[nodiscard]] double dac_rate_hz() const noexcept { return devices_.dac_rate_hz; }
    [[nodiscard]] ClockFit dac() const noexcept;
    [[nodiscard]] ClockFit accelerometer() const noexcept;
    /// The count of exposures against the arrival of frames. A triggered camera runs at the DAC's rate.
    [[nodiscard]] ClockFit camera(std::size_t camera) const;
    /// A camera's own clock, since its last jump, against the arrival of frames; empty when it has none.
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
