#pragma once
// The raw streams of a recording as tables.
#include "daemon/export_tables.hpp"

namespace shaker {

/// "accelerometer": m/s^2 in sensor axes, counts as they came, on master time: by the stamps and, where the
/// results tell how late the sensor is, corrected by that.
ExportTable accelerometer_table(const SessionReader& file);
/// "drive": each sample given to the DAC, made again from the changes. InputError, when it is read, where the
/// file does not hold all changes.
ExportTable drive_table(const SessionReader& file);
/// "changes": of the drive, with its harmonics.
ExportTable changes_table(const SessionReader& file);
/// "plays": when samples of the drive were heard.
ExportTable plays_table(const SessionReader& file);
/// "frames/<camera>": all stamps; picture 0: none was kept.
ExportTable frames_table(const SessionReader& file, const std::string& camera);

}  // namespace shaker
