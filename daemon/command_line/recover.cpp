#include "daemon/command_line/confined_recovery.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::command_line {

namespace {

constexpr std::array arguments{
    manual::Argument{.name = "FILE", .help = "Recording, or its .part", .kind = manual::Kind::file},
    json_argument};

int in_child(const commands::RecoverOptions& options, const sandbox::Confinement& allowed) {
    return confined(options.file.string(), allowed,
                    [&] { return recover(options) ? manual::exit_ok : manual::exit_not_identical; });
}

int act(const manual::Values& values) {
    return recover_confined({.file = values.text("FILE"), .json = values.has("--json")});
}

}  // namespace

int recover_confined(commands::RecoverOptions options) {
    const commands::RecoveredFiles files = recovered_files(options);
    const std::filesystem::path folder = files.file.parent_path();
    sandbox::Confinement allowed = sandbox::confinement_for(options.file);
    const std::filesystem::path pictures = recorded::pictures_folder(files.file);
    allowed.files = {.lists = {folder.empty() ? "." : folder},
                     .reads = {files.file, files.part, files.journal, pictures}};
    const bool finished = std::filesystem::exists(files.file);
    if (finished || !std::filesystem::exists(files.part)) return in_child(options, allowed);
    sandbox::NewRecording fresh{files.file};
    options.working = fresh.working();
    allowed.files.writes = {fresh.folder(), pictures};
    const int status = in_child(options, allowed);
    // The recorder may have finished the file meanwhile: it was only verified.
    if (status == manual::exit_ok && std::filesystem::exists(options.working)) fresh.keep();
    return status;
}

manual::Command recover_row() {
    return {.name = "recover",
            .summary = "Finish a recording after a crash, or verify a finished one",
            .details = "The .part file is not changed. Exit status 4 means that a finished file was changed.",
            .arguments = arguments,
            .example = "shakerd recover run.nxs.part",
            .exit_statuses = {manual::exit_device, manual::exit_not_identical},
            .act = act};
}

}  // namespace shaker::command_line
