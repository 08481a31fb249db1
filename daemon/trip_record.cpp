#include "daemon/trip_record.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/session_places.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr double doubtful_periods = 2;  // before a trip
constexpr double most_ticks = 9e15;     // a double counts them exactly
constexpr double least_periods = 2;     // of a reduction

std::vector<std::string> words_of(const std::vector<RecordedTrip>& trips, auto&& word) {
    std::vector<std::string> words;
    words.reserve(trips.size());
    for (const RecordedTrip& t : trips) words.emplace_back(word(t));
    return words;
}

Column column(std::string name, std::string units, const std::vector<RecordedTrip>& trips, auto&& value) {
    Column c{std::move(name), std::move(units), {}};
    for (const RecordedTrip& t : trips) c.values.push_back(static_cast<double>(value(t)));
    return c;
}

template <class T>
std::vector<T> same_length(std::vector<T> values, std::size_t n, const std::string& name) {
    if (values.size() != n)
        throw InputError{
            fmt::format("recording: trips/{} has {} rows, trips/cause has {}", name, values.size(), n)};
    return values;
}

std::int64_t whole(double value, double most, const char* name) {
    if (!(std::abs(value) <= most && value == std::floor(value)))
        throw InputError{
            fmt::format("recording: trips/{} = {} is not a whole number up to {}", name, value, most)};
    return static_cast<std::int64_t>(value);
}

Cause cause_of(const std::string& word) {
    const auto cause = cause_named(word);
    if (!cause) throw InputError{"recording: trips/cause \"" + word + "\" is not a cause of a trip"};
    return *cause;
}

StopKind stop_of(const std::string& word) {
    if (word != "hard" && word != "soft")
        throw InputError{"recording: trips/stop \"" + word + "\" is neither hard nor soft"};
    return word == "hard" ? StopKind::hard : StopKind::soft;
}

RecordedTable trip_table(const std::vector<RecordedTrip>& trips) {
    return {"trips",
            {column("value", "1", trips, [](const auto& t) { return t.trip.value; }),
             column("limit", "1", trips, [](const auto& t) { return t.trip.limit; }),
             column("harmonic", "1", trips, [](const auto& t) { return t.trip.harmonic; }),
             column("on_dac_clock", "1", trips, [](const auto& t) { return t.trip.on_dac_clock; }),
             column("tick", "1", trips, [](const auto& t) { return t.trip.tick; }),
             column("time", "s", trips, [](const auto& t) { return t.at_s; })}};
}

}  // namespace

std::vector<RecordedTrip> recorded_trips(const Take& take, const Director& director) {
    const DriveClock clock = drive_clock(take);
    std::vector<RecordedTrip> trips;
    for (std::size_t i = director.cause(); i < take.trips.size(); ++i) {
        const Trip& t = i == director.cause() && director.trip() ? *director.trip() : take.trips[i];
        double at_s = static_cast<double>(t.tick) / take.dac_rate_hz;
        if (!t.on_dac_clock) at_s = clock.ready() ? seconds(clock.master({t.tick})) : NAN;
        trips.push_back({t, name(director.stops().at(i).state), at_s});
    }
    return trips;
}

std::vector<GroupLayout> trip_places() {
    GroupLayout places = layout_of(trip_table({}));
    const std::size_t word = 32, sentence = 512;  // bytes
    for (const char* name : {"cause", "unit", "stop", "state"})
        places.places.push_back({name, "", Place::Kind::texts, word, false});
    places.places.push_back({"words", "", Place::Kind::texts, sentence, false});
    return {places};
}

void write_trips(SessionWriter& file, const std::vector<RecordedTrip>& trips) {
    write(file, {trip_table(trips)});
    file.texts("trips/cause", words_of(trips, [](const auto& t) { return name(t.trip.cause); }));
    file.texts("trips/unit", words_of(trips, [](const auto& t) { return unit_of(t.trip.cause); }));
    file.texts("trips/stop", words_of(trips, [](const auto& t) {
                   return t.trip.stop == StopKind::hard ? "hard" : "soft";
               }));
    file.texts("trips/state", words_of(trips, [](const auto& t) { return t.state; }));
    file.texts("trips/words", words_of(trips, [](const auto& t) { return text(t); }));
}

std::vector<RecordedTrip> read_trips(const SessionReader& file) {
    const std::vector<std::string> cause = file.texts("trips/cause");
    const std::size_t n = cause.size();
    const auto numbers = [&](const std::string& name) {
        return same_length(file.numbers("trips/" + name), n, name);
    };
    const auto stop = same_length(file.texts("trips/stop"), n, "stop");
    const auto state = same_length(file.texts("trips/state"), n, "state");
    const auto value = numbers("value"), limit = numbers("limit"), harmonic = numbers("harmonic"),
               on_dac_clock = numbers("on_dac_clock"), tick = numbers("tick"), time = numbers("time");
    std::vector<RecordedTrip> trips;
    for (std::size_t i = 0; i < n; ++i)
        trips.push_back({{.cause = cause_of(cause[i]),
                          .stop = stop_of(stop[i]),
                          .on_dac_clock = on_dac_clock[i] != 0,
                          .harmonic = static_cast<int>(whole(harmonic[i], max_harmonics, "harmonic")),
                          .value = value[i],
                          .limit = limit[i],
                          .tick = whole(tick[i], most_ticks, "tick")},
                         state[i],
                         time[i]});
    return trips;
}

Take tail_of(const Take& take, double from_s) {
    Take tail = take;
    const double from_tick = from_s * take.dac_rate_hz;
    std::erase_if(tail.played, [&](const PlayTime& p) { return static_cast<double>(p.tick.n) < from_tick; });
    // A ramp begins at the drive before: that is kept too.
    const auto after = std::ranges::find_if(tail.changes, [&](const DriveChange& c) {
        return static_cast<double>(c.first.n + c.ramp) > from_tick;
    });
    if (after != tail.changes.begin()) tail.changes.erase(tail.changes.begin(), std::prev(after));
    if (const DriveClock clock = drive_clock(take); clock.ready())
        std::erase_if(tail.blocks, [&](const AccelBlock& b) {
            return seconds(clock.master({b.first.n + b.size})) < from_s;
        });
    if (tail.blocks.size() < take.blocks.size() && !tail.blocks.empty())
        tail.blocks.front().quality = tail.blocks.front().quality | Quality::gap;
    for (TargetTrack& t : tail.tracks)
        std::erase_if(t.tracks, [&](const Track& k) { return !(seconds(k.time) >= from_s); });
    for (CameraTake& c : tail.cameras) c.untimed.clear();
    return tail;
}

MeasuredPart part_before(const MeasuredPart& planned, double at_s, double frequency_hz) {
    if (!std::isfinite(at_s)) return {};
    const double until_s = std::min(planned.to_s, at_s - doubtful_periods / frequency_hz);
    const double periods = std::floor((until_s - planned.from_s) * frequency_hz + 1e-6);
    if (!(periods >= least_periods)) return {};
    return {planned.from_s, planned.from_s + periods / frequency_hz};
}

}  // namespace shaker
