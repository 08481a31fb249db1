#pragma once
// What of a run goes into its recording besides the raw streams: tracks, per-period results, results, truth.
#include <map>
#include <string>
#include <vector>

#include "daemon/reduction/reduction.hpp"
#include "daemon/take.hpp"
#include "drivers/replay/session_file.hpp"

namespace shaker {

/// A number of a recording: its path under /entry, its value, its unit.
struct RecordedNumber {
    std::string path;
    double value;
    std::string units;
};

/// A table of a recording: its path under /entry, NeXus class, columns and attributes.
struct RecordedTable {
    std::string path;
    std::vector<Column> columns;
    std::string nx_class = "NXcollection";
    std::map<std::string, std::string> attributes;
};

/// A reduction as it is stored: what is written and what a replay is held against are the same list.
std::vector<RecordedNumber> numbers_of(const Reduction& reduction);
std::vector<RecordedTable> tables_of(const Reduction& reduction);
/// Motion across the shaker's axis, harmonic by harmonic.
RecordedTable transverse_table(const std::string& path, const std::vector<double>& frequency_hz,
                               const std::vector<Transverse>& across);
/// Every target's track, likewise.
std::vector<RecordedTable> tables_of(const Take& take);

/// A reduction with the part of master time it was made from.
void write(SessionWriter& file, const Reduction& reduction, double from_s, double to_s);
void write(SessionWriter& file, const std::vector<RecordedNumber>& numbers);
void write(SessionWriter& file, const std::vector<RecordedTable>& tables);

/// Where the recording's numbers and tables are not, to the bit, the ones given: one sentence each. NaN
/// equals NaN.
std::vector<std::string> differences(const SessionReader& file, const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables);

/// The tracks stored in a recording, for one whose frames were not kept.
void read_tracks(const SessionReader& file, Take& take);

}  // namespace shaker
