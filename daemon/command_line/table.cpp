#include "daemon/command_line/table.hpp"

#include <cstdio>

#include "daemon/command_line/manual_sections.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/manual/parser.hpp"

namespace shaker::command_line {

namespace {

constexpr std::array common_arguments{manual::help_option, manual::version_option};

}  // namespace

const manual::Program& program() {
    static const std::array rows{run_row(),       campaign_row(), mu_row(),     serve_row(),  check_row(),
                                 calibrate_row(), devices_row(),  list_row(),   replay_row(), recover_row(),
                                 export_row(),    report_row(),   reduce_row(), track_row(),  example_row(),
                                 predict_row(),   manual_row()};
    static const manual::Program shakerd{
        .name = "shakerd",
        .manual_part = 8,
        .title = "shaker controller and data acquisition for vibration transport",
        .synopsis = "COMMAND [ARGUMENTS]",
        .about =
            "shakerd drives a shaker with gamma [rho sin wt + (1-rho) sin(2wt + phi)], measures the motion "
            "of the "
            "base and of the walker on it, and reports the walker's drift velocity v_D during the "
            "experiment. v_D is the mean of the measured part. Where the walker is still settling, a note "
            "gives "
            "the settled value too.",
        .notation =
            "Quantities carry units: 1.5g, 14.7m/s^2, 35deg, 0.61rad, 20Hz. A bare number is in SI units. g "
            "is "
            "9.8 m/s^2.",
        .commands = rows,
        .common = common_arguments,
        .exit_statuses = manual::exit_meanings,
        .sections = manual_sections};
    return shakerd;
}

int run_command_line(int argc, const char* const* argv) {
    const manual::ParsedLine line = manual::parse(program(), argc, argv);
    if (line.text.empty()) return line.command->act(line.values);
    std::fputs(line.text.c_str(), stdout);
    return manual::exit_ok;
}

}  // namespace shaker::command_line
