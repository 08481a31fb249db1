#pragma once
// Tables of the finished measurements of a run: "measured" has one row for each, its subgroups the results.
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/drive.hpp"

namespace shaker::recording {

/// A measurement with all its planned periods.
struct FinishedMeasurement {
    int number = 0;  // counts from 1 in each run
    Drive asked;     // set-point
    MeasuredPart part;
    std::string time;  // date and time of its end, ISO 8601 with offset
};

/// Places of the group "measured" and its subgroups.
std::vector<recorded::GroupLayout> measured_places();
/// Writes the measurement's row in "measured".
void write(recorded::RecordingWriter& file, const FinishedMeasurement& finished);
/// The finished measurements in their order; empty for a recording of version 1. InputError names an error in
/// the tables.
std::vector<FinishedMeasurement> read_finished(const recorded::RecordingReader& file);

/// A measurement with its reduction, or the reason why it could not be reduced.
struct MeasuredResult {
    FinishedMeasurement measurement;
    std::optional<reduction::Reduction> reduction;
    std::string not_reduced;
};
/// Reduces a measurement from the raw streams. Their times must be settled.
MeasuredResult reduced(const FinishedMeasurement& finished, const acquisition::Streams& streams,
                       double frequency_hz);
/// The finished measurements with the results that the recording has of them, in their order; see
/// read_reductions(). A recording that was never finished has none.
std::vector<MeasuredResult> read_results(const recorded::RecordingReader& file);
/// Appends the rows of one result to the tables of the subgroups.
void append(std::vector<RecordedTable>& tables, const MeasuredResult& result);
/// Writes the result and its notes to the subgroups.
void write(recorded::RecordingWriter& file, const MeasuredResult& result);
/// Removes all results from a file that is being recovered.
void clear_measured(recorded::RecordingWriter& file);

/// Column with the number of a row's measurement.
inline constexpr const char* measurement_column = "measurement";

}  // namespace shaker::recording
