#include "daemon/campaign/points_table.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <bit>
#include <set>
#include <utility>

#include "daemon/campaign/combined_passes.hpp"
#include "daemon/campaign/stored_columns.hpp"
#include "daemon/recording/tables/reduction_tables.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/h5/image.hpp"
#include "drivers/recorded/nexus.hpp"

namespace shaker::campaign {

namespace {

using recording::number;
using recording::Table;
using recording::text;
using recording::TextColumn;
using recording::columns::errors;
using recording::columns::value;
using reduction::MeasuredHarmonic;
using reduction::StickInterval;

constexpr int schema_version = 2;  // of 1, v of a cycle may be smoothed across kinks
constexpr const char* kind = "campaign";
constexpr const char* gravity_name = "gravity_mps2";
constexpr const char* of_which = "number of the point";

constexpr std::array point_numbers{
    number<&PointRow::point>("point", "1", "number of the point, in the order of the plan, from 1"),
    number<&PointRow::repeat>("repeat", "1", "repeat of the set-point in its series, from 1"),
    number<&PointRow::partner>("partner", "1", "number of the mirror partner (phi + pi); 0: none"),
    number<&PointRow::asked, &Drive::frequency>("asked_frequency", "Hz", "set-point"),
    number<&PointRow::asked, &Drive::gamma>("asked_gamma", "m/s^2", "set-point"),
    number<&PointRow::asked, &Drive::rho>("asked_rho", "1", "set-point"),
    number<&PointRow::asked, &Drive::phi>("asked_phi", "rad", "set-point"),
    value<&PointRow::v_D>("v_D", "m/s", "drift velocity of the walker, all passes; NaN: not measured"),
    errors<&PointRow::v_D>("v_D_errors", "m/s", "standard error: twice this value covers 95 %"),
    value<&PointRow::D>("D", "m", "drift in one period"),
    errors<&PointRow::D>("D_errors", "m"),
    value<&PointRow::frequency>("frequency", "Hz", "drive frequency on master time"),
    errors<&PointRow::frequency>("frequency_errors", "Hz"),
    value<&PointRow::gamma>("gamma", "m/s^2",
                            "A1 + A2: amplitudes of harmonics 1 and 2 of the base, measured"),
    errors<&PointRow::gamma>("gamma_errors", "m/s^2"),
    value<&PointRow::rho>("rho", "1", "A1 / (A1 + A2), measured"),
    errors<&PointRow::rho>("rho_errors", "1"),
    value<&PointRow::phi>("phi", "rad", "phase of harmonic 2 minus twice that of harmonic 1, measured"),
    errors<&PointRow::phi>("phi_errors", "rad"),
    value<&PointRow::v_rms>("v_rms", "m/s", "rms velocity of the base"),
    errors<&PointRow::v_rms>("v_rms_errors", "m/s"),
    value<&PointRow::efficiency>("efficiency", "1", "|v_D| / v_rms"),
    errors<&PointRow::efficiency>("efficiency_errors", "1"),
    value<&PointRow::tilt>("tilt", "rad",
                           "slope of the shaker's axis by gravity, positive: +x downhill; NaN: not measured"),
    errors<&PointRow::tilt>("tilt_errors", "rad",
                            "standard error; NaN: the sensor's offset is not calibrated"),
    number<&PointRow::phi_systematic>("phi_systematic", "rad",
                                      "standard error of phi by the errors of high_pass_hz and low_pass_hz, "
                                      "common to all points; NaN: neither is set"),
    value<&PointRow::corner>("corner", "Hz",
                             "lower corner of the accelerometer that the results are corrected for, the "
                             "mean of the passes; NaN: none, or not known"),
    errors<&PointRow::corner>("corner_errors", "Hz"),
    number<&PointRow::true_v_D>("true_v_D", "m/s",
                                "true drift velocity over the same periods; NaN: not a simulated bench"),
    number<&PointRow::chi2>(
        "chi2", "1", "scatter of v_D between the passes over its expected value, squared; NaN: one pass"),
    number<&PointRow::periods>("periods", "1", "measured periods, all passes"),
    number<&PointRow::travel_m>("travel", "m", "displacement of the walker in the passes, settling included"),
    number<&PointRow::frames>("frames", "1", "used positions of the walker, all cameras"),
    number<&PointRow::frames_lost>("frames_lost", "1", "frames in which the walker was lost"),
    number<&PointRow::passes>("passes", "1", "passes in the result"),
    number<&PointRow::begun>("begun", "1", "number of times that the point was begun; above 1: tried again"),
    number<&PointRow::measurement>("measurement", "1",
                                   "number of the first pass's measurement in its recording")};
constexpr std::array point_texts{
    text<&PointRow::series>("series", recording::sentence_bytes, "name of the series in the plan"),
    text<&PointRow::outcome>("outcome", recording::word_bytes,
                             "measured, failed, left out, in progress, not begun"),
    text<&PointRow::reason>("reason", recording::sentence_bytes, "reason of an outcome other than measured"),
    text<&PointRow::recording>("recording", recording::sentence_bytes,
                               "recording of the first pass, without .nxs"),
    text<&PointRow::time>("time", recording::word_bytes,
                          "date and time of its end, ISO 8601 with offset from UTC"),
    text<&PointRow::doubt>("doubt", recording::sentence_bytes,
                           "first note that questions its measurements, as an alarm of the bench check")};
constexpr Table<PointRow> point_columns{"points",
                                        "one row for each point of the plan",
                                        point_numbers,
                                        point_texts,
                                        {.signal = "v_D", .axes = "phi"}};

constexpr std::array harmonic_numbers{
    number<&PointHarmonic::point>("point", "1", of_which),
    number<&PointHarmonic::measured, &MeasuredHarmonic::q>("q", "1", "harmonic of the drive frequency"),
    number<&PointHarmonic::asked>("asked_amplitude", "m/s^2", "set-point"),
    number<&PointHarmonic::asked_phase>("asked_phase", "rad", "set-point, relative to sin(q w t)"),
    value<&PointHarmonic::measured, &MeasuredHarmonic::amplitude>("amplitude", "m/s^2",
                                                                  "acceleration of the base along the axis"),
    errors<&PointHarmonic::measured, &MeasuredHarmonic::amplitude>("amplitude_errors", "m/s^2"),
    value<&PointHarmonic::measured, &MeasuredHarmonic::phase>(
        "phase", "rad", "relative to sin(q w t), with t = 0 where harmonic 1 has phase 0"),
    errors<&PointHarmonic::measured, &MeasuredHarmonic::phase>("phase_errors", "rad")};
constexpr Table<PointHarmonic> harmonic_columns{
    "harmonics",
    "motion of the base: a row for each point, a column for each harmonic",
    harmonic_numbers,
    {},
    {.signal = "amplitude", .axes = "q", .title = "harmonics of the base"}};

constexpr std::array phase_numbers{
    number<&PointPhase::point>("point", "1", of_which),
    number<&PointPhase::phase>("phase", "1",
                               "time since the start of the period / length of the period, 0..0.99"),
    number<&PointPhase::x_m>("x", "m", "position of the walker minus its position at phase 0"),
    number<&PointPhase::x_sd_m>("x_errors", "m", recording::columns::error),
    number<&PointPhase::v_mps>("v", "m/s", "velocity of the walker"),
    number<&PointPhase::v_sd_mps>("v_errors", "m/s", recording::columns::error),
    number<&PointPhase::v_base_mps>("v_base", "m/s", "velocity of the base")};
constexpr Table<PointPhase> phase_columns{
    "cycle",
    "motion over one period, averaged over all periods: a row for each point, a column for each phase",
    phase_numbers,
    {},
    {.signal = "v", .axes = "phase", .title = "walker velocity over one period"}};

constexpr std::array stick_numbers{
    number<&PointStick::point>("point", "1", of_which),
    number<&PointStick::pass>("pass", "1", "number of the pass"),
    number<&PointStick::interval, &StickInterval::from>(
        "from", "1", "start of an interval of rest on the base, in periods"),
    number<&PointStick::interval, &StickInterval::to>(
        "to", "1", "end of the interval; above 1 when it continues in the next period"),
    number<&PointStick::interval, &StickInterval::sd>("errors", "1", "standard error of start and end")};
constexpr Table<PointStick> stick_columns{
    "stick", "intervals in which the walker rests on the base, of every pass", stick_numbers};

constexpr std::array pass_numbers{
    number<&PointPass::point>("point", "1", of_which),
    number<&PointPass::pass>("pass", "1", "number of the pass"),
    number<&PointPass::measurement>("measurement", "1", "its number in the recording; 0: none"),
    number<&PointPass::from_s>("from", "s", "start of the measured part, master time of the recording"),
    number<&PointPass::to_s>("to", "s", "end of the measured part"),
    number<&PointPass::periods>("periods", "1", "measured periods"),
    number<&PointPass::x_from_m>("x_from", "m", "position of the walker when the pass was ordered"),
    number<&PointPass::x_to_m>("x_to", "m", "position of the walker at the end of the pass"),
    value<&PointPass::v_D>("v_D", "m/s", "drift velocity of the walker"),
    errors<&PointPass::v_D>("v_D_errors", "m/s"),
    number<&PointPass::true_v_D>("true_v_D", "m/s", "true drift velocity; NaN: not a simulated bench")};
constexpr std::array pass_texts{
    text<&PointPass::recording>("recording", recording::sentence_bytes,
                                "name of the recording, without .nxs"),
    text<&PointPass::how>("how", recording::word_bytes,
                          "complete: all planned periods; early: only some of them; failed: none"),
    text<&PointPass::reason>("reason", recording::sentence_bytes,
                             "why it ended early, failed or has no results")};
constexpr Table<PointPass> pass_columns{
    "passes", "every pass that counts, also of points that are not measured", pass_numbers, pass_texts};

// Calls f(columns, rows, across) for every table. across: rows of one point where this number is the same for
// all points; such a table is stored as a matrix, its first two columns as the axes. Otherwise 0.
template <class Points, class F>
void each_table(Points& t, const F& f) {
    f(point_columns, t.points, std::size_t{0});
    f(harmonic_columns, t.harmonics, std::size_t{max_harmonics});
    f(phase_columns, t.cycle, std::size_t{cycle_phases});
    f(stick_columns, t.stick, std::size_t{0});
    f(pass_columns, t.passes, std::size_t{0});
}

void write_column(hid_t group, const recorded::Column& c, std::size_t index, std::size_t across) {
    std::vector<double> values = c.values;
    std::vector<hsize_t> shape{values.size()};
    if (across > 0 && index > 1) {
        shape = {values.size() / across, across};
    } else if (across > 0) {
        values.clear();
        const std::size_t step = index == 0 ? across : 1, end = index == 0 ? c.values.size() : across;
        for (std::size_t i = 0; i < std::min(end, c.values.size()); i += step) values.push_back(c.values[i]);
        shape = {values.size()};
    }
    h5::write<double>(group, c.name, values, shape, c.units);
}

// The quantity of the set-points that has most values is the axis of the default plot.
std::string scanned(const std::vector<PointRow>& points) {
    std::string most = "phi";
    std::size_t values = 0;
    for (const auto& [name, member] :
         {std::pair{"phi", &Drive::phi}, std::pair{"gamma", &Drive::gamma}, std::pair{"rho", &Drive::rho},
          std::pair{"frequency", &Drive::frequency}}) {
        std::set<double> different;
        for (const PointRow& p : points) different.insert(p.asked.*member);
        if (different.size() > std::exchange(values, std::max(values, different.size()))) most = name;
    }
    return most;
}

void mark_plot(hid_t group, const recording::Table<PointRow>& table, const PointsTable& all) {
    h5::set_attribute(group, "signal", std::string{table.plot.signal});
    recorded::set_plot_attribute(group, "axes", scanned(all.points));
}

template <class Row>
void mark_plot(hid_t group, const Table<Row>& table, const PointsTable&) {
    if (table.plot.signal == nullptr) return;
    h5::set_attribute(group, "signal", std::string{table.plot.signal});
    h5::set_attribute(group, "title", std::string{table.plot.title});
    h5::set_attribute(group, "axes", std::vector<std::string>{"point", table.plot.axes});
    h5::set_attribute(group, "point_indices", std::int64_t{0});
    h5::set_attribute(group, std::string{table.plot.axes} + "_indices", std::int64_t{1});
}

template <class Row>
void write_table(hid_t entry, const Table<Row>& table, const std::vector<Row>& rows, std::size_t across,
                 const PointsTable& all) {
    const h5::Handle group =
        h5::make_group(entry, table.path, table.plot.signal != nullptr ? "NXdata" : "NXcollection");
    mark_plot(group.get(), table, all);
    const recording::RecordedTable numbers = table_of(table, rows);
    for (std::size_t i = 0; i < numbers.columns.size(); ++i)
        write_column(group.get(), numbers.columns[i], i, across);
    for (const TextColumn<Row>& c : table.texts) {
        std::vector<std::string> texts;
        for (const Row& row : rows) texts.push_back(c.get(row));
        h5::write_texts(group.get(), c.name, texts);
    }
}

bool same(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
           (std::isnan(a) && std::isnan(b));
}

template <class Column, class Row>
void compare(const char* table, const Column& column, const std::vector<Row>& stored,
             const std::vector<Row>& now, const auto& equal, std::vector<std::string>& found) {
    for (std::size_t i = 0; i < now.size(); ++i) {
        const auto was = column.get(stored[i]), is = column.get(now[i]);
        if (equal(was, is)) continue;
        found.push_back(
            fmt::format("{}/{} of point {}: stored {}, now {}", table, column.name, now[i].point, was, is));
        return;
    }
}

template <class Row>
exporting::ExportTable export_table(const Table<Row>& table, const std::vector<Row>& rows) {
    std::vector<exporting::ExportColumn> headings, filled;
    const recording::RecordedTable numbers = table_of(table, rows);
    for (const recorded::Column& c : numbers.columns) filled.push_back({c.name, c.units, c.values});
    for (const TextColumn<Row>& c : table.texts) {
        std::vector<std::string> texts;
        for (const Row& row : rows) texts.push_back(c.get(row));
        filled.push_back({c.name, {}, std::move(texts)});
    }
    headings = filled;
    for (exporting::ExportColumn& c : headings) std::visit([](auto& values) { values.clear(); }, c.values);
    return {
        table.path, std::move(headings),
        [filled = std::move(filled), done = false](std::vector<exporting::ExportColumn>& columns) mutable {
            if (std::exchange(done, true)) return false;
            columns = std::move(filled);
            return true;
        }};
}

h5::Handle entry_of(const std::filesystem::path& file, h5::Handle& opened) {
    opened = h5::open_file(file);
    return h5::open_group(opened.get(), "entry");
}

}  // namespace

std::vector<recorded::GroupLayout> point_places() {
    std::vector<recorded::GroupLayout> places;
    const PointsTable none;
    each_table(none,
               [&](const auto& table, const auto&, std::size_t) { places.push_back(layout_of(table)); });
    return places;
}

void write_points(const std::filesystem::path& file, const std::string& title, const std::string& plan,
                  const PointsTable& table) {
    const h5::Image image;
    h5::set_attribute(image.id(), "NX_class", std::string{"NXroot"});
    h5::set_attribute(image.id(), "default", std::string{"entry"});
    h5::set_attribute(image.id(), "creator", std::string{"shakerd"});
    h5::set_attribute(image.id(), "creator_version", std::string{SHAKER_VERSION});
    {
        const h5::Handle entry = h5::make_group(image.id(), "entry", "NXentry");
        h5::set_attribute(entry.get(), "default", std::string{point_columns.path});
        h5::write_text(entry.get(), "title", title);
        const h5::Handle process = h5::make_group(entry.get(), "process", "NXprocess");
        recorded::describe_program(process.get(), plan);
        h5::write_text(process.get(), "version", SHAKER_VERSION);
        h5::write_text(process.get(), "kind", kind);
        h5::set_attribute(process.get(), "schema", std::int64_t{table.smoothed ? 1 : schema_version});
        h5::set_attribute(process.get(), gravity_name, table.gravity);
        each_table(table, [&](const auto& columns, const auto& rows, std::size_t across) {
            write_table(entry.get(), columns, rows, across, table);
        });
    }
    h5::replace_file(file, image.head(image.size()));
}

bool has_points(const std::filesystem::path& file) try {
    h5::Handle opened;
    const h5::Handle entry = entry_of(file, opened);
    return h5::read_text(entry.get(), "process/kind") == kind;
} catch (const InputError&) {
    return false;
}

PointsTable read_points(const std::filesystem::path& file) try {
    h5::Handle opened;
    const h5::Handle entry = entry_of(file, opened);
    const double schema = h5::read_attribute(entry.get(), "process", "schema");
    if (schema > schema_version)
        throw InputError{
            fmt::format("layout version {} is newer than this program, which reads versions up to {}", schema,
                        schema_version)};
    PointsTable table;
    if (h5::has_attribute(entry.get(), "process", gravity_name))  // not in tables of before
        table.gravity = h5::read_attribute(entry.get(), "process", gravity_name);
    if (!(table.gravity > 0 && std::isfinite(table.gravity)))
        throw InputError{
            fmt::format("process/{} is {}; expected m/s^2 above 0", gravity_name, table.gravity)};
    table.smoothed = schema < 2;
    table.before_corners = !h5::exists(entry.get(), "points/corner");
    each_table(table, [&](const auto& columns, auto& rows, std::size_t across) {
        rows = recording::read_rows(StoredColumns{entry.get(), across}, columns);
    });
    return table;
} catch (const InputError& e) {
    throw InputError{fmt::format("{}: {}", file.string(), e.what())};
}

std::vector<std::string> differences(const PointsTable& stored, const PointsTable& now) {
    std::vector<std::string> found;
    const auto missing = [&](std::string_view path, std::string_view column) {
        return stored.before_corners &&
               std::ranges::find(later_columns, fmt::format("{}/{}", path, column)) != later_columns.end();
    };
    if (!same(stored.gravity, now.gravity))
        found.push_back(
            fmt::format("process/{}: stored {}, now {}", gravity_name, stored.gravity, now.gravity));
    each_table(now, [&](const auto& columns, const auto& rows, std::size_t) {
        each_table(stored,
                   [&]<class Row>(const Table<Row>& same_columns, const std::vector<Row>& was, std::size_t) {
                       if constexpr (std::same_as<std::decay_t<decltype(rows)>, std::vector<Row>>) {
                           if (was.size() != rows.size()) {
                               found.push_back(fmt::format("{}: {} rows stored, now {}", same_columns.path,
                                                           was.size(), rows.size()));
                               return;
                           }
                           for (const auto& c : columns.numbers)
                               if (!missing(columns.path, c.name))
                                   compare(columns.path, c, was, rows, same, found);
                           for (const auto& c : columns.texts)
                               if (!missing(columns.path, c.name))
                                   compare(columns.path, c, was, rows, std::equal_to<std::string>{}, found);
                       }
                   });
    });
    return found;
}

std::vector<exporting::ExportTable> export_tables(const PointsTable& table) {
    std::vector<exporting::ExportTable> all;
    each_table(table, [&](const auto& columns, const auto& rows, std::size_t) {
        all.push_back(export_table(columns, rows));
    });
    return all;
}

}  // namespace shaker::campaign
