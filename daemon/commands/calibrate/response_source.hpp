#pragma once
// The lines that a response is fitted to: from recordings, folders of campaigns and certificates.
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/accelerometer/response_fit.hpp"

namespace shaker::commands {

struct ResponseSource {
    std::string sensor;             // its name in the recordings; empty: certificates only
    bool gravity = false;           // as AccelerometerInfo
    std::vector<std::string> runs;  // in the order of ResponseLine::run: file, and number of the measurement
    std::vector<calibration::ResponseLine> lines;
    std::vector<std::string> notes;  // runs without lines
};

/// A folder gives its recordings in the order of their names. A certificate is a CSV file with the columns
/// frequency_hz, gain, gain_error, phase_deg and phase_error_deg; gain in any unit, standard errors. Every
/// file is read in a confined child. InputError names a file that cannot be read or has another sensor.
ResponseSource response_source(const std::vector<std::filesystem::path>& from);

}  // namespace shaker::commands
