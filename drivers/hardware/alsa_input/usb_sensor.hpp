#pragma once
// What the USB name of a digital accelerometer or conditioner states: model, serial number and sensitivity.
#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace shaker::alsa_input {

inline constexpr double standard_gravity = 9.80665;  // m/s^2, of a sensitivity in mV/g

/// Digiducer 333D01 and Modal Shop 485B39 are USB audio devices of 24 bits with two channels. Their name
/// holds (MAN-0343, USB Audio Interface Guide): six characters of the model, one of separation, the format,
/// six of the serial number, the sensitivity of both channels and the date of calibration, yymmdd. Format 1:
/// five digits each, counts per m/s^2. Format 2: seven digits, counts per V. Format 3: seven digits, counts
/// per 50 mV.
struct UsbSensor {
    std::string model, serial, date;
    bool volts = false;                  // full_scale is in V; else m/s^2
    std::array<double, 2> full_scale{};  // of each channel
};

/// Empty where the name has no known model, or not this form.
std::optional<UsbSensor> usb_sensor(std::string_view name);

}  // namespace shaker::alsa_input
