#include "daemon/recording/tables/identification_table.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/reduction_tables.hpp"

namespace shaker::recording {

namespace {

using control::IdentifiedLevel;
using control::IdentifiedResponse;

constexpr const char* response_units = "m/s^2/V";
constexpr const char* group = "identification";
constexpr std::size_t most_levels = 4;  // levels in a recording: the highest ones

// The response at one harmonic.
struct ResponseRow {
    double harmonic = 0, frequency = 0;
    double magnitude = 0, magnitude_sd = 0, phase = 0, phase_sd = 0, coherence = 0, floor = 0;
    double gain_change = 0, phase_change = 0;
};
constexpr std::array response_numbers{
    number<&ResponseRow::harmonic>("harmonic", "1", "harmonic of the drive frequency"),
    number<&ResponseRow::frequency>("frequency", "Hz", "frequency of the harmonic"),
    number<&ResponseRow::magnitude>("magnitude", response_units, "acceleration of the base / drive voltage"),
    number<&ResponseRow::magnitude_sd>("magnitude_errors", response_units, "standard error"),
    number<&ResponseRow::phase>("phase", "rad", "phase of the acceleration relative to the drive"),
    number<&ResponseRow::phase_sd>("phase_errors", "rad", "standard error"),
    number<&ResponseRow::coherence>("coherence", "1", "share of the motion explained by the drive, 0..1"),
    number<&ResponseRow::floor>("noise_floor", "m/s^2", "scatter of the amplitude in one window"),
    number<&ResponseRow::gain_change>("gain_change", "1", "magnitude / magnitude at the lowest level"),
    number<&ResponseRow::phase_change>("phase_change", "rad", "phase minus phase at the lowest level")};
constexpr std::size_t of_changes = 2;  // last columns: changes since the lowest level
constexpr Table<ResponseRow> response_columns{
    "identification/response",
    "response of the base at the highest level",
    response_numbers,
    {},
    {.signal = "magnitude", .axes = "frequency", .title = "acceleration of the base a volt of the drive"}};
constexpr Table<ResponseRow> level_columns{
    "identification/level_",
    "response at one of the four highest levels of the drive, in rising order",
    std::span{response_numbers}.first(response_numbers.size() - of_changes),
    {},
    {.signal = "magnitude", .axes = "frequency", .title = "response at one level"}};

// Single numbers of the whole response and of each level.
struct Facts {
    const IdentifiedResponse& response;
    std::span<const IdentifiedLevel> levels;
};

template <std::size_t Level, double IdentifiedLevel::*Member>
double of_level(const Facts& f) {
    return Level < f.levels.size() ? f.levels[Level].*Member : NAN;
}
template <std::size_t Level>
constexpr auto peak_acceleration(const char* name) {
    return NumberColumn<Facts>{name, "m/s^2", "peak of the motion at this level",
                               of_level<Level, &IdentifiedLevel::peak_mps2>};
}
template <std::size_t Level>
constexpr auto peak_drive(const char* name) {
    return NumberColumn<Facts>{name, "V", "peak of the drive at this level",
                               of_level<Level, &IdentifiedLevel::peak_V>};
}
template <std::size_t Axis>
constexpr auto axis_column(const char* name) {
    return NumberColumn<Facts>{name, "1", "unit vector of the shaker's axis in sensor axes",
                               [](const Facts& f) { return f.response.axis[Axis]; }};
}

constexpr std::array fact_numbers{
    peak_acceleration<0>("level_1_peak_acceleration"),
    peak_drive<0>("level_1_peak_drive"),
    peak_acceleration<1>("level_2_peak_acceleration"),
    peak_drive<1>("level_2_peak_drive"),
    peak_acceleration<2>("level_3_peak_acceleration"),
    peak_drive<2>("level_3_peak_drive"),
    peak_acceleration<3>("level_4_peak_acceleration"),
    peak_drive<3>("level_4_peak_drive"),
    NumberColumn<Facts>{"polarity", "1", "1: correct, -1: a device is connected the wrong way round",
                        [](const Facts& f) { return f.response.polarity_doubtful() ? -1.0 : 1.0; }},
    NumberColumn<Facts>{"turn", "rad", "phase relative to the data sheet at harmonic 1",
                        [](const Facts& f) { return f.response.turn; }},
    NumberColumn<Facts>{"gain", "1", "rms of the response / rms of the data sheet's response",
                        [](const Facts& f) { return f.response.gain; }},
    axis_column<0>("shaker_axis_x"),
    axis_column<1>("shaker_axis_y"),
    axis_column<2>("shaker_axis_z")};
constexpr Table<Facts> fact_columns{
    group, "response of the base to the drive; empty without an identification", fact_numbers};

std::string level_path(std::size_t level) { return fmt::format("{}{}", level_columns.path, level + 1); }
std::string transverse_path() { return fmt::format("{}/{}", group, transverse_columns.path); }

std::vector<ResponseRow> rows_of(const IdentifiedResponse& r, const IdentifiedLevel& level) {
    std::vector<ResponseRow> rows;
    const IdentifiedLevel& low = r.levels.front();
    for (std::size_t i = 0; i < static_cast<std::size_t>(r.harmonics); ++i)
        rows.push_back({.harmonic = static_cast<double>(i + 1),
                        .frequency = static_cast<double>(i + 1) * r.frequency,
                        .magnitude = std::abs(level.h[i]),
                        .magnitude_sd = level.sd[i],
                        .phase = std::arg(level.h[i]),
                        .phase_sd = std::min(level.sd[i] / std::abs(level.h[i]), two_pi / std::sqrt(12.0)),
                        .coherence = level.coherence[i],
                        .floor = level.floor[i],
                        .gain_change = std::abs(level.h[i] / low.h[i]),
                        .phase_change = std::arg(level.h[i] / low.h[i])});
    return rows;
}

}  // namespace

std::vector<recorded::GroupLayout> identification_places() {
    std::vector<recorded::GroupLayout> places{places_of(fact_columns), layout_of(response_columns)};
    for (std::size_t k = 0; k < most_levels; ++k) places.push_back(layout_of(level_columns, level_path(k)));
    places.push_back(layout_of(transverse_columns, transverse_path()));
    return places;
}

void write_identification(recorded::RecordingWriter& file, const control::IdentifiedResponse& r) {
    if (r.levels.empty()) return;
    const std::span<const IdentifiedLevel> all{r.levels}, kept = all.last(std::min(all.size(), most_levels));
    std::vector<RecordedTable> tables{table_of(response_columns, rows_of(r, r.levels.back()))};
    for (std::size_t k = 0; k < kept.size(); ++k)
        tables.push_back(table_of(level_columns, rows_of(r, kept[k]), level_path(k)));
    std::vector<AcrossAt> across;
    for (std::size_t i = 0; i < static_cast<std::size_t>(r.harmonics); ++i)
        across.push_back({static_cast<double>(i + 1) * r.frequency, r.across[i]});
    tables.push_back(table_of(transverse_columns, across, transverse_path()));
    write(file, tables);
    write(file, numbers_of(fact_columns, Facts{r, kept}));
}

}  // namespace shaker::recording
