#include "daemon/recording/tables/measured_tables.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "daemon/recording/tables/reduction_tables.hpp"
#include "drivers/errors.hpp"

namespace shaker::recording {

namespace {

constexpr const char* of_which = "number of the measurement";

using Finished = FinishedMeasurement;
constexpr std::array finished_numbers{
    number<&Finished::number>(measurement_column, "1", "number of the measurement in this recording, from 1"),
    number<&Finished::part, &MeasuredPart::from_s>("from", "s", "start of the first period, master time"),
    number<&Finished::part, &MeasuredPart::to_s>("to", "s", "end of the last period, master time"),
    number<&Finished::asked, &Drive::gamma>("asked_gamma", "m/s^2", "set-point"),
    number<&Finished::asked, &Drive::rho>("asked_rho", "1", "set-point"),
    number<&Finished::asked, &Drive::phi>("asked_phi", "rad", "set-point"),
    number<&Finished::asked, &Drive::frequency>("asked_frequency", "Hz", "set-point")};
constexpr std::array finished_texts{
    text<&Finished::time>("time", word_bytes, "date and time of its end, ISO 8601 with offset from UTC")};
constexpr Table<Finished> finished_columns{
    "measured", "finished measurements; each row is written when its measurement is finished",
    finished_numbers, finished_texts};

struct Overtone {
    int measurement = 0, q = 0;
    double re = 0, im = 0;
};
constexpr std::array overtone_numbers{
    number<&Overtone::measurement>(measurement_column, "1", of_which),
    number<&Overtone::q>("q", "1", "harmonic of the drive frequency, 3 and above"),
    number<&Overtone::re>("asked_re", "1", "set-point: real part of the overtone's share of gamma"),
    number<&Overtone::im>("asked_im", "1", "set-point: imaginary part of the overtone's share of gamma")};
constexpr Table<Overtone> overtone_columns{
    "measured/overtones", "overtones of the set-points; no rows for set-points without overtones",
    overtone_numbers};

struct MeasuredNote {
    int measurement = 0;
    std::string text;
};
constexpr std::array measured_note_numbers{
    number<&MeasuredNote::measurement>(measurement_column, "1", of_which)};
constexpr std::array measured_note_texts{text<&MeasuredNote::text>(
    "text", sentence_bytes, "one sentence on the results, or the reason why there are no results")};
constexpr Table<MeasuredNote> measured_note_columns{"measured/notes", "remarks on the results",
                                                    measured_note_numbers, measured_note_texts};

constexpr int first_overtone = 3;

std::string below_measured(const std::string& path) {
    return std::string{finished_columns.path} + "/" + path;
}

// Rows of one measurement, with its number as the first column.
RecordedTable numbered(RecordedTable table, int measurement) {
    const std::size_t rows = table.columns.front().values.size();
    table.path = below_measured(table.path);
    table.columns.insert(table.columns.begin(),
                         {measurement_column, "1", std::vector<double>(rows, measurement)});
    return table;
}

// The single numbers of a reduction as one row.
RecordedTable result_row(const reduction::Reduction& reduction) {
    RecordedTable row{"results", {}};
    for (const RecordedNumber& n : numbers_of(reduction))
        row.columns.push_back({n.path.substr(row.path.size() + 1), n.units, {n.value}});
    return row;
}

}  // namespace

std::vector<recorded::GroupLayout> measured_places() {
    std::vector<recorded::GroupLayout> places{layout_of(finished_columns), layout_of(overtone_columns)};
    for (recorded::GroupLayout g : reduction_places()) {
        g.meaning = fmt::format("group \"{}\" of every finished measurement", g.path);
        g.path = below_measured(g.path);
        g.nx_class = "NXcollection";
        g.attributes.clear();
        for (recorded::Place& p : g.places) p.kind = recorded::Place::Kind::numbers;
        recorded::Place number{measurement_column, "1"};
        number.meaning = of_which;
        g.places.insert(g.places.begin(), number);
        places.push_back(std::move(g));
    }
    recorded::GroupLayout& results = places[2];
    results.nx_class = "NXdata";
    results.attributes = {
        {"signal", "v_D"}, {"axes", "phi"}, {"title", "drift velocity of every finished measurement"}};
    places.push_back(layout_of(measured_note_columns));
    return places;
}

void write(recorded::RecordingWriter& file, const FinishedMeasurement& finished) {
    write_rows(file, finished_columns, std::span{&finished, 1});
    std::vector<Overtone> overtones;
    for (std::size_t i = 0; i < finished.asked.overtones.size(); ++i)
        if (const std::complex<double> share = finished.asked.overtones[i]; share != 0.0)
            overtones.push_back(
                {finished.number, first_overtone + static_cast<int>(i), share.real(), share.imag()});
    write_rows(file, overtone_columns, overtones);
}

std::vector<FinishedMeasurement> read_finished(const recorded::RecordingReader& file) {
    if (!file.has(finished_columns.path)) return {};
    std::vector<FinishedMeasurement> all = read_rows(file, finished_columns);
    for (const Overtone& o : read_rows(file, overtone_columns)) {
        const auto of = std::ranges::find(all, o.measurement, &FinishedMeasurement::number);
        const std::int64_t i = std::int64_t{o.q} - first_overtone;
        if (of == all.end() || i < 0 || i >= std::ssize(of->asked.overtones))
            throw InputError{
                fmt::format("recording: {} has harmonic {} of measurement {}, which does not exist",
                            overtone_columns.path, o.q, o.measurement)};
        of->asked.overtones[static_cast<std::size_t>(i)] = {o.re, o.im};
    }
    return all;
}

MeasuredResult reduced(const FinishedMeasurement& finished, const acquisition::Streams& streams,
                       double frequency_hz) try {
    if (!streams.played.empty() &&
        static_cast<double>(streams.played.back().tick.n) < finished.part.to_s * streams.dac_rate_hz)
        return {finished, std::nullopt, "the recording ends before its last period"};
    return {finished,
            reduce(measurement_of(streams, frequency_hz, finished.part.from_s, finished.part.to_s)),
            {}};
} catch (const InputError& e) {
    return {finished, std::nullopt, e.what()};
}

std::vector<MeasuredResult> read_results(const recorded::RecordingReader& file) {
    std::vector<MeasuredResult> all;
    const std::vector<FinishedMeasurement> finished = read_finished(file);
    if (finished.empty()) return all;
    std::map<int, reduction::Reduction> reductions =
        read_reductions(file, finished_columns.path, measurement_column);
    const std::vector<MeasuredNote> notes = read_rows(file, measured_note_columns);
    for (const FinishedMeasurement& m : finished) {
        MeasuredResult& result = all.emplace_back(MeasuredResult{m, std::nullopt, {}});
        if (const auto found = reductions.find(m.number); found != reductions.end()) {
            result.reduction = std::move(found->second);
            for (const MeasuredNote& note : notes)
                if (note.measurement == m.number) result.reduction->notes.push_back(note.text);
            set_doubts(*result.reduction);
        } else {
            const auto note = std::ranges::find(notes, m.number, &MeasuredNote::measurement);
            result.not_reduced = note == notes.end() ? "it has no results" : note->text;
        }
    }
    return all;
}

void append(std::vector<RecordedTable>& tables, const MeasuredResult& result) {
    if (!result.reduction) return;
    std::vector<RecordedTable> rows = tables_of(*result.reduction);
    rows.insert(rows.begin(), result_row(*result.reduction));
    for (RecordedTable& from : rows) {
        from = numbered(std::move(from), result.measurement.number);
        const auto to = std::ranges::find(tables, from.path, &RecordedTable::path);
        if (to == tables.end()) {
            tables.push_back(std::move(from));
            continue;
        }
        for (std::size_t i = 0; i < from.columns.size(); ++i)
            std::ranges::copy(from.columns[i].values, std::back_inserter(to->columns[i].values));
    }
}

void write(recorded::RecordingWriter& file, const MeasuredResult& result) {
    std::vector<RecordedTable> tables;
    append(tables, result);
    keep_known(tables, file);
    write(file, tables);
    std::vector<MeasuredNote> notes;
    if (result.reduction)
        for (const std::string& note : result.reduction->notes)
            notes.push_back({result.measurement.number, note});
    else
        notes.push_back({result.measurement.number, "not reduced: " + result.not_reduced});
    write_rows(file, measured_note_columns, notes);
}

void clear_measured(recorded::RecordingWriter& file) {
    for (const recorded::GroupLayout& g : measured_places())
        if (g.path != finished_columns.path && g.path != overtone_columns.path) file.clear(g.path);
}

}  // namespace shaker::recording
