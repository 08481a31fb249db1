#pragma once
// Tables of a reduction: results, harmonics, transverse, periods, cycle, stick, systematic, bench_check.
#include <map>

#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker::recording {

namespace columns {

inline constexpr const char* error = "standard error";

/// Columns of an Estimate member: its value, and its standard error.
template <auto... Path>
constexpr auto value(const char* name, const char* units, const char* meaning) {
    return number<Path..., &calibration::Estimate::value>(name, units, meaning);
}
template <auto... Path>
constexpr auto errors(const char* name, const char* units, const char* meaning = error) {
    return number<Path..., &calibration::Estimate::sigma>(name, units, meaning);
}

}  // namespace columns

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
/// True for the tables that older files do not have (FORMAT.md).
bool is_later(const RecordedTable& table);
/// Removes those of them that the file lacks.
template <class File>
void keep_known(std::vector<RecordedTable>& tables, const File& file) {
    std::erase_if(tables, [&](const RecordedTable& t) {
        return is_later(t) && !file.has(t.path + "/" + t.columns.back().name);
    });
}
/// Reductions that are stored in tables with the paths of tables_of() below the group `below`, whose column
/// `number` tells which rows belong together; by this number. Without transverse motion, shaker's axis and
/// notes.
std::map<int, reduction::Reduction> read_reductions(const recorded::RecordingReader& file,
                                                    const std::string& below, const char* number);
/// Places of these tables; "results" is the first.
std::vector<recorded::GroupLayout> reduction_places();
/// Writes a reduction with its notes and the part of master time that was reduced.
void write(recorded::RecordingWriter& file, const reduction::Reduction& reduction, const MeasuredPart& part);

}  // namespace shaker::recording
