#pragma once
// Input of a controller: for each window of whole periods, the base's harmonics beside the drive that made
// them.
#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "calibration/clocks/timebase.hpp"
#include "daemon/control/equaliser.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "daemon/control/mains.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker::control {

/// Harmonics and phase of the drive at any time, from the changes as they were applied.
class DriveHistory {
public:
    /// Silent at phase 0 and this frequency from sample 0 on.
    DriveHistory(double rate_hz, double frequency);

    /// Appends a change; call in the order of application. Changes that it voids are forgotten. Keeps the
    /// newest few hundred. A stop during a ramp is treated as one at the ramp's end: both are followed by
    /// silence.
    void add(const DriveChange& change);

    /// Phase of the drive in turns, whole turns included, at master time at_s.
    [[nodiscard]] double turns(double at_s) const;
    /// Mean harmonics over a span; ramps are weighted.
    [[nodiscard]] Harmonics<Voltage> mean(double from_s, double to_s) const;
    /// True if the span has no ramp and no change.
    [[nodiscard]] bool steady(double from_s, double to_s) const;
    /// Frequency of the newest change, Hz, and the sequence number of its command.
    [[nodiscard]] double frequency() const { return changes_.back().frequency; }
    [[nodiscard]] std::uint64_t sequence() const { return changes_.back().sequence; }
    /// Master time at which the newest change was complete, s.
    [[nodiscard]] double in_force_s() const { return changes_.back().end_s; }

private:
    struct Change {
        Harmonics<Voltage> volts;
        double frequency = 0;
        std::uint64_t sequence = 0;
        double begin_s = 0, end_s = 0;  // of the ramp
        double begin_turns = 0, end_turns = 0;
    };
    void append(const Change& c);

    double rate_hz_;
    std::deque<Change> changes_;
};

class PeriodWindows {
public:
    struct Window {
        PeriodEstimate estimate;
        PeriodWindow motion;         // steady: no change in the window; whether a newer command waits is
                                     // not known here
        std::uint64_t sequence = 0;  // of the newest command applied
        double from_s = 0, to_s = 0;
    };
    /// line_hz: of the mains; 0: none.
    PeriodWindows(double dac_rate_hz, const AccelerometerInfo& accelerometer, double frequency, int harmonics,
                  double line_hz);

    void add(const DriveChange& change);
    /// The mains in the sensor, from the samples before the first drive.
    [[nodiscard]] std::optional<Mains> mains() const { return mains_.found(); }
    /// Fits a line of this frequency (Hz) from now on.
    void fit_line(double hz);
    /// Windows that ended with this block, oldest first. Those of a time when the frequency changed are left
    /// out. `timebase` has the block's stamp; a block before it is ready() is left out.
    std::vector<Window> add(const AccelBlock& block, const calibration::Timebase& timebase);
    /// Master time of the end of the last block, s; 0 until the clocks are known.
    [[nodiscard]] double until_s() const noexcept { return until_s_; }
    [[nodiscard]] const AccelerometerInfo& accelerometer() const noexcept { return accelerometer_; }
    [[nodiscard]] const DriveHistory& history() const noexcept { return history_; }
    /// Along the shaker's axis as the newest window found it, without its constant part; 0 before the first.
    [[nodiscard]] double along(const std::array<double, 3>& a) const noexcept {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) sum += axis_[k] * (a[k] - mean_[k]);
        return sum;
    }

private:
    [[nodiscard]] EstimatorSettings estimator_settings(double frequency,
                                                       const std::array<double, 3>& before) const;
    void take_off_response(PeriodEstimate& e) const;

    AccelerometerInfo accelerometer_;
    int harmonics_;
    double line_hz_;
    double dac_rate_hz_;
    DriveHistory history_;
    std::array<double, 3> axis_{}, mean_{};  // as the newest window found them
    HarmonicEstimator estimator_;
    MainsWatch mains_;
    double tuned_from_s_ = 0;  // the estimator's frequency is the drive's from here on
    double until_s_ = 0;
};

}  // namespace shaker::control
