#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include "daemon/acquisition/collector.hpp"
#include "daemon/bench/region_camera.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/recording/recorder.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/report/results.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "daemon/sandbox/session_rights.hpp"
#include "drivers/footage/lab_session.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr double everything = 1e300;

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
    manual::json_argument};

std::string session_text(const std::filesystem::path& file) {
    std::ifstream in{file};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

// Prints the requested drive beside the measured one, if the session contains it.
void compare(const footage::AskedDrive& asked, const reduction::Reduction& r) {
    const auto line = [](const char* name, const std::optional<double>& want, double got, const char* unit) {
        if (want)
            fmt::print("  {:<22}{:>24} {} (requested {:.6g})\n", name, fmt::format("{:.6g}", got), unit,
                       *want);
    };
    fmt::print("measured and requested drive:\n");
    line("gamma", asked.gamma_mps2, r.gamma.value, "m/s^2");
    line("rho", asked.rho, r.rho.value, "");
    line("phi", asked.phi_rad, r.phi.value, "rad");
}

// Reduces a session, records it if `out` has a name, and prints the result.
void reduce_session(const std::filesystem::path& file, const std::filesystem::path& out,
                    recorded::KeptPictures kept, bool json) {
    footage::OpenLabSession session = footage::open_lab_session(file);
    require_reducible(session.description);
    for (const std::string& note : session.notes) spdlog::info("{}", note);
    recorded::RecordingHeader header;
    header.title = session.description.title;
    header.kind = "session";
    header.config = session_text(file);
    header.frequency_hz = session.description.drive->frequency_hz;
    header.dac.rate_hz = 0;
    header.accelerometer = session.rig.accelerometer->info();
    if (kept == recorded::KeptPictures::region && !out.empty()) bench::take_regions(session.rig);
    for (const auto& camera : session.rig.cameras) header.views.push_back(camera->view());
    header.pictures = kept;
    recording::lay_out(header, false);

    recording::Recorder recording{out, header, {.unfinished = recording::Unfinished::discard}};
    acquisition::Collector collector{session.rig, &recording};
    spdlog::info("tracking {} cameras", session.rig.cameras.size());
    read_all(collector);
    const acquisition::Streams& streams = collector.streams();
    reduction::Reduction r = reduce(measurement_of(streams, header.frequency_hz, -everything, everything));
    for (std::string& note : notes_on(streams)) r.notes.push_back(std::move(note));
    recording.finish(streams, r, -everything, everything);
    if (json) {
        std::fputs((report::results_json(r) + "\n").c_str(), stdout);
        return;
    }
    fmt::print("{}: {}\n", file.string(), header.title);
    std::fputs(report::results_text(r).c_str(), stdout);
    compare(*session.description.drive, r);
}

int act_on_reduce(const manual::Values& values) {
    const std::filesystem::path file = values.text("SESSION"), out = values.text("--output");
    const recorded::KeptPictures kept =
        recorded::kept_pictures_named(values.text("--frames")).value_or(recorded::KeptPictures::region);
    const bool json = values.has("--json");
    sandbox::SessionRights rights = sandbox::rights_for_session(file);
    if (rights.status != manual::exit_ok) return rights.status;
    const auto reduced_into = [&](const std::filesystem::path& working) {
        return confined(file.string(), rights.allowed, [&] {
            reduce_session(file, working, kept, json);
            return manual::exit_ok;
        });
    };
    if (out.empty()) return reduced_into({});
    recording::require_new(out);
    sandbox::NewRecording recording{out};
    rights.allowed.files.writes = {recording.folder()};
    const int status = reduced_into(recording.working());
    if (status != manual::exit_ok) return status;
    recording.keep();
    if (!json) report::say("recorded: " + out.string() + "\n");
    return status;
}

}  // namespace

manual::Command reduce_row() {
    return {.name = "reduce",
            .summary = "Reduce a session of footage that shakerd did not record",
            .arguments = reduce_arguments,
            .example = "shakerd reduce session.toml -o session.nxs",
            .exit_statuses = {manual::exit_device},
            .act = act_on_reduce};
}

}  // namespace shaker::commands
