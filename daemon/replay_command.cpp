#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "daemon/acquisition.hpp"
#include "daemon/commands.hpp"
#include "daemon/recorder.hpp"
#include "daemon/results.hpp"
#include "daemon/trip_record.hpp"

namespace shaker {

namespace {

// Where a run's end is all there is, its targets are not where the tracker would begin to look.
bool tracks_anew(const SessionHeader& header) { return header.keep_frames && header.kind != "trip"; }

// The raw streams of a recording, and its tracks: from the pictures, or as they were stored.
Take take_of(const SessionReader& file, std::vector<std::string>& notes) {
    const SessionHeader& header = file.header();
    Rig rig = replay_rig(file);
    if (!tracks_anew(header)) rig.cameras.clear();
    Acquisition acquisition{rig, nullptr};
    read_all(acquisition);
    Take take = std::move(acquisition.take());
    take.dac_rate_hz = header.dac.rate_hz;
    take.played = file.play_times();
    take.changes = file.changes();
    if (tracks_anew(header))
        settle_times(take, notes);
    else
        read_tracks(file, take);
    return take;
}

// What is recomputed, printed and held against the recording.
struct Recomputed {
    std::vector<RecordedNumber> numbers;
    std::vector<RecordedTable> tables;
};

void add_reduction(const SessionReader& file, const Take& take, const std::vector<RecordedTrip>& trips,
                   std::vector<std::string> notes, bool json, Recomputed& out) {
    const double from_s = file.scalar("process/reduced_from"), to_s = file.scalar("process/reduced_to");
    Reduction reduction = reduce(measurement_of(take, file.header().frequency_hz, from_s, to_s));
    std::ranges::move(notes, std::back_inserter(reduction.notes));
    if (!trips.empty())
        reduction.notes.push_back(
            fmt::format("a limit stopped the run: these are the {:.0f} periods that were "
                        "measured well before it",
                        (to_s - from_s) * file.header().frequency_hz));
    std::fputs((json ? results_json(reduction, {}, {}, trips) + "\n" : results_text(reduction)).c_str(),
               stdout);
    out.numbers = numbers_of(reduction);
    for (RecordedTable& t : tables_of(reduction)) out.tables.push_back(std::move(t));
}

}  // namespace

bool replay(const ReplayOptions& options) {
    const SessionReader file{options.file};
    const SessionHeader& header = file.header();
    const std::vector<RecordedTrip> trips = read_trips(file);
    if (!options.json)
        for (const RecordedTrip& trip : trips) fmt::print("a limit stopped this run {}\n", text(trip));
    spdlog::info("replaying \"{}\" from {}", header.title,
                 tracks_anew(header) ? "frames and counts" : "tracks and counts");
    std::vector<std::string> notes;
    const Take take = take_of(file, notes);
    Recomputed now{.numbers = {}, .tables = tables_of(take)};
    if (trips.empty() || file.has("process/reduced_from")) {
        add_reduction(file, take, trips, std::move(notes), options.json, now);
    } else {
        const std::string why = file.text("process/not_reduced");
        if (options.json)
            std::fputs((trips_json(trips, why) + "\n").c_str(), stdout);
        else
            fmt::print("nothing to reduce: {}\n", why);
    }

    const std::vector<std::string> found = differences(file, now.numbers, now.tables);
    if (found.empty()) {
        std::size_t values = now.numbers.size();
        for (const RecordedTable& t : now.tables)
            for (const Column& c : t.columns) values += c.values.size();
        spdlog::info("replay identical: {} numbers equal to the bit", values);
        if (!options.json) fmt::print("replay: identical ({} numbers, to the bit)\n", values);
        return true;
    }
    for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 20); ++i)
        spdlog::warn("differs: {}", found[i]);
    if (!options.json) fmt::print("replay: NOT identical, {} differences\n", found.size());
    return false;
}

}  // namespace shaker
