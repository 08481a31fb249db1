#pragma once
// Settings of an analog accelerometer on the inputs of a sound card in a rig file.
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/hardware/alsa_input/usb_sensor.hpp"
#include "drivers/response/sensor_response.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::alsa_input {

struct InputSettings {
    std::string pcm;                    // libasound's name, e.g. "hw:CARD=Device,DEV=0"
    std::filesystem::path alsa_config;  // read after the system's configuration; empty: none
    int rate_hz = 48000;
    alsa::SampleFormat format = alsa::SampleFormat::s32;
    int period_frames = 96;
    int buffer_frames = 19200;
    std::vector<int> channels{1};         // 1-based, of each axis: x, x and y, or x, y and z
    std::optional<double> full_scale_V;   // V at the input for full scale
    std::optional<double> mv_per_mps2;    // of the sensor; without it that of the USB name
    double conditioner_gain = 1;          // V at the input over V of the sensor
    std::optional<double> range_mps2;     // largest reading; without it full scale
    int reduce = 12;                      // samples of the card for each of the sensor
    bool gravity = false;                 // as AccelerometerInfo
    SensorResponse response{};            // as AccelerometerInfo
    bool dac_clock = false;               // as AccelerometerInfo
    std::array<double, 3> shaker_axis{};  // as AccelerometerInfo
    double clock_uncertainty_s = 0.02;
    double give_up_s = 5;  // without data, before read() throws

    [[nodiscard]] int axes() const noexcept { return static_cast<int>(channels.size()); }
    [[nodiscard]] double sensor_rate_hz() const noexcept { return static_cast<double>(rate_hz) / reduce; }
    /// Samples of the sensor in a block: 8 ms.
    [[nodiscard]] int block_samples() const noexcept;
    /// m/s^2 at full scale of an axis. `usb`: of the card's name. DeviceError that names the missing key.
    [[nodiscard]] double full_scale_mps2(const std::optional<UsbSensor>& usb, std::size_t axis) const;
};

/// Keys as the members; `sensitivity_mv_per_g` (g: 9.80665 m/s^2) or `sensitivity_mv_per_mps2` for
/// mv_per_mps2. Only `pcm` is required here. Throws InputError.
InputSettings read_input_settings(SettingsTable& table);

}  // namespace shaker::alsa_input
