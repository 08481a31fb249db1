#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "calibration/accelerometer/attitudes.hpp"
#include "calibration/accelerometer/sensor_file.hpp"
#include "calibration/accelerometer/tumble.hpp"
#include "daemon/bench/bench.hpp"
#include "daemon/commands/calibrate/calibrate.hpp"
#include "daemon/commands/calibrate/held_records.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/run/stop_signals.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

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

std::string tumble_text(const Tumble& fit) {
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

nlohmann::json tumble_json(const Tumble& fit, const std::string& file) {
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

calibration::Estimate gravity_of(const manual::Values& values) {
    if (values.has("--g") == values.has("--latitude"))
        throw InputError{
            "calibrate accelerometer: the gain follows from the gravity of the place; expected either --g, "
            "for "
            "example 9.8123m/s^2, or --latitude and --height"};
    if (values.has("--g")) return {values.number("--g"), values.number("--g-error")};
    return calibration::normal_gravity(values.number("--latitude"), values.number("--height"));
}

constexpr double hint_after_s = 20, patience_s = 300;
constexpr std::chrono::milliseconds longest_wait{200};

// The scales that the device reports, without the calibration that the rig file names.
calibration::Vector nominal_scales(const AccelerometerInfo& info) {
    if (info.calibration.empty()) return info.mps2_per_count;
    return calibration::parse_calibration(info.calibration, "calibration in force").nominal_mps2_per_count;
}

// Leads an operator through the attitudes: opens the rig and waits until the sensor was held in each of the
// standard attitudes; nothing is driven. An attitude is accepted when the sensor was at rest for the hold
// time (HeldFinder); it gets the name that was asked for. After each, `show` receives a line with its number,
// the condition number and what is missing, and `keep` its samples as rows of a CSV file, after the header.
// InputError when no attitude was held for 5 min.
class LeadAttitudes {
public:
    LeadAttitudes(const manual::Values& values, double gravity,
                  const std::function<void(const std::string&)>& show,
                  const std::function<void(const std::string&)>& keep)
        : bench_{bench::open_bench(values.text("--rig"), values.text("--scene"),
                                   simulated::World::Pace::lockstep)},
          device_{*bench_.rig.accelerometer},
          info_{device_.info()},
          show_{show},
          keep_{keep},
          finder_{info_.rate_hz, values.number("--hold"), nominal_scales(info_), gravity} {
        if (bench_.world && bench_.scene.accelerometer.attitudes.empty())
            throw InputError{
                "--rig sim:: the scene holds the sensor in no attitudes; add `attitudes` to its "
                "[accelerometer]"};
        if (!info_.gravity || info_.axes < 3)
            throw InputError{fmt::format(
                "{}: cannot be calibrated by holding it in attitudes: {}; needed are 3 axes with gravity",
                info_.name,
                info_.gravity ? fmt::format("it measures {} of 3 axes", info_.axes)
                              : "its reading has no gravity")};
        held_.sensor = info_.name;
        held_.nominal_mps2_per_count = nominal_scales(info_);
    }

    HeldRecords run() {
        keep_(held_header(held_));
        show_(fmt::format(
            "turn the sensor and hold it still in each attitude; the present one does not count. {} up\n",
            asked()));
        while (held_.attitudes.size() < standard_attitudes.size()) {
            run::StopSignals::rethrow();
            if (bench_.world) bench_.rig.dac->write(silence_, silence_);
            AccelBlock block;
            while (held_.attitudes.size() < standard_attitudes.size() &&
                   device_.read(block, bench_.world ? std::chrono::milliseconds{0} : longest_wait))
                take(block);
            if (device_.ended()) throw DeviceError{info_.name + ": delivers no more samples"};
        }
        return std::move(held_);
    }

private:
    [[nodiscard]] std::string asked() const {
        return std::string{
            standard_attitudes.at(std::min(held_.attitudes.size(), standard_attitudes.size() - 1))};
    }

    void take(const AccelBlock& block) {
        if (block.quality != Quality::good) finder_.begin_again();
        for (int i = 0; i < block.size; ++i) {
            if (auto attitude = finder_.add(block.counts[static_cast<std::size_t>(i)])) accept(*attitude);
            ++waited_;
        }
        const double waited_s = duration_s(waited_, info_.rate_hz);
        if (waited_s > patience_s)
            throw InputError{fmt::format("attitude {} up: not held within {:.0f} s ({})", asked(), patience_s,
                                         finder_.why_not())};
        if (waited_s < hint_after_s * (hints_ + 1)) return;
        ++hints_;
        show_(fmt::format("waiting for {} up: {}\n", asked(), finder_.why_not()));
    }

    void accept(calibration::Attitude& attitude) {
        attitude.name = asked();
        held_.attitudes.push_back(attitude);
        keep_(held_rows(attitude.name, finder_.record()));
        waited_ = hints_ = 0;
        const auto directions =
            calibration::nominal_directions(held_.attitudes, held_.nominal_mps2_per_count);
        const std::span<const std::string_view> missing =
            std::span{standard_attitudes}.subspan(held_.attitudes.size());
        const std::string_view reads = calibration::nearest_attitude(directions.back());
        show_(fmt::format("{}: held, {} of {}{}; condition number {:.3g}; missing: {}\n", attitude.name,
                          held_.attitudes.size(), standard_attitudes.size(),
                          reads == attitude.name ? "" : fmt::format(", reads as {} up", reads),
                          calibration::condition_of(directions),
                          missing.empty() ? "none" : fmt::format("{}", fmt::join(missing, " "))));
    }

    bench::Bench bench_;
    Accelerometer& device_;
    AccelerometerInfo info_;
    const std::function<void(const std::string&)>&show_, &keep_;
    calibration::HeldFinder finder_;
    HeldRecords held_{};
    std::vector<double> silence_ = std::vector<double>(bench_.rig.dac->info().block_frames);
    std::int64_t waited_ = 0;  // samples since the last attitude
    int hints_ = 0;
};

}  // namespace

void calibrate_accelerometer(const manual::Values& values) {
    const calibration::Estimate gravity = gravity_of(values);
    const std::string output = values.text("--output");
    const std::vector<std::string> from = values.texts("--from");
    const bool json = values.has("--json");
    const std::string date = recording::local_time_text();
    NewFile file{output.empty() ? std::filesystem::path{"accelerometer-" + date.substr(0, 10) + ".toml"}
                                : std::filesystem::path{output}};
    HeldRecords held;
    if (from.empty()) {
        NewFile records{std::filesystem::path{file.name()}.replace_extension(".csv")};
        const auto show = [&](const std::string& line) {
            if (!json) report::say(line);
            std::fflush(stdout);
        };
        const run::StopSignals signals;
        const auto keep = [&](const std::string& rows) { records.append(rows); };
        held = LeadAttitudes{values, gravity.value, show, keep}.run();
    } else {
        held = read_held(std::vector<std::filesystem::path>(from.begin(), from.end()));
    }
    const bool known = held.nominal_mps2_per_count != Vector{};
    const Vector nominal =
        known ? held.nominal_mps2_per_count : calibration::guessed_scales(held.attitudes, gravity.value);
    const Tumble fit = calibration::fit_tumble(held.attitudes, nominal, gravity);
    file.append(calibration::calibration_text({.date = date,
                                               .sensor = held.sensor,
                                               .nominal_mps2_per_count = held.nominal_mps2_per_count,
                                               .fit = fit}));
    if (json) {
        report::say(report::json_text(tumble_json(fit, file.name())) + "\n");
        return;
    }
    report::say(tumble_text(fit));
    report::say(
        fmt::format("written: {0}\nfor the rig file: [accelerometer] calibration = \"{0}\"\n", file.name()));
}

}  // namespace shaker::commands
