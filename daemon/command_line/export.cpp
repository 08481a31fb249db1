#include "daemon/command_line/rows.hpp"
#include "daemon/commands/export_command.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 2> formats{"csv", "mat"};

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
    Argument{.name = "--format",
             .help = "csv: one file per table; mat: one file with one struct per table",
             .kind = Kind::word,
             .words = formats,
             .standard = "csv"},
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
    using Format = commands::ExportOptions::Format;
    const commands::ExportOptions options{
        .file = values.text("FILE"),
        .folder = values.text("--output"),
        .format = values.text("--format") == "mat" ? Format::mat : Format::csv,
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
    return {.name = "export",
            .summary = "Write the tables of a recording or campaign as CSV or MAT files",
            .details = "Existing files are never overwritten.",
            .arguments = arguments,
            .example = "shakerd export run.nxs --what tracks,drive",
            .exit_statuses = {manual::exit_device},
            .act = act};
}

}  // namespace shaker::command_line
