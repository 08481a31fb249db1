#include "daemon/command_line/rows.hpp"
#include "daemon/commands/export_command.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array arguments{
    Argument{.name = "FILE",
             .help = "Recording, or points table of a campaign (campaign.nxs)",
             .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FOLDER",
             .help = "Folder of the files; created if it does not exist",
             .kind = Kind::folder,
             .otherwise = "FILE with the ending .export"},
    Argument{.name = "--what",
             .value = "TABLES",
             .help = "Tables, separated by commas: tracks,accelerometer,results,periods,cycle,drive,... or "
                     "all. \"all\" does not include drive, which has every output sample. An unknown word "
                     "lists the tables",
             .kind = Kind::text,
             .standard = "all",
             .many = true,
             .separator = ','},
    json_argument};

int act(const manual::Values& values) {
    const commands::ExportOptions options{.file = values.text("FILE"),
                                          .folder = values.text("--output"),
                                          .what = values.texts("--what"),
                                          .json = values.has("--json")};
    sandbox::Confinement allowed = sandbox::confinement_for(options.file);
    const std::filesystem::path folder = export_folder(options);
    const sandbox::NewFolder made{options.file, folder};
    allowed.files.writes = {std::filesystem::weakly_canonical(folder)};  // the folder may be a link
    return confined(options.file.string(), allowed, [&] {
        export_recording(options);
        return manual::exit_ok;
    });
}

}  // namespace

manual::Command export_row() {
    return {
        .name = "export",
        .summary = "Write the tables of a recording or campaign as CSV files",
        .details =
            "One file per table; existing files are never overwritten. MATLAB (h5read), Octave (load) and "
            "Python (h5py) also read the recording itself.",
        .arguments = arguments,
        .example = "shakerd export run.nxs --what tracks,drive",
        .exit_statuses = {manual::exit_device},
        .act = act};
}

}  // namespace shaker::command_line
