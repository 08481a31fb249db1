#include "daemon/catalogue/recording_summary.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/catalogue/row_text.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::catalogue {

namespace {

using nlohmann::json;

constexpr const char* remark_prefix = "remark: ";

// Periods in the settings of a recording; 0: not known.
int asked_periods(const std::string& config) try {
    return SettingsTable::from_text(config, "settings").table("run").integer("periods", 0, 1 << 30, 0);
} catch (const InputError&) {
    return 0;
}

std::vector<ResultRow> rows_of(const recorded::RecordingReader& file,
                               const std::vector<recording::RecordedTrip>& trips) {
    std::vector<ResultRow> rows;
    const int periods = asked_periods(file.header().config);
    for (const recording::MeasuredResult& m : recording::read_results(file)) {
        ResultRow& row = rows.emplace_back(
            row_of(m.measurement, m.reduction ? &*m.reduction : nullptr, m.not_reduced, periods));
        row.time = recording::utc_text(m.measurement.time);
    }
    const auto last = recording::read_measurement(file);
    if (trips.empty() || !last || !(trips.back().at_s > last->from_s && trips.back().at_s < last->to_s))
        return rows;
    ResultRow& row = rows.emplace_back(interrupted_row({}, finding(trips.back().trip)));
    row.time = recording::utc_text(recording::time_text_after(file.header().started, trips.back().at_s));
    return rows;
}

std::string outcome_of(const recorded::RecordingReader& file,
                       const std::vector<recording::RecordedTrip>& trips, std::size_t measurements) {
    const std::string count = fmt::format("{} measurement{}", measurements, measurements == 1 ? "" : "s");
    if (!trips.empty()) return count + "; stopped: " + finding(trips.back().trip);
    if (measurements > 0) return count;
    const std::string why = recording::read_not_reduced(file);
    return why.empty() ? count : why;
}

}  // namespace

RecordingSummary summary_of(const recorded::RecordingReader& file, const std::string& name) {
    recording::require_known_schema(file);
    const recorded::RecordingHeader& header = file.header();
    const std::vector<recording::RecordedTrip> trips = recording::read_trips(file);
    RecordingSummary s;
    s.title = header.title;
    s.kind = header.kind;
    s.started = recording::utc_text(header.started);
    s.pictures = recorded::name(header.pictures);
    s.rows = rows_of(file, trips);
    s.measurements = static_cast<std::size_t>(
        std::ranges::count_if(s.rows, [](const ResultRow& r) { return std::isfinite(r.periods); }));
    s.outcome = outcome_of(file, trips, s.measurements);
    if (s.rows.size() > RecordingSummary::most_rows)
        s.rows.erase(s.rows.begin(), s.rows.end() - RecordingSummary::most_rows);
    for (ResultRow& row : s.rows) row.recording = name;
    for (const recording::LogEntry& entry : recording::read_log(file))
        if (entry.text.starts_with(remark_prefix))
            s.remarks.push_back(entry.text.substr(std::string{remark_prefix}.size()));
    if (s.remarks.size() > RecordingSummary::most_remarks)
        s.remarks.erase(s.remarks.begin(), s.remarks.end() - RecordingSummary::most_remarks);
    return s;
}

std::string summary_json(const RecordingSummary& s) {
    json rows = json::array();
    for (const ResultRow& row : s.rows) rows.push_back(json_of(row));
    return json{{"title", s.title},       {"kind", s.kind},       {"started", s.started},
                {"pictures", s.pictures}, {"outcome", s.outcome}, {"measurements", s.measurements},
                {"remarks", s.remarks},   {"results", rows}}
        .dump(-1, ' ', false, json::error_handler_t::replace);
}

RecordingSummary summary_from(const std::string& text) try {
    const json from = json::parse(text);
    RecordingSummary s;
    s.title = text_from(from, "title");
    s.kind = text_from(from, "kind");
    s.started = text_from(from, "started");
    s.pictures = text_from(from, "pictures");
    s.outcome = text_from(from, "outcome");
    const double count = number_from(from, "measurements");
    if (count >= 0 && count < 1e9) s.measurements = static_cast<std::size_t>(count);
    const auto remarks = from.is_object() ? from.find("remarks") : from.end();
    if (remarks != from.end() && remarks->is_array())
        for (const json& remark : *remarks)
            if (s.remarks.size() < RecordingSummary::most_remarks)
                s.remarks.push_back(text_from({{"text", remark}}, "text"));
    const auto rows = from.is_object() ? from.find("results") : from.end();
    if (rows != from.end() && rows->is_array())
        for (const json& row : *rows)
            if (s.rows.size() < RecordingSummary::most_rows) s.rows.push_back(row_from(row));
    return s;
} catch (const json::exception&) {
    throw InputError{"the summary of a recording is not JSON"};
}

}  // namespace shaker::catalogue
