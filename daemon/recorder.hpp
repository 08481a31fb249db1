#pragma once
// What of a run goes into its recording besides the raw streams: tracks, per-period results, results, truth.
#include <map>
#include <string>
#include <vector>

#include "daemon/reduction/reduction.hpp"
#include "daemon/take.hpp"
#include "drivers/replay/session_file.hpp"
#include "drivers/simulated/truth.hpp"

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
    std::map<std::string, std::string> attributes{};
};

/// A reduction as it is stored: what is written and what a replay is held against are the same list.
std::vector<RecordedNumber> numbers_of(const Reduction& reduction);
std::vector<RecordedTable> tables_of(const Reduction& reduction);
/// Motion across the shaker's axis, harmonic by harmonic.
RecordedTable transverse_table(const std::string& path, const std::vector<double>& frequency_hz,
                               const std::vector<Transverse>& across);
/// Every target's track, likewise.
std::vector<RecordedTable> tables_of(const Take& take);
RecordedTable track_table(const TargetTrack& track);
/// One track's row of that table.
std::vector<double> row_of(const Track& track);
/// The tracks' final times, in place of those that were written live.
void write_times(SessionWriter& file, const Take& take);
/// How the clocks ran, as all stamps of a take tell it: of the DAC against the host, of the accelerometer, of
/// each camera: ppm from nominal and mean delay, with errors.
RecordedTable clock_table(const Take& take);
/// Where samples or frames are missing: which stream (0: DAC, 1: accelerometer, 2 and on: cameras), the first
/// index, how many.
RecordedTable gap_table(const Take& take);
/// Where base and walker really were, of a simulated rig.
RecordedTable truth_table(const std::string& camera, const std::vector<PoseTruth>& poses);
/// What became of a camera's frames: produced = stored + dropped (+ not_kept, by the settings).
struct PictureCounts {
    std::uint64_t produced = 0, stored = 0, dropped = 0, not_kept = 0;
};
std::vector<RecordedNumber> picture_numbers(const std::string& camera, const PictureCounts& counts);

/// A reduction with the part of master time it was made from.
void write(SessionWriter& file, const Reduction& reduction, double from_s, double to_s);
void write(SessionWriter& file, const std::vector<RecordedNumber>& numbers);
void write(SessionWriter& file, const std::vector<RecordedTable>& tables);

/// Where the recording's numbers and tables are not, to the bit, the ones given: one sentence each. NaN
/// equals NaN.
std::vector<std::string> differences(const SessionReader& file, const std::vector<RecordedNumber>& numbers,
                                     const std::vector<RecordedTable>& tables);

/// The tracks stored in a recording, in metres by the views of `header`: the recording's own, or with other
/// scales.
void read_tracks(const SessionReader& file, const SessionHeader& header, Take& take);

}  // namespace shaker
