#pragma once
// Tables of a reduction: results, harmonics, transverse, periods, cycle, stick.
#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker::recording {

/// A sentence about a recording's results.
struct Note {
    std::string text;
};
extern const Table<Note> note_columns;

/// Motion across the shaker's axis at one frequency.
struct AcrossAt {
    double frequency_hz = 0;
    calibration::Transverse across;
};
extern const Table<AcrossAt> transverse_columns;

/// Numbers and tables of a reduction, for writing and for comparison with a replay.
std::vector<RecordedNumber> numbers_of(const reduction::Reduction& reduction);
std::vector<RecordedTable> tables_of(const reduction::Reduction& reduction);
/// Places of these tables; "results" is the first.
std::vector<recorded::GroupLayout> reduction_places();
/// Writes a reduction with its notes and the part of master time that was reduced.
void write(recorded::RecordingWriter& file, const reduction::Reduction& reduction, const MeasuredPart& part);

}  // namespace shaker::recording
