#pragma once
// shakerd calibrate: one function a device, and the files that they write.
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/manual/values.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

/// The row of "shakerd calibrate", which acts as calibrate().
manual::Command calibrations_row();
/// Calibrates the device that the values name; the response from given recordings only.
int calibrate(const manual::Values& values);

/// InputError for a given argument that is neither `common` nor of this device by its help.
void refuse_others(std::string_view device, const manual::Values& values,
                   std::initializer_list<std::string_view> common);

/// shakerd calibrate accelerometer: gain matrix and offsets from attitudes at rest. Fits (fit_tumble()),
/// writes the calibration file and prints the results. Files are not overwritten. InputError as from its
/// parts.
void calibrate_accelerometer(const manual::Values& values);

/// shakerd calibrate camera: scale, tilt and lens from pictures of a board (fit_plane()), or the scale from a
/// known length. Writes and prints as above.
void calibrate_camera(const manual::Values& values);

/// shakerd calibrate response: lower corner and low-pass of the accelerometer, from recordings whose cameras
/// see the base, or from a certificate. Writes `file` and prints as above.
void calibrate_response(const manual::Values& values, const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& from);
/// The file that --output names, or that of the day. InputError where it exists.
std::filesystem::path response_file(const manual::Values& values);

/// Words of --axis, in the order of calibration::AxisFrom.
inline constexpr std::array<std::string_view, 3> axis_words{"settings", "board", "slid"};

/// A file that must not exist before; every write reaches the disk's cache at once. InputError, DeviceError.
class NewFile {
public:
    explicit NewFile(std::filesystem::path file) : file_{std::move(file)} {
        if (std::filesystem::exists(file_))
            throw InputError{file_.string() + ": exists and is not overwritten; give another --output"};
    }
    void append(const std::string& text) {
        std::ofstream out{file_, std::ios::binary | std::ios::app};
        out << text << std::flush;
        if (!out) throw DeviceError{file_.string() + ": cannot be written: " + std::strerror(errno)};
    }
    [[nodiscard]] std::string name() const { return file_.string(); }

private:
    std::filesystem::path file_;
};

}  // namespace shaker::commands
