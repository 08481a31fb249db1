#include "daemon/identification_record.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/recorder.hpp"

namespace shaker {

namespace {

constexpr const char* response_units = "m/s^2/V";
constexpr const char* group = "identification/";

std::vector<double> values(int harmonics, auto&& value) {
    std::vector<double> v;
    for (int q = 1; q <= harmonics; ++q) v.push_back(value(static_cast<std::size_t>(q - 1)));
    return v;
}

std::vector<Column> columns_of(const IdentifiedResponse& r, const IdentifiedLevel& level) {
    const auto column = [&](const char* name, const char* units, auto&& value) {
        return Column{name, units, values(r.harmonics, value)};
    };
    return {
        column("harmonic", "1", [](std::size_t i) { return static_cast<double>(i + 1); }),
        column("frequency", "Hz", [&](std::size_t i) { return static_cast<double>(i + 1) * r.frequency; }),
        column("magnitude", response_units, [&](std::size_t i) { return std::abs(level.h[i]); }),
        column("magnitude_errors", response_units, [&](std::size_t i) { return level.sd[i]; }),
        column("phase", "rad", [&](std::size_t i) { return std::arg(level.h[i]); }),
        column("phase_errors", "rad",
               [&](std::size_t i) {
                   return std::min(level.sd[i] / std::abs(level.h[i]), two_pi / std::sqrt(12.0));
               }),
        column("coherence", "1", [&](std::size_t i) { return level.coherence[i]; }),
        column("noise_floor", "m/s^2", [&](std::size_t i) { return level.floor[i]; })};
}

std::map<std::string, std::string> plot_of(const std::string& signal, const std::string& title) {
    return {{"signal", signal}, {"axes", "frequency"}, {"title", title}};
}

void write_levels(SessionWriter& file, const IdentifiedResponse& r) {
    int number = 0;
    for (const IdentifiedLevel& level : r.levels) {
        const std::string path = fmt::format("{}level_{}", group, ++number);
        file.table(path, columns_of(r, level), "NXdata",
                   plot_of("magnitude", fmt::format("response at {:.3g} m/s^2", level.peak_mps2)));
        file.scalar(path + "_peak_acceleration", level.peak_mps2, "m/s^2");
        file.scalar(path + "_peak_drive", level.peak_V, "V");
    }
}

void write_transverse(SessionWriter& file, const IdentifiedResponse& r) {
    const std::vector<double> frequency =
        values(r.harmonics, [&](std::size_t i) { return static_cast<double>(i + 1) * r.frequency; });
    write(file, {transverse_table(std::string{group} + "transverse", frequency,
                                  {r.across.begin(), r.across.begin() + r.harmonics})});
}

}  // namespace

void write_identification(SessionWriter& file, const IdentifiedResponse& r) {
    if (r.levels.empty()) return;
    const IdentifiedLevel &low = r.levels.front(), &high = r.levels.back();
    std::vector<Column> columns = columns_of(r, high);
    columns.push_back({"gain_change", "1",
                       values(r.harmonics, [&](std::size_t i) { return std::abs(high.h[i] / low.h[i]); })});
    columns.push_back({"phase_change", "rad",
                       values(r.harmonics, [&](std::size_t i) { return std::arg(high.h[i] / low.h[i]); })});
    file.table(std::string{group} + "response", columns, "NXdata",
               plot_of("magnitude", "acceleration of the base a volt of the drive"));
    write_levels(file, r);
    write_transverse(file, r);
    const auto number = [&](const std::string& name, double value, const char* units) {
        file.scalar(group + name, value, units);
    };
    number("polarity", r.polarity_doubtful() ? -1 : 1, "1");
    number("turn", r.turn, "rad");
    number("gain", r.gain, "1");
    for (std::size_t k = 0; k < 3; ++k) number(fmt::format("shaker_axis_{}", "xyz"[k]), r.axis[k], "1");
}

}  // namespace shaker
