#pragma once
// Records of a sensor held in attitudes, as a CSV file.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "calibration/accelerometer/attitudes.hpp"

namespace shaker::commands {

/// What a tumble calibration is made from.
struct HeldRecords {
    std::string sensor{};                          // its name; empty: not known
    calibration::Vector nominal_mps2_per_count{};  // the scales that it reported; all 0: not known
    std::vector<calibration::Attitude> attitudes{};
};

/// Reads CSV files: "attitude,x,y,z", then a row for each sample: name of the attitude ("+x": this axis
/// points up) or nothing, and counts. Rows in succession with the same attitude are one record. Comments
/// before the header, as held_header() writes them, give the sensor. InputError names file and line.
HeldRecords read_held(std::span<const std::filesystem::path> files);

/// The comments and the header; the rows of one record.
std::string held_header(const HeldRecords& of);
std::string held_rows(const std::string& attitude, std::span<const calibration::Counts> samples);

}  // namespace shaker::commands
