#include "daemon/identification_record.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "daemon/recorder.hpp"
#include "daemon/session_places.hpp"

namespace shaker {

namespace {

constexpr const char* response_units = "m/s^2/V";
constexpr const char* group = "identification/";
constexpr std::size_t most_levels = 4;  // the highest ones, that a recording has places for

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

struct Record {
    std::vector<RecordedTable> tables;
    std::vector<RecordedNumber> numbers;
};

Record record_of(const IdentifiedResponse& r, std::span<const IdentifiedLevel> levels) {
    Record record;
    const IdentifiedLevel &low = r.levels.front(), &high = r.levels.back();
    std::vector<Column> columns = columns_of(r, high);
    columns.push_back({"gain_change", "1",
                       values(r.harmonics, [&](std::size_t i) { return std::abs(high.h[i] / low.h[i]); })});
    columns.push_back({"phase_change", "rad",
                       values(r.harmonics, [&](std::size_t i) { return std::arg(high.h[i] / low.h[i]); })});
    record.tables.push_back({std::string{group} + "response", columns, "NXdata",
                             plot_of("magnitude", "acceleration of the base a volt of the drive")});
    const auto number = [&](const std::string& name, double value, const char* units) {
        record.numbers.push_back({group + name, value, units});
    };
    int k = 0;
    for (const IdentifiedLevel& level : levels) {
        const std::string name = fmt::format("level_{}", ++k);
        record.tables.push_back(
            {group + name, columns_of(r, level), "NXdata", plot_of("magnitude", "response at one level")});
        number(name + "_peak_acceleration", level.peak_mps2, "m/s^2");
        number(name + "_peak_drive", level.peak_V, "V");
    }
    const std::vector<double> frequency =
        values(r.harmonics, [&](std::size_t i) { return static_cast<double>(i + 1) * r.frequency; });
    record.tables.push_back(transverse_table(std::string{group} + "transverse", frequency,
                                             {r.across.begin(), r.across.begin() + r.harmonics}));
    number("polarity", r.polarity_doubtful() ? -1 : 1, "1");
    number("turn", r.turn, "rad");
    number("gain", r.gain, "1");
    for (std::size_t i = 0; i < 3; ++i) number(fmt::format("shaker_axis_{}", "xyz"[i]), r.axis[i], "1");
    return record;
}

}  // namespace

std::vector<GroupLayout> identification_places() {
    IdentifiedResponse empty;
    empty.levels.resize(most_levels);
    const Record record = record_of(empty, empty.levels);
    std::vector<GroupLayout> places;
    places.push_back(layout_of("identification", record.numbers));
    for (const RecordedTable& t : record.tables) places.push_back(layout_of(t));
    return places;
}

void write_identification(SessionWriter& file, const IdentifiedResponse& r) {
    if (r.levels.empty()) return;
    const std::span<const IdentifiedLevel> all{r.levels};
    const Record record = record_of(r, all.last(std::min(all.size(), most_levels)));
    write(file, record.tables);
    write(file, record.numbers);
}

}  // namespace shaker
