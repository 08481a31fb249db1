#pragma once
// The calibration file of an accelerometer: TOML with a checksum, named by rig files and kept by recordings.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "calibration/accelerometer/tumble.hpp"
#include "drivers/devices.hpp"

namespace shaker::calibration {

struct SensorCalibration {
    std::string date;                 // ISO 8601
    std::string sensor;               // its name when it was calibrated
    Vector nominal_mps2_per_count{};  // scales that the device reported then; all 0: not known
    Tumble fit{};
};

/// The content of a file; its last line is the SHA-256 of the lines above.
std::string calibration_text(const SensorCalibration& calibration);

/// InputError names the file, and states when it was changed after it was written.
SensorCalibration parse_calibration(const std::string& text, const std::string& file);

struct CalibrationFile {
    std::filesystem::path file;
    std::string text;
    SensorCalibration content;
};
/// InputError as from parse_calibration(), and for a file that cannot be read.
CalibrationFile read_calibration(const std::filesystem::path& file);

/// How the sensor with this `info` is to be read. InputError for a file of another sensor, and when its
/// scales are not those that it had when it was calibrated: its range was changed since.
AccelerometerInfo calibrated(AccelerometerInfo info, const CalibrationFile& by);

/// The same device with the gains and offsets of a calibration file in its info(). `notes` receives one
/// sentence: the file, its date and the errors of its gains. InputError as from calibrated().
std::unique_ptr<Accelerometer> with_calibration(std::unique_ptr<Accelerometer> device,
                                                const CalibrationFile& by, std::vector<std::string>& notes);

}  // namespace shaker::calibration
