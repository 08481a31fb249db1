#pragma once
// Input of a controller: for each window of whole periods, the base's harmonics beside the drive that made
// them.
#include <array>
#include <vector>

#include "calibration/clocks/timebase.hpp"
#include "daemon/control/drive_history.hpp"
#include "daemon/control/equaliser.hpp"
#include "daemon/control/harmonic_estimator.hpp"
#include "drivers/devices.hpp"

namespace shaker::control {

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

    AccelerometerInfo accelerometer_;
    int harmonics_;
    double line_hz_;
    double dac_rate_hz_;
    DriveHistory history_;
    std::array<double, 3> axis_{}, mean_{};  // as the newest window found them
    HarmonicEstimator estimator_;
    double tuned_from_s_ = 0;  // the estimator's frequency is the drive's from here on
    double until_s_ = 0;
};

}  // namespace shaker::control
