#include <optional>

#include "daemon/command_line/rows.hpp"
#include "daemon/commands/footage_commands.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;
using sandbox::NewFile;
using sandbox::NewRecording;

constexpr auto footage_frames = std::to_array<std::string_view>({"off", "region", "full"});

constexpr std::array reduce_arguments{
    Argument{
        .name = "SESSION", .help = "session.toml: movies, accelerations and geometry", .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "Recording (HDF5) for \"shakerd replay\"",
             .kind = Kind::file,
             .otherwise = "none"},
    Argument{.name = "--frames",
             .help = "Pictures to record. region: the part that can contain targets",
             .kind = Kind::word,
             .words = footage_frames,
             .standard = "region"},
    json_argument};

constexpr std::array track_arguments{
    Argument{.name = "SESSION",
             .help = "session.toml; drive and accelerometer are not needed",
             .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FILE",
             .help = "CSV with the columns camera,frame,t_s,target,x_px,y_px,sd_px,x_mm,state",
             .kind = Kind::file,
             .otherwise = "a summary only"},
    json_argument};

// Rights to read a session: its files are found in a child that can read nothing but session.toml.
struct SessionRights {
    int status = manual::exit_ok;  // of that child
    sandbox::Confinement allowed{};
};

// Far above the needs of intact footage: 8 GiB of memory plus twice its files; 10 hours for each GiB of it.
SessionRights rights_for(const std::filesystem::path& session) {
    sandbox::Confinement allowed = sandbox::confinement_for(session);
    allowed.files.reads = {session};
    const sandbox::Answer names = sandbox::ask_confined(
        session.string(), allowed, [&] { return commands::read_session_names(session); });
    if (names.status != manual::exit_ok) return {.status = names.status};
    allowed.warns = false;  // the first child did
    const commands::SessionFiles files = commands::session_files(session, names.text);
    allowed.files.lists = files.folders;
    allowed.files.reads = files.files;
    allowed.memory_bytes = (std::uint64_t{8} << 30U) + 2 * files.bytes;
    allowed.processor_s = 36000 * (1 + (files.bytes >> 30U));
    allowed.prepare = commands::load_decoders;
    return {.allowed = std::move(allowed)};
}

int reduce_confined(const commands::ReduceOptions& options, const sandbox::Confinement& allowed) {
    return confined(options.session.string(), allowed, [&] {
        reduce_session(options);
        return manual::exit_ok;
    });
}

int act_reduce(const manual::Values& values) {
    commands::ReduceOptions options{
        .session = values.text("SESSION"), .out = values.text("--output"), .json = values.has("--json")};
    options.pictures = recorded::kept_pictures_named(values.text("--frames")).value_or(options.pictures);
    SessionRights rights = rights_for(options.session);
    if (rights.status != manual::exit_ok) return rights.status;
    if (options.out.empty()) return reduce_confined(options, rights.allowed);
    require_new_recording(options);
    const std::filesystem::path out = options.out;
    NewRecording recording{out};
    options.out = recording.working();
    rights.allowed.files.writes = {recording.folder()};
    const int status = reduce_confined(options, rights.allowed);
    if (status != manual::exit_ok) return status;
    recording.keep();
    if (!options.json) report::say("recorded: " + out.string() + "\n");
    return status;
}

int act_track(const manual::Values& values) {
    commands::TrackOptions options{
        .session = values.text("SESSION"), .out = values.text("--output"), .json = values.has("--json")};
    SessionRights rights = rights_for(options.session);
    if (rights.status != manual::exit_ok) return rights.status;
    std::optional<NewFile> out;
    if (!options.out.empty()) {
        options.csv = out.emplace(options.out).descriptor();
        rights.allowed.keeps = {options.csv};
    }
    return confined(options.session.string(), rights.allowed, [&] {
        track_session(options);
        return manual::exit_ok;
    });
}

}  // namespace

manual::Command reduce_row() {
    return {.name = "reduce",
            .summary = "Reduce a session of footage that shakerd did not record",
            .arguments = reduce_arguments,
            .example = "shakerd reduce session.toml -o session.nxs",
            .exit_statuses = {manual::exit_device},
            .act = act_reduce};
}

manual::Command track_row() {
    return {.name = "track",
            .summary = "Track the targets of a session without reducing it",
            .arguments = track_arguments,
            .example = "shakerd track session.toml -o tracks.csv",
            .exit_statuses = {manual::exit_device},
            .act = act_track};
}

}  // namespace shaker::command_line
