#include "daemon/commands/table.hpp"

#include <array>
#include <cstdio>

#include "daemon/manual/help.hpp"
#include "daemon/manual/parser.hpp"

namespace shaker::commands {

namespace {

// Sections of the manual page that no table describes.
using Item = std::array<std::string_view, 2>;  // a term and its meaning

constexpr std::array file_items{
    Item{"/etc/shakerd/shakerd.toml", "Settings of the daemon as a service."},
    Item{"/var/lib/shakerd", "Recordings of the daemon as a service."},
    Item{"/usr/share/doc/shakerd",
         "README.md and the pages that messages and settings name, such as daemon/safety/LIMITS.md."},
    Item{"RUN.nxs",
         "A recording (HDF5, NeXus). Until it is finished, its name is RUN.nxs.part, with RUN.nxs.journal "
         "beside it; the "
         "pictures are in RUN.frames. After a crash, \"shakerd recover\" finishes it."},
    Item{"trip-TIME.nxs", "The last seconds of a run that a limit stopped and that was not recorded."}};

constexpr std::array signal_items{
    Item{"SIGTERM, SIGINT", "\"serve\" ramps the drive down softly, finishes the recording and exits."},
    Item{"SIGHUP", "\"serve\" reads its settings file again."},
    Item{"SIGKILL",
         "The DAC plays a ramp to zero that is always queued behind the drive. The data so far are in the "
         ".part file."}};

constexpr std::array manual_sections{
    manual::Section{.title = "FILES", .items = file_items},
    manual::Section{.title = "SIGNALS", .items = signal_items},
    manual::Section{.title = "NOTES", .paragraph = "Software is not the emergency stop."},
    manual::Section{.title = "SEE ALSO", .paragraph = "shakerctl(1)"},
};

constexpr std::array common_arguments{manual::help_option, manual::version_option};

int print_manual(const manual::Values& /*values*/) {
    std::fputs(manual::manual_page(program()).c_str(), stdout);
    return manual::exit_ok;
}

manual::Command manual_row() {
    return {.name = "manual", .summary = "Print the manual page, for man -l", .act = print_manual};
}

}  // namespace

const manual::Program& program() {
    static const std::array rows{run_row(),     campaign_row(),  mu_row(),      law_row(),    serve_row(),
                                 check_row(),   calibrate_row(), devices_row(), list_row(),   replay_row(),
                                 recover_row(), export_row(),    report_row(),  reduce_row(), track_row(),
                                 example_row(), predict_row(),   manual_row()};
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

}  // namespace shaker::commands
