#include "drivers/hardware/alsa_input/usb_sensor.hpp"

#include <algorithm>
#include <charconv>

namespace shaker::alsa_input {

namespace {

constexpr double counts = 8388608;  // of full scale, 24 bits

std::optional<double> number(std::string_view text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value <= 0) return {};
    return value;
}

}  // namespace

std::optional<UsbSensor> usb_sensor(std::string_view name) {
    constexpr std::array<std::string_view, 4> models{"485B", "333D", "633A", "SDC0"};
    std::size_t at = std::string_view::npos;
    for (const std::string_view model : models) at = std::min(at, name.find(model));
    constexpr std::size_t model_size = 6, format_at = 7, serial_at = 8, serial_size = 6, values_at = 14;
    if (at == std::string_view::npos || name.size() < at + values_at) return {};
    name.remove_prefix(at);
    const char format = name[format_at];
    if (format < '1' || format > '3') return {};
    const std::size_t digits = format == '1' ? 5 : 7, date_at = values_at + 2 * digits, date_size = 6;
    if (name.size() < date_at + date_size) return {};
    UsbSensor found{.model = std::string{name.substr(0, model_size)},
                    .serial = std::string{name.substr(serial_at, serial_size)},
                    .date = std::string{name.substr(date_at, date_size)},
                    .volts = format != '1'};
    if (!number(found.date)) return {};
    for (std::size_t k = 0; k < 2; ++k) {
        const auto sensitivity = number(name.substr(values_at + k * digits, digits));
        if (!sensitivity) return {};
        constexpr double fiftieths = 20;  // of 50 mV in 1 V
        found.full_scale.at(k) = counts / (*sensitivity * (format == '3' ? fiftieths : 1));
    }
    return found;
}

}  // namespace shaker::alsa_input
