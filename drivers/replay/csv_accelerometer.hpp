#pragma once
// An accelerometer's recording in a table of text, played back as an Accelerometer.
#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include "drivers/devices.hpp"

namespace shaker {

struct CsvAccelerometerFile {
    std::filesystem::path file;
    std::string time;                 // column: seconds on the sensor's own clock
    std::array<std::string, 3> axes;  // columns: m/s^2
    double clock_uncertainty_s = 0.02;
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes, or all 0
};

/// Reads the whole table. Stamps must lie on a regular grid within 20 % of a step; where samples are missing,
/// ticks are left out and the block after has Quality::gap. info().rate_hz and first_sample_s are the
/// straight line through all stamps; mps2_per_count is the power of ten that keeps as many of the text's
/// digits as 32 bits hold. Throws InputError naming file, line and column (see read_csv), also when there are
/// fewer than two samples or an acceleration is beyond 1e6 m/s^2. Nothing in it waits: a block's `arrived` is
/// its last sample's own time.
std::unique_ptr<Accelerometer> open_csv_accelerometer(const CsvAccelerometerFile& description);

}  // namespace shaker
