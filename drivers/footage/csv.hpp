#pragma once
// Comma-separated text files: columns of numbers, read strictly (a field that is not a number is an error
// with its line), and an Accelerometer that plays back a table of accelerations.
#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/devices.hpp"

namespace shaker::footage {

/// Without blanks at its ends.
std::string_view trimmed(std::string_view text);

/// Named columns of one file: equal length, at least one row.
struct CsvColumns {
    std::filesystem::path file;
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;  // values[column][row]
    /// "file:line", for messages.
    [[nodiscard]] std::string where(std::size_t row) const;
};

/// Reads the columns `names`, in this order, from a file whose first row is a header. Ignored: blanks around
/// fields, quotes around column names, CRLF, a byte order mark, blank lines at the end. Throws InputError
/// with file, line and column when the file is missing or has no rows, a column is missing or duplicate, a
/// row differs from the header in its number of fields, or a field is not a finite number.
CsvColumns read_csv(const std::filesystem::path& file, std::span<const std::string> names);

/// Throws InputError with the line when the first column does not increase from row to row.
void require_increasing(const CsvColumns& table);

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
