#pragma once
// An Accelerometer that plays back a table of accelerations.
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker::footage {

struct CsvAccelerometerFile {
    std::filesystem::path file;
    std::string time;                 // column: time on the sensor's own clock; empty with rate_hz
    std::vector<std::string> axes;    // columns: accelerations along x, x and y, or all axes of the sensor
    bool gravity = true;              // as AccelerometerInfo
    SensorResponse response{};        // as AccelerometerInfo
    std::string time_unit{}, unit{};  // words as of unit_in(); empty: of the table, else s and m/s^2
    std::optional<double> rate_hz{};  // instead of a column `time`: of the rows, from first_sample_s on
    double first_sample_s = 0;
    double clock_uncertainty_s = 0.02;
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes; all 0: derived from the motion
};

struct OpenCsvAccelerometer {
    std::unique_ptr<Accelerometer> accelerometer;
    std::vector<std::string> notes;  // units that the table states, one sentence each
};

/// Reads the whole table. Stamps must be on a regular grid within 20 % of a step; missing samples leave a gap
/// in the ticks, and the next block has Quality::gap. info().rate_hz and first_sample_s: straight line
/// through all stamps. mps2_per_count: the power of ten that keeps as many digits of the text as fit into 32
/// bits. A unit that the description does not give is that of a row of units, or of the column's name.
/// Throws InputError with file, line and column (see read_csv), also for fewer than two samples or
/// accelerations above 1e6 m/s^2. read() never waits; `arrived` of a block is the time of its last sample.
OpenCsvAccelerometer open_csv_accelerometer(const CsvAccelerometerFile& description);

}  // namespace shaker::footage
