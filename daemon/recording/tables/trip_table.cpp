#include "daemon/recording/tables/trip_table.hpp"

#include <algorithm>

#include "daemon/recording/tables/columns.hpp"

namespace shaker::recording {

namespace {

constexpr double doubtful_periods = 2;  // excluded before a trip
constexpr double least_periods = 2;     // needed for a reduction

using safety::StopKind;
using safety::Trip;

const char* word_of(StopKind stop) { return stop == StopKind::hard ? "hard" : "soft"; }

bool take_cause(RecordedTrip& t, const std::string& word) {
    const auto cause = safety::cause_named(word);
    if (cause) t.trip.cause = *cause;
    return cause.has_value();
}

bool take_stop(RecordedTrip& t, const std::string& word) {
    t.trip.stop = word == word_of(StopKind::hard) ? StopKind::hard : StopKind::soft;
    return word == word_of(t.trip.stop);
}

bool take_harmonic(RecordedTrip& t, double value) {
    return columns::take(t.trip.harmonic, value) && std::abs(value) <= max_harmonics;
}

double harmonic_of(const RecordedTrip& t) { return t.trip.harmonic; }

constexpr std::array trip_numbers{
    number<&RecordedTrip::trip, &Trip::value>("value", "1",
                                              "value that violated the limit; its unit is in `unit`"),
    number<&RecordedTrip::trip, &Trip::limit>("limit", "1", "violated limit; its unit is in `unit`"),
    NumberColumn<RecordedTrip>{"harmonic", "1",
                               "harmonic of the drive frequency; 0: the cause does not belong to a harmonic",
                               harmonic_of, take_harmonic},
    number<&RecordedTrip::trip, &Trip::on_dac_clock>("on_dac_clock", "1",
                                                     "1: tick counts DAC samples, 0: accelerometer samples"),
    number<&RecordedTrip::trip, &Trip::tick>("tick", "1", "number of the sample that violated the limit"),
    number<&RecordedTrip::at_s>("time", "s", "master time of that sample; NaN: not known")};
constexpr std::array trip_texts{
    TextColumn<RecordedTrip>{"cause", word_bytes, "one word, as in settings and remote commands",
                             [](const RecordedTrip& t) -> std::string { return name(t.trip.cause); },
                             take_cause},
    TextColumn<RecordedTrip>{"unit", word_bytes, "unit of value and limit; empty for a share",
                             [](const RecordedTrip& t) -> std::string { return unit_of(t.trip.cause); }},
    TextColumn<RecordedTrip>{"stop", word_bytes, "hard: at once, soft: by a ramp",
                             [](const RecordedTrip& t) -> std::string { return word_of(t.trip.stop); },
                             take_stop},
    text<&RecordedTrip::state>("state", word_bytes, "state of the run"),
    TextColumn<RecordedTrip>{"words", sentence_bytes, "one sentence for the operator",
                             [](const RecordedTrip& t) { return recording::text(t); }}};
constexpr Table<RecordedTrip> trip_columns{"trips", "limits that stopped the run, in their order",
                                           trip_numbers, trip_texts};

}  // namespace

std::vector<recorded::GroupLayout> trip_places() { return {layout_of(trip_columns)}; }

void write_trips(recorded::RecordingWriter& file, const std::vector<RecordedTrip>& trips) {
    write_rows(file, trip_columns, trips);
}

std::vector<RecordedTrip> read_trips(const recorded::RecordingReader& file) {
    return read_rows(file, trip_columns);
}

acquisition::Streams tail_of(const acquisition::Streams& streams, double from_s) {
    acquisition::Streams tail = streams;
    const double from_tick = from_s * streams.dac_rate_hz;
    std::erase_if(tail.played, [&](const PlayTime& p) { return static_cast<double>(p.tick.n) < from_tick; });
    // A ramp starts from the previous drive, so the previous drive is kept too.
    const auto in_force = static_cast<std::ptrdiff_t>(in_force_at(tail.changes, from_tick));
    tail.changes.erase(tail.changes.begin(), tail.changes.begin() + in_force);
    if (const calibration::Timebase& timebase = streams.timebase.recorded(); timebase.ready())
        std::erase_if(tail.blocks, [&](const AccelBlock& b) {
            return seconds(timebase.at(AccelTick{b.first.n + b.size})) < from_s;
        });
    if (tail.blocks.size() < streams.blocks.size() && !tail.blocks.empty())
        tail.blocks.front().quality = tail.blocks.front().quality | Quality::gap;
    for (acquisition::TargetTrack& t : tail.tracks)
        std::erase_if(t.tracks, [&](const tracking::Track& k) { return !(seconds(k.time) >= from_s); });
    for (acquisition::CameraStream& c : tail.cameras) c.untimed.clear();
    tail.timebase = empty_timebase(tail);
    for (const PlayTime& p : tail.played) tail.timebase.add(p);
    for (const AccelBlock& b : tail.blocks) tail.timebase.add(b);
    return tail;
}

MeasuredPart part_before(const MeasuredPart& planned, double at_s, double frequency_hz) {
    if (!std::isfinite(at_s)) return {};
    const double until_s = std::min(planned.to_s, at_s - doubtful_periods / frequency_hz);
    const double periods = std::floor((until_s - planned.from_s) * frequency_hz + 1e-6);
    if (!(periods >= least_periods)) return {};
    return {planned.from_s, planned.from_s + periods / frequency_hz};
}

}  // namespace shaker::recording
