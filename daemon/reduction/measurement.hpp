#pragma once
// What was measured in one run, scaled to SI, each stream on the clock it came with: the input of a
// reduction.
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace shaker {

/// Positions of one target in one view. Lost frames are left out and counted.
struct MotionSeries {
    std::string view;
    std::vector<double> t_s;   // master time of mid-exposure, increasing
    std::vector<double> x_m;   // along the shaker's axis; only differences mean anything
    std::vector<double> sd_m;  // standard deviation of each
    int lost = 0;
    double stream_from_s = 1e300,
           stream_to_s = -1e300;  // of the view's frames, lost ones too, where that is known
};

/// Accelerometer samples in m/s^2 in sensor axes.
struct AccelSeries {
    std::vector<double> t_s;  // the sensor's own clock, increasing; gaps allowed
    std::vector<std::array<double, 3>> a_mps2;
    double clock_uncertainty_s = 0.02;    // its clock may be early or late by up to this
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes, or all 0: find it from the motion
};

struct Measurement {
    double frequency_hz = 20;         // nominal
    bool frequency_is_exact = false;  // true when the drive's samples are the master time
    AccelSeries accelerometer;
    std::vector<MotionSeries> walkers;  // one a view that sees it; at least one
    std::vector<MotionSeries> bases;
    double from_s = -1e300, to_s = 1e300;  // reduce only this part (master time)
};

}  // namespace shaker
