#include "daemon/recording/tables/run_tables.hpp"

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

struct Process {
    MeasuredPart reduced;
    double pieces_lost = 0;
    std::string not_reduced, recovered;
};

constexpr auto reduced_from = number<&Process::reduced, &MeasuredPart::from_s>(
    "reduced_from", "s", "start of the part used for the results, master time; NaN: no results");
constexpr auto reduced_to = number<&Process::reduced, &MeasuredPart::to_s>(
    "reduced_to", "s", "end of the part used for the results, master time");
constexpr auto pieces_lost = number<&Process::pieces_lost>(
    "pieces_lost", "1", "pieces of data lost because the disk was too slow; 0 in a complete recording");
constexpr auto not_reduced =
    text<&Process::not_reduced>("not_reduced", sentence_bytes, "reason why there are no results");
constexpr auto recovered = text<&Process::recovered>(
    "recovered", sentence_bytes, "end of the written data, in a recording completed by \"shakerd recover\"");

constexpr std::array process_numbers{reduced_from, reduced_to, pieces_lost};
constexpr std::array process_texts{not_reduced, recovered};
constexpr Table<Process> process_columns{"process", "origin of the results", process_numbers, process_texts};

std::string path_of(const auto& column) { return std::string{process_columns.path} + "/" + column.name; }

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

recorded::GroupLayout process_places() {
    recorded::GroupLayout places = places_of(process_columns);
    places.nx_class = "NXprocess";
    return places;
}

void write_not_reduced(recorded::RecordingWriter& file, const std::string& why) {
    file.text(path_of(not_reduced), why);
}

void write_pieces_lost(recorded::RecordingWriter& file, std::uint64_t pieces) {
    file.scalar(path_of(pieces_lost), static_cast<double>(pieces));
}

void write_recovered(recorded::RecordingWriter& file, const std::string& how) {
    file.text(path_of(recovered), how);
}

void write_reduced_part(recorded::RecordingWriter& file, const MeasuredPart& part) {
    file.scalar(path_of(reduced_from), part.from_s);
    file.scalar(path_of(reduced_to), part.to_s);
}

MeasuredPart read_reduced_part(const recorded::RecordingReader& file) {
    return {file.scalar(path_of(reduced_from)), file.scalar(path_of(reduced_to))};
}

std::string read_not_reduced(const recorded::RecordingReader& file) {
    return file.text(path_of(not_reduced));
}

}  // namespace shaker::recording
