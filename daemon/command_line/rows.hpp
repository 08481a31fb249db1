#pragma once
// The rows of the table, one file per command, and the arguments that several rows have.
#include <array>

#include "daemon/manual/values.hpp"
#include "daemon/run/run_settings.hpp"

namespace shaker::command_line {

manual::Command run_row();
manual::Command campaign_row();
manual::Command mu_row();
manual::Command serve_row();
manual::Command check_row();
manual::Command calibrate_row();
manual::Command devices_row();
manual::Command list_row();
manual::Command replay_row();
manual::Command recover_row();
manual::Command export_row();
manual::Command report_row();
manual::Command reduce_row();
manual::Command track_row();
manual::Command example_row();
manual::Command predict_row();
manual::Command manual_row();

/// The options of "run": the defaults, changed by the settings file, changed by the arguments.
run::RunOptions run_options(const manual::Values& values);

inline constexpr manual::Argument json_argument{
    .name = "--json", .help = "Print one JSON object; key names carry the SI units"};
inline constexpr manual::Argument scene_argument{.name = "--scene",
                                                 .value = "FILE",
                                                 .help = "TOML file that changes the simulated bench",
                                                 .kind = manual::Kind::file};
inline constexpr manual::Argument rig_argument{
    .name = "--rig",
    .value = "RIG",
    .help = "Rig file (TOML) that names the devices, or sim: for the simulated bench",
    .kind = manual::Kind::file,
    .standard = "sim:"};
inline constexpr manual::Argument recording_argument{
    .name = "FILE", .help = "Recording", .kind = manual::Kind::file};

inline constexpr manual::Argument frames_argument{
    .name = "--frames",
    .help =
        "Pictures to record. first-second: those of the first second, then positions only. region: all, of "
        "the part that can contain targets. After a trip, the last 2 s are always kept",
    .kind = manual::Kind::word,
    .words = recorded::kept_pictures_words,
    .standard = "first-second"};

}  // namespace shaker::command_line
