#pragma once
// shakerd run: one run from start to silence.
#include "daemon/run/run_settings.hpp"

namespace shaker::commands {

/// Drives the rig, measures, tracks, reduces and records. Prints the result on standard output. Throws
/// InputError, DeviceError, or TripError when a limit stopped the drive.
void run(const run::RunOptions& options);

}  // namespace shaker::commands
