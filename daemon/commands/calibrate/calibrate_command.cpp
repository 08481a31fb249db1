#include "daemon/commands/calibrate/calibrate_command.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "calibration/accelerometer/sensor_file.hpp"
#include "daemon/commands/calibrate/held_records.hpp"
#include "daemon/commands/calibrate/led_attitudes.hpp"
#include "daemon/commands/calibrate/new_file.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using calibration::Tumble;
using calibration::Vector;

Vector zero_g(const Tumble& fit) {
    Vector zero{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            zero[i] -= fit.gain[i][k] * fit.offset_counts[k] / fit.gravity.value;
    return zero;
}

Vector gain_errors(const Tumble& fit) {
    return {fit.gain_error({1, 0, 0}), fit.gain_error({0, 1, 0}), fit.gain_error({0, 0, 1})};
}

std::string text_of(const Tumble& fit) {
    std::string text = fmt::format(
        "{} attitudes, g = {:.5f} +- {:.5f} m/s^2: chi2 {:.3g} of {}, condition number {:.3g}, |a| within "
        "{:.2g} mg rms\n"
        "gain matrix, m/s^2 per count, with the error of the gain along the axis; reading without "
        "acceleration:\n",
        fit.attitudes, fit.gravity.value, fit.gravity.sigma, fit.chi2, fit.degrees_of_freedom, fit.condition,
        1e3 * fit.rms_residual / fit.gravity.value);
    const Vector zero = zero_g(fit), errors = gain_errors(fit);
    for (std::size_t i = 0; i < 3; ++i)
        text += fmt::format("  {} {:>14.6e} {:>14.6e} {:>14.6e}  +- {:.4f} %  {:+.3f} +- {:.3f} mg\n",
                            "xyz"[i], fit.gain[i][0], fit.gain[i][1], fit.gain[i][2], 100 * errors[i],
                            1e3 * zero[i], 1e3 * std::sqrt(fit.covariance[10 * (6 + i)]));
    for (const std::string& finding : fit.findings) text += "note: " + finding + "\n";
    return text;
}

nlohmann::json json_of(const Tumble& fit, const std::string& file) {
    return {{"gain_mps2_per_count", fit.gain},
            {"gain_errors_relative", gain_errors(fit)},
            {"offset_counts", fit.offset_counts},
            {"offset_errors_counts", fit.offset_errors()},
            {"gravity_mps2", fit.gravity.value},
            {"gravity_error_mps2", fit.gravity.sigma},
            {"attitudes", fit.attitudes},
            {"condition", fit.condition},
            {"chi2", fit.chi2},
            {"degrees_of_freedom", fit.degrees_of_freedom},
            {"findings", fit.findings},
            {"file", file}};
}

}  // namespace

void calibrate_accelerometer(const CalibrateOptions& options) {
    const std::string date = recording::local_time_text();
    NewFile file{options.output.empty()
                     ? std::filesystem::path{"accelerometer-" + date.substr(0, 10) + ".toml"}
                     : options.output};
    HeldRecords held;
    if (options.from.empty()) {
        NewFile records{std::filesystem::path{file.name()}.replace_extension(".csv")};
        const auto show = [&](const std::string& line) {
            if (!options.json) report::say(line);
            std::fflush(stdout);
        };
        held = lead({options.rig, options.scene, options.gravity.value, options.hold_s}, show,
                    [&](const std::string& rows) { records.append(rows); });
    } else {
        held = read_held(options.from);
    }
    const bool known = held.nominal_mps2_per_count != Vector{};
    const Vector nominal = known ? held.nominal_mps2_per_count
                                 : calibration::guessed_scales(held.attitudes, options.gravity.value);
    const Tumble fit = calibration::fit_tumble(held.attitudes, nominal, options.gravity);
    file.append(calibration::calibration_text({.date = date,
                                               .sensor = held.sensor,
                                               .nominal_mps2_per_count = held.nominal_mps2_per_count,
                                               .fit = fit}));
    if (options.json) {
        report::say(report::json_text(json_of(fit, file.name())) + "\n");
        return;
    }
    report::say(text_of(fit));
    report::say(
        fmt::format("written: {0}\nfor the rig file: [accelerometer] calibration = \"{0}\"\n", file.name()));
}

}  // namespace shaker::commands
