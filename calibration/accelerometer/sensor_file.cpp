#include "calibration/accelerometer/sensor_file.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/accelerometer/read_as.hpp"
#include "calibration/sealed_file.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::calibration {

namespace {

constexpr double same_scale = 1e-6;  // relative

template <std::size_t N>
std::array<double, N> numbers(SettingsTable& table, std::string_view key) {
    const std::vector<double> read = table.numbers(key, N);
    std::array<double, N> all{};
    std::ranges::copy(read, all.begin());
    return all;
}

// A full scale seen through the new gains: where the first axis of the counts ends.
double range_of(const AccelerometerInfo& device, const Tumble& fit) {
    double range = device.range_mps2;
    for (std::size_t k = 0; k < 3; ++k) {
        const double length = std::hypot(fit.gain[0][k], fit.gain[1][k], fit.gain[2][k]);
        const double shift = std::abs(fit.offset_counts[k] - device.offset_counts[k]);
        const double end = device.range_mps2 / std::abs(device.mps2_per_count[k]) - shift;
        range = std::min(range, length * end);
    }
    return range;
}

}  // namespace

std::string calibration_text(const SensorCalibration& c) {
    const Tumble& f = c.fit;
    std::array<double, 9> gain{};
    for (std::size_t i = 0; i < 9; ++i) gain[i] = f.gain[i / 3][i % 3];
    std::string text =
        "# Tumble calibration of an accelerometer: a = gain (counts + offset), m/s^2. Written by shakerd.\n";
    for (const std::string& finding : f.findings) text += "# " + finding + "\n";
    text += "date = " + toml_string(c.date) + "\nsensor = " + toml_string(c.sensor) + "\n";
    text += "nominal_mps2_per_count = " + toml_list(c.nominal_mps2_per_count, 3);
    text += "gain_mps2_per_count = " + toml_list(gain, 3);
    text += "offset_counts = " + toml_list(f.offset_counts, 3);
    text += "# of E_xx, E_yy, E_zz, E_xy, E_xz, E_yz and b_x, b_y, b_z in g: true a = (I + E) a + b\n";
    text += "covariance = " + toml_list(f.covariance, 9);
    text += "gravity_mps2 = " + toml_number(f.gravity.value) +
            "\ngravity_error_mps2 = " + toml_number(f.gravity.sigma);
    text += fmt::format("\nattitudes = {}\ncondition = {}\nchi2 = {}\ndegrees_of_freedom = {}\n", f.attitudes,
                        toml_number(f.condition), toml_number(f.chi2), f.degrees_of_freedom);
    return sealed(text);
}

SensorCalibration parse_calibration(const std::string& text, const std::string& file) {
    require_seal(text, file, "accelerometer");
    constexpr double any = std::numeric_limits<double>::max();
    SettingsTable table = SettingsTable::from_text(text, file);
    SensorCalibration c{.date = table.text("date"), .sensor = table.text("sensor")};
    c.nominal_mps2_per_count = numbers<3>(table, "nominal_mps2_per_count");
    const auto gain = numbers<9>(table, "gain_mps2_per_count");
    for (std::size_t i = 0; i < 9; ++i) c.fit.gain[i / 3][i % 3] = gain[i];
    c.fit.offset_counts = numbers<3>(table, "offset_counts");
    c.fit.covariance = numbers<81>(table, "covariance");
    c.fit.gravity = {table.number("gravity_mps2", {1, 100}), table.number("gravity_error_mps2", {0, 10})};
    c.fit.attitudes = table.integer("attitudes", 9, 1000000, 0);
    c.fit.condition = table.number("condition", {1, any});
    c.fit.chi2 = table.number("chi2", {0, any});
    c.fit.degrees_of_freedom = table.integer("degrees_of_freedom", 0, 1000000, 0);
    table.text("sha256");
    table.finish();
    return c;
}

CalibrationFile read_calibration(const std::filesystem::path& file) {
    CalibrationFile read{.file = file, .text = sealed_text(file), .content{}};
    read.content = parse_calibration(read.text, file.string());
    return read;
}

AccelerometerInfo calibrated(AccelerometerInfo info, const CalibrationFile& by) {
    const SensorCalibration& c = by.content;
    require_sensor(by.file.string(), c.sensor, info);
    if (info.axes < 3 || !info.gravity)
        throw InputError{
            fmt::format("{}: is the calibration of three axes by gravity; {} is read with {} of them{}: "
                        "remove the key `calibration`",
                        by.file.string(), info.name, info.axes, info.gravity ? "" : ", without gravity")};
    for (std::size_t k = 0; k < 3; ++k) {
        const double then = c.nominal_mps2_per_count[k], now = info.mps2_per_count[k];
        if (then == 0 || std::abs(now / then - 1) < same_scale) continue;
        throw InputError{fmt::format(
            "{}: was made when the {} axis of {} reported {} m/s^2 per count; {} reports {} now: set "
            "the range that "
            "it had, or calibrate again",
            by.file.string(), "xyz"[k], c.sensor, then, info.name, now)};
    }
    info.range_mps2 = range_of(info, c.fit);
    info.offset_counts = c.fit.offset_counts;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            (i == k ? info.mps2_per_count[i] : info.cross_mps2_per_count[i][k]) = c.fit.gain[i][k];
    info.calibration = by.text;
    return info;
}

std::unique_ptr<Accelerometer> with_calibration(std::unique_ptr<Accelerometer> device,
                                                const CalibrationFile& by, std::vector<std::string>& notes) {
    AccelerometerInfo info = calibrated(device->info(), by);
    const SensorCalibration& c = by.content;
    notes.push_back(
        fmt::format("{}: calibration of {} ({}), errors of the gain along x, y, z {:.2g}, {:.2g}, {:.2g} %",
                    info.name, c.date, by.file.string(), 100 * c.fit.gain_error({1, 0, 0}),
                    100 * c.fit.gain_error({0, 1, 0}), 100 * c.fit.gain_error({0, 0, 1})));
    return read_as(std::move(device), std::move(info));
}

}  // namespace shaker::calibration
