#pragma once
// The raw streams of a recording as tables.
#include "daemon/export/tables.hpp"

namespace shaker::exporting {

/// "accelerometer": m/s^2 in the axes of the sensor and raw counts, on master time. Times come from the
/// stamps, corrected by the delay of the sensor if the results contain it.
ExportTable accelerometer_table(const recorded::RecordingReader& file);
/// "drive": each sample given to the DAC, recomputed from the changes. Reading throws InputError if the file
/// does not contain all changes.
ExportTable drive_table(const recorded::RecordingReader& file);
/// "changes": all changes of the drive, with harmonics.
ExportTable changes_table(const recorded::RecordingReader& file);
/// "plays": times at which samples of the drive were played.
ExportTable plays_table(const recorded::RecordingReader& file);
/// "frames/<camera>": all stamps; picture 0: no picture was kept.
ExportTable frames_table(const recorded::RecordingReader& file, const std::string& camera);

}  // namespace shaker::exporting
