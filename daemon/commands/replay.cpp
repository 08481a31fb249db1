#include "daemon/commands/replay.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/recording/replay.hpp"
#include "daemon/recording/tables/differences.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/tables/reduction_tables.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "daemon/report/results.hpp"
#include "daemon/run/ended_run.hpp"
#include "daemon/sandbox/confined.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 3> replay_sources{"best", "raw", "tracks"};

constexpr std::array replay_arguments{
    Argument{.name = "FILE", .help = "Recording", .kind = Kind::file},
    Argument{.name = "--from",
             .help = "Source. raw: the pictures; tracks: the stored positions; best: raw if every picture "
                     "was kept and "
                     "this version follows targets as the one that recorded the file",
             .kind = Kind::word,
             .words = replay_sources,
             .standard = "best"},
    Argument{.name = "--set",
             .value = "KEY=VALUE",
             .help = "Reduce with this setting and print the changes, e.g. top.mm_per_px=0.1 or from_s=3.5; "
                     "an unknown "
                     "key lists all keys",
             .kind = Kind::text,
             .many = true},
    manual::json_argument};

// True when the tracks are to be computed from the pictures.
bool from_pictures(const recorded::RecordingReader& file, ReplayOptions::From from) {
    if (from == ReplayOptions::From::best) return recording::why_not_followed_again(file).empty();
    const std::string why = recording::why_not_from_pictures(file);
    if (from == ReplayOptions::From::raw && !why.empty())
        throw InputError{fmt::format("{}: --from raw is not possible: {}", file.file().string(), why)};
    return from == ReplayOptions::From::raw;
}

// The results computed again, for printing and for comparison with the recording.
struct Recomputed {
    std::vector<recording::RecordedTable> streams;
    std::vector<recording::RecordedNumber> numbers;
    std::vector<recording::RecordedTable> tables;

    [[nodiscard]] std::size_t values() const {
        std::size_t sum = numbers.size();
        for (const auto* some : {&streams, &tables})
            for (const recording::RecordedTable& t : *some)
                for (const recorded::Column& c : t.columns) sum += c.values.size();
        return sum;
    }
};

void add_reduction(const recording::ReplayOverrides& as, const acquisition::Streams& streams,
                   const std::vector<recording::RecordedTrip>& trips, bool whole,
                   std::vector<std::string> notes, bool json, Recomputed& out) {
    reduction::Reduction reduction =
        reduce(measurement_of(streams, as.header.frequency_hz, as.from_s, as.to_s));
    std::ranges::move(notes, std::back_inserter(reduction.notes));
    if (!trips.empty() && !whole)
        reduction.notes.push_back(
            run::stopped_note("a limit", (as.to_s - as.from_s) * as.header.frequency_hz));
    std::fputs(
        (json ? report::results_json(reduction, {}, {}, trips) + "\n" : report::results_text(reduction))
            .c_str(),
        stdout);
    out.numbers = recording::numbers_of(reduction);
    for (recording::RecordedTable& t : recording::tables_of(reduction)) out.tables.push_back(std::move(t));
}

// Computes every finished measurement again; prints a line for each when there are several.
void add_measurements(const std::vector<recording::FinishedMeasurement>& finished,
                      const recording::ReplayOverrides& as, const acquisition::Streams& streams, bool json,
                      Recomputed& out) {
    const bool several = finished.size() > 1 && !json;
    if (several) fmt::print("{} measurements:\n", finished.size());
    for (const recording::FinishedMeasurement& m : finished) {
        const recording::MeasuredResult now = recording::reduced(m, streams, as.header.frequency_hz);
        recording::append(out.tables, now);
        if (!several) continue;
        fmt::print("  {:<4} set-point gamma {:.4g} m/s^2, phi {:.4g} rad, rho {:.4g}: ", m.number,
                   m.asked.gamma, m.asked.phi, m.asked.rho);
        if (now.reduction)
            fmt::print("v_D {:.4f} +- {:.4f} mm/s\n", 1e3 * now.reduction->v_D.value,
                       1e3 * now.reduction->v_D.sigma);
        else
            fmt::print("not reduced: {}\n", now.not_reduced);
    }
}

// Prints the changes of the results by other settings.
void print_changes(const recorded::RecordingReader& file, const Recomputed& now) {
    fmt::print("with other settings than recorded:\n");
    std::size_t changed = 0;
    for (const recording::RecordedNumber& n : now.numbers) {
        const double was = file.scalar(n.path);
        if (was == n.value || (std::isnan(was) && std::isnan(n.value))) continue;
        ++changed;
        fmt::print("  {:<32}{:>16.8g} -> {:<16.8g} {}\n", n.path, was, n.value, n.units);
    }
    fmt::print("{} of {} numbers changed\n", changed, now.numbers.size());
}

// What this version computes as the one that recorded the file must be equal to the bit. `moved`: targets
// that this version follows otherwise.
bool print_differences(const recorded::RecordingReader& file, const Recomputed& now,
                       const std::vector<std::string>& moved, bool json) {
    std::vector<std::string> found, results = differences(file, now.numbers, now.tables);
    if (moved.empty()) found = differences(file, {}, now.streams);
    const bool earlier = !moved.empty() || file.header().schema < recording::results_since;
    if (!earlier) found.insert(found.end(), results.begin(), results.end());
    const auto tell = [json](const std::string& text) {
        if (json)
            spdlog::info("{}", text);
        else
            fmt::print("{}\n", text);
    };
    if (!found.empty()) {
        for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 20); ++i)
            spdlog::warn("differs: {}", found[i]);
        if (!json) fmt::print("replay: NOT identical, {} differences\n", found.size());
        return false;
    }
    if (results.empty() && moved.empty()) {
        tell(fmt::format("replay: identical ({} numbers, to the bit)", now.values()));
        return true;
    }
    for (const std::string& text : moved) tell("replay: track moved, " + text);
    tell(fmt::format(
        "replay: the streams are {}; {} results differ, because this program {} otherwise than the "
        "one that recorded the file (daemon/recording/FORMAT.md, versions):",
        moved.empty() ? "identical to the bit" : "followed again", results.size(),
        moved.empty() ? "reduces" : "follows targets"));
    for (const std::string& text : results) tell("  " + text);
    return true;
}

}  // namespace

bool replay(const ReplayOptions& options) {
    const recorded::RecordingReader file{options.file};
    recording::require_known_schema(file);
    for (const std::string& what : file.damage()) spdlog::warn("the recording is damaged: {}", what);
    const recording::ReplayOverrides as = recording::replay_settings(file, options.set);
    if (as.changed && std::isfinite(as.from_s) && !(as.from_s >= 0 && as.from_s < as.to_s))
        throw InputError{
            fmt::format("--set from_s={:.6g}: expected 0 to {:.6g} s, which is to_s, the end of the "
                        "measurement",
                        as.from_s, as.to_s)};
    const std::vector<recording::RecordedTrip> trips = recording::read_trips(file);
    if (!options.json)
        for (const recording::RecordedTrip& trip : trips)
            fmt::print("a limit stopped this run {}\n", text(trip));
    const bool pictures = from_pictures(file, options.from);
    spdlog::info("replaying \"{}\" from {}", as.header.title,
                 pictures ? "frames and counts" : "tracks and counts");
    std::vector<std::string> notes;
    const acquisition::Streams streams = recording::replayed_streams(file, as.header, pictures, notes);
    Recomputed now{.streams = recording::tables_of(streams), .numbers = {}, .tables = {}};
    const std::vector<recording::FinishedMeasurement> finished = recording::read_finished(file);
    if (std::isfinite(as.from_s)) {
        const bool whole = std::ranges::any_of(finished, [&](const recording::FinishedMeasurement& m) {
            return m.part == recording::MeasuredPart{as.from_s, as.to_s};
        });
        add_reduction(as, streams, trips, whole, std::move(notes), options.json, now);
    } else {
        const std::string why = recording::read_not_reduced(file);
        if (options.json)
            std::fputs((report::trips_json(trips, why) + "\n").c_str(), stdout);
        else
            fmt::print("no results: {}\n", why);
    }
    add_measurements(finished, as, streams, options.json, now);
    recording::keep_known(now.tables, file);
    const bool otherwise = pictures && file.header().schema < recording::tracks_since;
    const std::vector<std::string> moved =
        otherwise ? recording::track_changes(file, streams) : std::vector<std::string>{};
    if (!as.changed) return print_differences(file, now, moved, options.json);
    if (!options.json) print_changes(file, now);
    return true;
}

namespace {

int act_on_replay(const manual::Values& values) {
    using From = ReplayOptions::From;
    const std::string from = values.text("--from");
    const ReplayOptions options{.file = values.text("FILE"),
                                .from = from == "raw"      ? From::raw
                                        : from == "tracks" ? From::tracks
                                                           : From::best,
                                .set = values.texts("--set"),
                                .json = values.has("--json")};
    return sandbox::confined(options.file.string(), sandbox::confinement_for(options.file),
                             [&] { return replay(options) ? manual::exit_ok : manual::exit_not_identical; });
}

}  // namespace

manual::Command replay_row() {
    return {
        .name = "replay",
        .summary = "Recompute a recording's results from its raw streams",
        .details =
            "Exit status 4 means that at least one number differs in at least one bit from the recorded one.",
        .arguments = replay_arguments,
        .example = "shakerd replay --set from_s=3.5 run.nxs",
        .exit_statuses = {manual::exit_device, manual::exit_not_identical},
        .act = act_on_replay};
}

}  // namespace shaker::commands
