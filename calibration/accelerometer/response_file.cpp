#include "calibration/accelerometer/response_file.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <utility>

#include "calibration/accelerometer/read_as.hpp"
#include "calibration/sealed_file.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::calibration {

namespace {

template <class Part>
std::string keys(const std::string& pass, const Part& part) {
    return fmt::format("{0}_hz = {1}\n{0}_error_hz = {2}\n{0}_order = {3}\n", pass, toml_number(part.hz),
                       toml_number(part.error_hz), part.poles) +
           (part.poles == 2 ? fmt::format("{}_damping = {}\n", pass, toml_number(part.damping)) : "");
}

}  // namespace

std::string response_text(const std::string& date, const std::string& sensor, const FittedResponse& fit,
                          const std::vector<std::string>& findings) {
    std::string text = "# Response of an accelerometer. Written by shakerd.\n";
    for (const std::string& finding : findings) text += "# " + finding + "\n";
    text += "date = " + toml_string(date) + "\nsensor = " + toml_string(sensor) + "\n";
    text += keys("high_pass", fit.response.lower);
    if (const LowPass& pass = fit.response.upper; !pass.none())
        text += keys("low_pass", pass);
    else if (pass.above_hz > 0)
        text += "low_pass_above_hz = " + toml_number(pass.above_hz) + "\n";
    std::vector<double> rest;
    for (const ResponseLine& line : fit.rest)
        for (const double x :
             {line.hz, line.log_gain.value, line.log_gain.sigma, line.lead_rad.value, line.lead_rad.sigma})
            rest.push_back(x);
    text += "# Hz; lines minus the response: ln of the amplitude, its error, phase in rad, its error\n";
    text += "residuals = " + toml_list(rest, 5);
    return sealed(text);
}

std::unique_ptr<Accelerometer> with_response(std::unique_ptr<Accelerometer> device,
                                             const std::filesystem::path& file,
                                             std::vector<std::string>& notes) {
    const std::string text = sealed_text(file), name = file.string();
    require_seal(text, name, "response");
    AccelerometerInfo info = device->info();
    if (!info.response.upper.none() ||
        !(info.response.lower.none() || std::isinf(info.response.lower.error_hz)))
        throw InputError{name +
                         ": high_pass_hz or low_pass_hz is set for the accelerometer as well; "
                         "leave them out, or this file"};
    SettingsTable table = SettingsTable::from_text(text, name);
    const std::string date = table.text("date"), sensor = table.text("sensor");
    if (!sensor.empty()) require_sensor(name, sensor, info);
    info.response = read_response(table, info.gravity);
    info.response.file = text;
    notes.push_back(fmt::format("{}: response of {} ({}), {}, {}", info.name, date, name,
                                words(info.response.lower), words(info.response.upper)));
    return read_as(std::move(device), std::move(info));
}

}  // namespace shaker::calibration
