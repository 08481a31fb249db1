#pragma once
// Input of a reduction: the data of one run in SI units, each stream on its own clock.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibration/accelerometer/tumble.hpp"
#include "drivers/response/sensor_response.hpp"

namespace shaker::reduction {

/// Positions of one target in one view. Lost frames have no entry and are counted.
struct MotionSeries {
    std::string view;
    std::vector<double> t_s;   // master time of mid-exposure, increasing
    std::vector<double> x_m;   // along the shaker's axis; only differences are meaningful
    std::vector<double> sd_m;  // standard deviation of each position
    double exposure_s = 0;
    double scale_error = 0;  // relative standard error of the view's scale, systematic; 0: not known
    int lost = 0;
    int repeated = 0;  // of the lost frames: delivered twice or torn
    int doubtful = 0;  // places in doubt; of these: clipped, perhaps at a neighbour's place
    int clipped = 0, slipped = 0;
    bool with_doubtful = false;  // they are in the list, since fewer than half of the places are undoubted
    double stream_from_s = 1e300,
           stream_to_s = -1e300;  // span of the view's frames, lost ones included; default: unknown
};

/// Accelerometer samples in m/s^2, sensor axes; sign as AccelerometerInfo::acceleration (gravity included).
struct AccelSeries {
    std::vector<double> t_s;  // the sensor's own clock, increasing; gaps allowed
    std::vector<std::array<double, 3>> a_mps2;
    int axes = 3;                         // as AccelerometerInfo
    bool gravity = true;                  // as AccelerometerInfo
    SensorResponse response{};            // as AccelerometerInfo
    bool dac_clock = false;               // as AccelerometerInfo
    double clock_uncertainty_s = 0.02;    // s, largest error of the clock against master time, either sign
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes; all 0: derived from the motion
    std::optional<calibration::Tumble> calibration{};  // in force; empty: its errors are not known
};

struct Measurement {
    double frequency_hz = 20;         // nominal
    bool frequency_is_exact = false;  // true when the drive's samples are the master time
    AccelSeries accelerometer;
    std::vector<MotionSeries> walkers;  // one per view that sees the walker; at least one
    std::vector<MotionSeries> bases;
    double from_s = -1e300, to_s = 1e300;  // reduces only this part (master time)
};

}  // namespace shaker::reduction
