#pragma once
// What a rig file says of an accelerometer behind libiio.
#include <array>
#include <optional>
#include <string>

#include "drivers/settings_table.hpp"

namespace shaker {

/// What the stamps of the samples are good for.
enum class IioStamps {
    host,    // this machine's monotonic clock: they tell when, and what was lost
    device,  // another machine's clock: they tell what was lost; when is told by the arrival
    none,    // there are none, or they are not to be trusted
};

struct IioSettings {
    std::string uri = "local:";  // "local:", "ip:host", "ip:host:port", "usb:1.2.3", "usb:"
    std::string device{};        // id, name, label or serial number; empty: the only one with these channels
    std::array<std::string, 3> channels{"accel_x", "accel_y", "accel_z"};
    std::optional<double> rate_hz{};  // what sampling_frequency is set to; else left as it is
    std::string trigger{};            // its name or id; empty: left as it is
    int buffer_samples = 64;          // that libiio hands over at a time
    int kernel_buffers = 64;          // of that size, before samples are lost: 1 s at 4 kHz
    double timeout_s = 1;             // without data before the connection is built anew
    double give_up_s = 5;             // without data before the device has failed
    IioStamps stamps = IioStamps::host;
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes, or all 0: find it from the motion
    double clock_uncertainty_s = 0.02;
    std::optional<double> range_mps2{};  // beyond it a sample is clipped; else at the ends of the counts
};

/// Reads uri, device, channels, rate_hz, trigger, buffer_samples, kernel_buffers, timeout_s, give_up_s,
/// stamps
/// ("host", "device", "none"; default host for local:, else device), shaker_axis (three numbers or "fit"),
/// clock_uncertainty_s and range_mps2; all may be missing. Other keys are left to the caller, and finish()
/// too. InputError as SettingsTable gives it.
IioSettings read_iio_settings(SettingsTable& table);

}  // namespace shaker
