#pragma once
// The finished measurements of a run: "measured" has a row each, its subgroups their results.
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/drive.hpp"

namespace shaker::recording {

/// A measurement whose planned periods were all measured.
struct FinishedMeasurement {
    int number = 0;  // from 1 on, in one run
    Drive asked;     // set-point
    MeasuredPart part;
    std::string time;  // when it was finished: ISO 8601 with offset
};

/// The group "measured" and its subgroups.
std::vector<recorded::GroupLayout> measured_places();
/// A row of "measured", as soon as the measurement is finished.
void write(recorded::RecordingWriter& file, const FinishedMeasurement& finished);
/// In their order; none in a recording of the first version. InputError naming what is wrong in the tables.
std::vector<FinishedMeasurement> read_finished(const recorded::RecordingReader& file);

/// What became of a measurement: its reduction, or why there is none.
struct MeasuredResult {
    FinishedMeasurement measurement;
    std::optional<reduction::Reduction> reduction;
    std::string not_reduced;
};
/// From the raw streams, whose times are settled.
MeasuredResult reduced(const FinishedMeasurement& finished, const acquisition::Streams& streams,
                       double frequency_hz);
/// Rows of the subgroups for one result, behind those that are there.
void append(std::vector<RecordedTable>& tables, const MeasuredResult& result);
/// The result in its subgroups, with its notes.
void write(recorded::RecordingWriter& file, const MeasuredResult& result);
/// Removes all results from a mended file.
void clear_measured(recorded::RecordingWriter& file);

/// The column that names the measurement of a row.
inline constexpr const char* measurement_column = "measurement";

}  // namespace shaker::recording
