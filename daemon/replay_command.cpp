#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "daemon/commands.hpp"
#include "daemon/recorder.hpp"
#include "daemon/replay_settings.hpp"
#include "daemon/replayed_take.hpp"
#include "daemon/results.hpp"
#include "daemon/trip_record.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

// Where a run's end is all there is, its targets are not where the tracker would begin to look.
bool from_pictures(const SessionReader& file, ReplayOptions::From from) {
    const SessionHeader& header = file.header();
    const char* why = nullptr;
    if (header.kind == "trip")
        why = "it holds the end of a run only, where targets are not where the tracker begins to look";
    else if (header.pictures == KeptPictures::off)
        why = "no pictures were kept";
    else if (file.frames_without_picture() > 0)
        why = "not all pictures were kept";
    if (from == ReplayOptions::From::raw && why != nullptr)
        throw InputError{fmt::format("{}: --from raw is not possible: {}", file.file().string(), why)};
    return from != ReplayOptions::From::tracks && why == nullptr;
}

// What is recomputed, printed and held against the recording.
struct Recomputed {
    std::vector<RecordedNumber> numbers;
    std::vector<RecordedTable> tables;
};

void add_reduction(const ReplaySettings& as, const Take& take, const std::vector<RecordedTrip>& trips,
                   std::vector<std::string> notes, bool json, Recomputed& out) {
    Reduction reduction = reduce(measurement_of(take, as.header.frequency_hz, as.from_s, as.to_s));
    std::ranges::move(notes, std::back_inserter(reduction.notes));
    if (!trips.empty())
        reduction.notes.push_back(
            fmt::format("a limit stopped the run: these are the {:.0f} periods that were "
                        "measured well before it",
                        (as.to_s - as.from_s) * as.header.frequency_hz));
    std::fputs((json ? results_json(reduction, {}, {}, trips) + "\n" : results_text(reduction)).c_str(),
               stdout);
    out.numbers = numbers_of(reduction);
    for (RecordedTable& t : tables_of(reduction)) out.tables.push_back(std::move(t));
}

// What other settings made of the results.
void tell_changes(const SessionReader& file, const Recomputed& now) {
    fmt::print("with other settings than recorded:\n");
    std::size_t changed = 0;
    for (const RecordedNumber& n : now.numbers) {
        const double was = file.scalar(n.path);
        if (was == n.value || (std::isnan(was) && std::isnan(n.value))) continue;
        ++changed;
        fmt::print("  {:<32}{:>16.8g} -> {:<16.8g} {}\n", n.path, was, n.value, n.units);
    }
    fmt::print("{} of {} numbers changed\n", changed, now.numbers.size());
}

bool tell_differences(const SessionReader& file, const Recomputed& now, bool json) {
    const std::vector<std::string> found = differences(file, now.numbers, now.tables);
    if (found.empty()) {
        std::size_t values = now.numbers.size();
        for (const RecordedTable& t : now.tables)
            for (const Column& c : t.columns) values += c.values.size();
        spdlog::info("replay identical: {} numbers equal to the bit", values);
        if (!json) fmt::print("replay: identical ({} numbers, to the bit)\n", values);
        return true;
    }
    for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 20); ++i)
        spdlog::warn("differs: {}", found[i]);
    if (!json) fmt::print("replay: NOT identical, {} differences\n", found.size());
    return false;
}

}  // namespace

bool replay(const ReplayOptions& options) {
    const SessionReader file{options.file};
    for (const std::string& what : file.damage()) spdlog::warn("the recording is damaged: {}", what);
    const ReplaySettings as = replay_settings(file, options.set);
    const std::vector<RecordedTrip> trips = read_trips(file);
    if (!options.json)
        for (const RecordedTrip& trip : trips) fmt::print("a limit stopped this run {}\n", text(trip));
    const bool pictures = from_pictures(file, options.from);
    spdlog::info("replaying \"{}\" from {}", as.header.title,
                 pictures ? "frames and counts" : "tracks and counts");
    std::vector<std::string> notes;
    const Take take = replayed_take(file, as.header, pictures, options.real_time, notes);
    Recomputed now{.numbers = {}, .tables = tables_of(take)};
    if (std::isfinite(as.from_s)) {
        add_reduction(as, take, trips, std::move(notes), options.json, now);
    } else {
        const std::string why = file.text("process/not_reduced");
        if (options.json)
            std::fputs((trips_json(trips, why) + "\n").c_str(), stdout);
        else
            fmt::print("nothing to reduce: {}\n", why);
    }
    if (!as.changed) return tell_differences(file, now, options.json);
    if (!options.json) tell_changes(file, now);
    return true;
}

}  // namespace shaker
