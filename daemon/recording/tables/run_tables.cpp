#include "daemon/recording/tables/run_tables.hpp"

#include "daemon/recording/tables/columns.hpp"

namespace shaker::recording {

namespace {

constexpr std::array event_numbers{number<&LogEntry::t_s>("t", "s", "master time")};
constexpr std::array event_texts{
    text<&LogEntry::state>("state", word_bytes, "state of the run"),
    text<&LogEntry::text>("text", sentence_bytes, "one sentence; empty: the run entered this state")};
constexpr Table<LogEntry> event_columns{"events", "course of the run: states, notes, remarks", event_numbers,
                                        event_texts};

constexpr std::array measurement_numbers{number<&MeasuredPart::from_s>("from", "s", "start, master time"),
                                         number<&MeasuredPart::to_s>("to", "s", "planned end, master time")};
constexpr Table<MeasuredPart> measurement_columns{
    "measurements", "started measurements, including interrupted ones", measurement_numbers};

}  // namespace

std::vector<recorded::GroupLayout> run_places() {
    return {layout_of(event_columns), layout_of(measurement_columns)};
}

void write(recorded::RecordingWriter& file, const LogEntry& entry) {
    write_rows(file, event_columns, std::span{&entry, 1});
}

void write(recorded::RecordingWriter& file, const MeasuredPart& part) {
    write_rows(file, measurement_columns, std::span{&part, 1});
}

std::optional<MeasuredPart> read_measurement(const recorded::RecordingReader& file) {
    const std::vector<MeasuredPart> all = read_rows(file, measurement_columns);
    return all.empty() ? std::nullopt : std::optional{all.back()};
}

std::vector<LogEntry> read_log(const recorded::RecordingReader& file) {
    return read_rows(file, event_columns);
}

}  // namespace shaker::recording
