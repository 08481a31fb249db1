#pragma once
// shakerd run: one run from start to silence.
#include "daemon/manual/values.hpp"
#include "daemon/run/run_settings.hpp"

namespace shaker::commands {

inline constexpr manual::Argument frames_argument{
    .name = "--frames",
    .help =
        "Pictures to record. first-second: those of the first second, then positions only. region: all, of "
        "the part that can contain targets. After a trip, the last 2 s are always kept",
    .kind = manual::Kind::word,
    .words = recorded::kept_pictures_words,
    .standard = "first-second"};

/// The options of "run": the defaults, changed by the settings file, changed by the arguments.
run::RunOptions run_options(const manual::Values& values);

/// Drives the rig, measures, tracks, reduces and records. Prints the result on standard output. Throws
/// InputError, DeviceError, or TripError when a limit stopped the drive.
void run(const run::RunOptions& options);

}  // namespace shaker::commands
