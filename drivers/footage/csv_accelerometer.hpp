#pragma once
// An Accelerometer that plays back a text table of accelerations.
#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include "drivers/devices.hpp"

namespace shaker::footage {

struct CsvAccelerometerFile {
    std::filesystem::path file;
    std::string time;                 // column: seconds on the sensor's own clock
    std::array<std::string, 3> axes;  // columns: m/s^2
    double clock_uncertainty_s = 0.02;
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes; all 0: derived from the motion
};

/// Reads the whole table. Stamps must be on a regular grid within 20 % of a step; missing samples leave a gap
/// in the ticks, and the next block has Quality::gap. info().rate_hz and first_sample_s: straight line
/// through all stamps. mps2_per_count: the power of ten that keeps as many digits of the text as fit into 32
/// bits. Throws InputError with file, line and column (see read_csv), also for fewer than two samples or
/// accelerations above 1e6 m/s^2. read() never waits; `arrived` of a block is the time of its last sample.
std::unique_ptr<Accelerometer> open_csv_accelerometer(const CsvAccelerometerFile& description);

}  // namespace shaker::footage
