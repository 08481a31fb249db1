#pragma once
// Response of an accelerometer from lines at several frequencies that a reference sees, too: the simplest
// corner and low-pass that describe them.
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "drivers/response/sensor_response.hpp"

namespace shaker::calibration {

/// Accelerometer against reference at one frequency; errors are standard errors by noise.
struct ResponseLine {
    int run = 0;  // lines of a run have one time between the instruments in common
    double hz = 0;
    Estimate log_gain;  // ln of amplitude by the accelerometer over that by the reference
    Estimate lead_rad;  // phase by the accelerometer minus that by the reference
};

/// One of the models.
struct TriedResponse {
    SensorResponse response{};
    double chi2 = 0;
    int unknowns = 0;
    double share = 0;  // probability among the models, by their BIC
};

struct FittedResponse {
    SensorResponse response{};  // errors: by noise, and by the other models as far as they are probable
    Estimate log_gain;
    double chi2 = 0;
    int freedom = 0;
    std::vector<double> delay_s;  // of each run: the accelerometer is later
    std::vector<TriedResponse> tried;
    std::vector<ResponseLine> rest;  // lines minus the model
};

/// "no lower corner", "1 pole at 0.33 Hz", "low-pass of 2 poles at 812 Hz", ...
std::string words(const LowerCorner& corner);
std::string words(const LowPass& pass);

/// gravity: the sensor is coupled down to DC. InputError with the counts where the lines are fewer than the
/// unknowns of the simplest model, or all at one frequency.
FittedResponse fit_response(std::span<const ResponseLine> lines, bool gravity);

}  // namespace shaker::calibration
