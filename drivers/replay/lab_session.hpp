#pragma once
// A session that shakerd did not record: movies and a table of accelerations, described by a session.toml.
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/replay/csv_accelerometer.hpp"
#include "drivers/view.hpp"

namespace shaker {

/// What was asked of the shaker. Only the frequency is used; the rest is compared with what is measured.
struct AskedDrive {
    double frequency_hz = 0;
    std::optional<double> gamma_mps2;
    std::optional<double> rho;
    std::optional<double> phi_rad;
};

struct LabCamera {
    std::filesystem::path file;
    std::optional<std::filesystem::path>
        times;                            // table with a column t_s, one row a frame: middle of its exposure
    std::optional<double> frame_rate_hz;  // of exposures; none: as the file tells
    double first_exposure_s = 0;          // middle of frame 0's exposure; not used when there are times
    View view;
};

/// A session.toml, checked; relative paths in it are resolved against its folder.
struct LabSession {
    std::filesystem::path file;
    std::string title;
    std::optional<AskedDrive> drive;
    std::optional<CsvAccelerometerFile> accelerometer;
    std::vector<LabCamera> cameras;  // at least one, each with at least one target
};

/// Reads a description. Throws InputError naming file, line and key: unknown, missing or misspelt keys,
/// values out of range, files that are not there, names that are there twice.
LabSession read_lab_session(const std::filesystem::path& file);

/// Throws InputError saying what a reduction needs and this session has not: a drive's frequency, an
/// accelerometer, a target "walker" and a target "base" over all cameras.
void require_reducible(const LabSession& session);

struct OpenLabSession {
    LabSession description;
    Rig rig;                         // no Dac; cameras in the order of the description
    std::vector<std::string> notes;  // what the user should know about the files, one sentence each
};

/// Opens all files of a session. Master time is the session's clock; a frame's mid_exposure is its row of
/// `times`, or first_exposure_s + tick / rate. Ticks count exposures that are missing. Throws InputError
/// naming the file, here or in Camera::read, e.g. when times has more or fewer rows than there are frames.
OpenLabSession open_lab_session(const std::filesystem::path& file);

}  // namespace shaker
