#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "calibration/accelerometer/response_file.hpp"
#include "daemon/commands/calibrate/calibrate.hpp"
#include "daemon/commands/calibrate/response_source.hpp"
#include "daemon/recording/time_text.hpp"
#include "daemon/report/printing.hpp"

namespace shaker::commands {

namespace {

using calibration::FittedResponse;
using calibration::ResponseLine;
using calibration::words;

double turned_mrad(const SensorResponse& r) {
    constexpr double paper_hz = 20;
    return 1e3 * (phi_turned(r.lower, paper_hz) + phi_turned(r.upper, paper_hz));
}

/// Runs whose lines are off the common response by more than chance.
std::vector<std::string> strangers(const ResponseSource& source, const FittedResponse& fit) {
    constexpr double improbable = 5;  // standard deviations of chi^2
    std::vector<std::string> named;
    if (source.runs.size() < 2) return named;
    for (std::size_t run = 0; run < source.runs.size(); ++run) {
        double chi2 = 0, n = 0;
        for (const ResponseLine& line : fit.rest) {
            if (line.run != static_cast<int>(run)) continue;
            chi2 += std::pow(line.log_gain.value / line.log_gain.sigma, 2) +
                    std::pow(line.lead_rad.value / line.lead_rad.sigma, 2);
            n += 2;
        }
        if (chi2 > n + improbable * std::sqrt(2 * n))
            named.push_back(fmt::format("{} is off the response of the others: chi2 {:.3g} of {:g}",
                                        source.runs[run], chi2, n));
    }
    return named;
}

std::vector<std::string> findings(const ResponseSource& source, const FittedResponse& fit) {
    std::vector<std::string> out{
        fmt::format("{} lines of {} run{}: chi2 {:.4g} of {}", fit.rest.size(), source.runs.size(),
                    source.runs.size() == 1 ? "" : "s", fit.chi2, fit.freedom),
        words(fit.response.lower), words(fit.response.upper)};
    out.push_back(
        fmt::format("phi of a drive of 20 Hz is read off by {:+.3f} mrad", turned_mrad(fit.response)));
    for (const std::vector<std::string>& more : {strangers(source, fit), source.notes})
        for (const std::string& note : more) out.push_back("note: " + note);
    return out;
}

std::string table_of(const FittedResponse& fit) {
    std::string text = "models, by their probability:\n";
    std::vector<calibration::TriedResponse> tried = fit.tried;
    std::ranges::sort(tried, std::greater{}, &calibration::TriedResponse::share);
    for (const calibration::TriedResponse& t : tried)
        if (t.share > 1e-3)
            text +=
                fmt::format("  {:>5.1f} %  chi2 {:<8.4g} phi {:+.3f} mrad  {}, {}\n", 100 * t.share, t.chi2,
                            turned_mrad(t.response), words(t.response.lower), words(t.response.upper));
    text += "lines minus the response: Hz, amplitude in %, phase in mrad\n";
    for (const ResponseLine& line : fit.rest)
        text += fmt::format("  {:>7.2f}  {:+9.4f} +- {:<8.2g} {:+9.3f} +- {:.2g}\n", line.hz,
                            100 * line.log_gain.value, 100 * line.log_gain.sigma, 1e3 * line.lead_rad.value,
                            1e3 * line.lead_rad.sigma);
    return text;
}

nlohmann::json fit_json(const FittedResponse& fit, const ResponseSource& source, const std::string& file) {
    const auto part = [](const auto& p) {
        return nlohmann::json{
            {"hz", p.hz}, {"error_hz", p.error_hz}, {"order", p.poles}, {"damping", p.damping}};
    };
    nlohmann::json json{{"file", file},
                        {"sensor", source.sensor},
                        {"runs", source.runs},
                        {"chi2", fit.chi2},
                        {"degrees_of_freedom", fit.freedom},
                        {"findings", findings(source, fit)},
                        {"lines", nlohmann::json::array()}};
    json["high_pass"] = fit.response.lower.none() ? nlohmann::json{} : part(fit.response.lower);
    json["low_pass"] = fit.response.upper.none() ? nlohmann::json{} : part(fit.response.upper);
    json["low_pass_above_hz"] = {};
    if (fit.response.upper.above_hz > 0) json["low_pass_above_hz"] = fit.response.upper.above_hz;
    for (const ResponseLine& line : fit.rest)
        json["lines"].push_back({{"run", source.runs.at(static_cast<std::size_t>(line.run))},
                                 {"frequency_hz", line.hz},
                                 {"log_gain_residual", line.log_gain.value},
                                 {"log_gain_error", line.log_gain.sigma},
                                 {"phase_residual_rad", line.lead_rad.value},
                                 {"phase_error_rad", line.lead_rad.sigma}});
    return json;
}

}  // namespace

std::filesystem::path response_file(const manual::Values& values) {
    const std::string output = values.text("--output");
    return NewFile{output.empty() ? "response-" + recording::local_time_text().substr(0, 10) + ".toml"
                                  : output}
        .name();
}

void calibrate_response(const manual::Values& values, const std::filesystem::path& output,
                        const std::vector<std::filesystem::path>& from) {
    NewFile file{output};
    ResponseSource source = response_source(from);
    if (values.has("--coupled-dc") && !source.sensor.empty())
        throw InputError{"calibrate response: --coupled-dc is for a certificate; recordings contain it"};
    source.gravity = source.gravity || values.has("--coupled-dc");
    const FittedResponse fit = calibration::fit_response(source.lines, source.gravity);
    constexpr double most_misfit = 10;
    if (fit.chi2 > most_misfit * fit.freedom)
        throw InputError{
            fmt::format("calibrate response: no model describes the lines: chi2 is {:.3g} of {}; is a sign "
                        "wrong, or is one "
                        "run of another sensor? Nothing is written. Nearest: {}, {}",
                        fit.chi2, fit.freedom, words(fit.response.lower), words(fit.response.upper))};
    file.append(
        calibration::response_text(recording::local_time_text(), source.sensor, fit, findings(source, fit)));
    if (values.has("--json")) {
        report::say(report::json_text(fit_json(fit, source, file.name())) + "\n");
        return;
    }
    for (const std::string& finding : findings(source, fit)) report::say(finding + "\n");
    report::say(table_of(fit));
    report::say(
        fmt::format("written: {0}\nfor the rig file: [accelerometer] response = \"{0}\"\n", file.name()));
}

}  // namespace shaker::commands
