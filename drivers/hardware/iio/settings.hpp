#pragma once
// Settings of an accelerometer behind libiio in a rig file.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/response/sensor_response.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::iio {

/// Clock of the samples' stamps.
enum class IioStamps {
    host,    // this machine's monotonic clock: stamps show times and losses
    device,  // another machine's clock: stamps show losses; times come from the arrival
    none,    // no stamps, or unreliable ones
};

struct IioSettings {
    std::string uri = "local:";  // "local:", "ip:host", "ip:host:port", "usb:1.2.3", "usb:"
    std::string device{};  // id, name, label or serial number; empty: the only device with these channels
    std::vector<std::string> channels{"accel_x", "accel_y", "accel_z"};  // x; x and y; or all
    std::optional<double> rate_hz{};  // value for sampling_frequency; empty: unchanged
    std::string trigger{};            // name or id; empty: unchanged
    int buffer_samples = 64;          // samples per libiio buffer
    int kernel_buffers = 64;          // buffers before samples are lost: 1 s at 4 kHz
    double timeout_s = 1;             // s without data before the connection is created again
    double give_up_s = 5;             // s without data before the device has failed
    IioStamps stamps = IioStamps::host;
    bool gravity = true;  // as AccelerometerInfo, like the response
    SensorResponse response{};
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes; all 0: derived from the motion
    double clock_uncertainty_s = 0.02;
    std::optional<double> range_mps2{};  // a sample beyond it is clipped; empty: the ends of the counts
};

/// Reads uri, device, channels (one for each axis), gravity, rate_hz, trigger, buffer_samples,
/// kernel_buffers, timeout_s, give_up_s, stamps ("host", "device", "none"; default host for local:, else
/// device), shaker_axis (three numbers or "fit"), clock_uncertainty_s, range_mps2 and those of low_pass_hz;
/// all are optional. Other keys and finish() are left to the caller. InputError as from SettingsTable.
IioSettings read_iio_settings(SettingsTable& table);

}  // namespace shaker::iio
