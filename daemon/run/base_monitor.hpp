#pragma once
// The base's motion as the cameras see it during a run, against the displacement limit and the accelerometer.
#include <optional>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/acquisition/streams.hpp"
#include "daemon/control/period_windows.hpp"
#include "daemon/safety/trip.hpp"

namespace shaker::run {

/// A window of the accelerometer and the base's track of one camera in the same span of time. With the
/// acceleration A_q by the window, the position X_q by the camera and the exposure T, each harmonic q has
/// r_q = -(q w)^2 X_q / (A_q sin(pi q f T) / (pi q f T)).
struct BaseComparison {
    calibration::Estimate ratio;  // |r_q| of the harmonic 1 or 2 with the smaller error; sigma NaN: not known
    calibration::Estimate turn;   // rad, of r_1^2 / r_2: 0, or pi if one of both instruments has the wrong
                                  // sign; free of all delays. sigma NaN: a harmonic does not stand out
};
BaseComparison compare(const acquisition::TargetTrack& base, const control::PeriodWindows::Window& window,
                       const control::DriveHistory& drive);

/// A sentence for the operator, and the stop to order, if one is needed.
struct BaseFinding {
    std::string note;
    std::optional<safety::Trip> trip{};
};

class BaseMonitor {
public:
    /// A drive from rest begins: each camera is compared again.
    void begin() noexcept { tracks_.clear(), windows_ = 0; }
    /// displacement: half of the range of the newest period of the drive in a camera, less three standard
    /// deviations of a position, exceeds limit_m. The largest and the smallest of ten positions or more are
    /// left out: one wrong fix is no motion.
    std::optional<BaseFinding> watch(const acquisition::Streams& streams, double frequency, double limit_m);
    /// Compares a window of steady motion with each camera that has no verdict yet. base_motion: the ratio is
    /// outside 0.8 to 1.25 by more than three of its errors. polarity: the turn is beyond a right angle by
    /// more than three errors. Both in two windows in a row. An error above 10 % is no verdict; after 20
    /// windows at the level (`counts`) a note names the error.
    std::vector<BaseFinding> judge(const acquisition::Streams& streams,
                                   const control::PeriodWindows::Window& window,
                                   const control::DriveHistory& drive, bool counts);

private:
    std::vector<std::size_t> seen_;  // tracks taken of each target
    struct Judged {
        int wrong = 0;  // windows in a row
        bool right = false;
    };
    std::vector<Judged> tracks_;  // one for each target
    int windows_ = 0;             // compared at the level of the drive
};

}  // namespace shaker::run
