#pragma once
// Footage of other laboratories: movies and a table of accelerations, described by a session.toml.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/footage/csv_accelerometer.hpp"
#include "drivers/view.hpp"

namespace shaker::footage {

/// Requested drive. Only the frequency is used; the rest is compared with the measurement.
struct AskedDrive {
    double frequency_hz = 0;
    std::optional<double> gamma_mps2;
    std::optional<double> rho;
    std::optional<double> phi_rad;
};

struct LabCamera {
    std::filesystem::path file;
    /// Table with a column t_s, one row per frame: middle of its exposure.
    std::optional<std::filesystem::path> times;
    std::optional<double> frame_rate_hz;  // of the exposures; empty: by the stamps or the header of the file
    double first_exposure_s = 0;          // middle of frame 0's exposure; ignored if there is a table `times`
    View view;
};

/// A checked session.toml; relative paths have been resolved against its folder.
struct LabSession {
    std::filesystem::path file;
    std::string title;
    std::optional<AskedDrive> drive;
    std::optional<CsvAccelerometerFile> accelerometer;
    std::vector<LabCamera> cameras;  // at least one, each with at least one target
};

/// Reads a description. Throws InputError with file, line and key: unknown, missing or misspelt keys, values
/// out of range, missing files, duplicate names.
LabSession read_lab_session(const std::filesystem::path& file);

/// Files that a description names: movies or images (as in media_files()) and tables.
struct NamedFiles {
    std::vector<std::filesystem::path> media, tables;
};
NamedFiles named_files(const LabSession& session);

/// Throws InputError that names what is missing for a reduction: the drive's frequency, an accelerometer, a
/// target "walker" and a target "base" in any of the cameras.
void require_reducible(const LabSession& session);

struct OpenLabSession {
    LabSession description;
    Rig rig;                         // no Dac; cameras in the order of the description
    std::vector<std::string> notes;  // properties of the files that the user should know, one sentence each
};

/// Opens all files of a session. Master time is the session's clock. mid_exposure of a frame: its row of
/// `times`, or first_exposure_s + tick / rate. Ticks include missing exposures. Throws InputError with the
/// file, here or in Camera::read, e.g. when `times` and the movie differ in their number of frames.
OpenLabSession open_lab_session(const std::filesystem::path& file);

}  // namespace shaker::footage
