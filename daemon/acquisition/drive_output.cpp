#include "daemon/acquisition/drive_output.hpp"

#include <algorithm>

#include "drivers/time.hpp"

namespace shaker::acquisition {

namespace {

constexpr double contact_patience_s = 0.2;  // longest time without a reading of the abort input

double drive_limit(double full_scale_V, const std::optional<safety::Limits>& limits) {
    return limits ? std::min(limits->drive.abort, full_scale_V) : full_scale_V;
}

// Passes a change of the drive to the reduction and, before it is audible, to the accelerometer's guard.
void push_change(const DriveOutput& output, Channels& channels, std::int64_t taken_back = 0) {
    if (output.synthesiser.change() == nullptr) return;
    DriveChange change = *output.synthesiser.change();
    change.taken_back = taken_back;
    if (!channels.changes.push(change)) ++channels.lost.changes_lost;
    if (output.guard.armed() && !channels.ahead.push(change)) ++channels.lost.changes_lost;
}

// Reports the newest trip to the reduction. A trip that finds a full ring waits for room.
void report(DriveOutput& output, Channels& channels) {
    if (output.unreported && channels.trips.push(*output.unreported)) output.unreported.reset();
}

// Takes back samples before a stop, unless the drive ends as early without that. Returns their number.
std::int64_t take_back(std::int64_t stop_samples, DriveOutput& output, Dac& dac) {
    const Synthesiser& s = output.synthesiser;
    if (s.stopped() && output.newest.stop == safety::StopKind::hard) return 0;
    const DacTick now = s.tick(), first = output.queued.first(now);
    const std::int64_t ends = s.silent() ? output.drives_until : now.n + stop_samples;
    if (first.n + stop_samples >= ends) return 0;
    const std::int64_t taken = dac.take_back(now.n - first.n);
    if (taken > 0) output.queued.go_back({now.n - taken}, output.synthesiser, output.triggers, output.volts);
    return taken;
}

void latch(safety::Trip trip, DriveOutput& output, Dac& dac, Channels& channels) {
    const std::int64_t samples = output.guard.stop_samples(trip.stop);
    const std::int64_t taken = trip.stop == safety::StopKind::hard ? take_back(samples, output, dac) : 0;
    if (trip.on_dac_clock) trip.tick = std::min(trip.tick, output.synthesiser.tick().n);
    trip.number = output.newest.number + 1;
    output.newest = trip;
    if (output.unreported) ++channels.lost.trips_lost;
    output.unreported = trip;
    report(output, channels);
    output.synthesiser.stop(samples);
    push_change(output, channels, taken);
}

void latch_now(safety::Cause cause, DriveOutput& output, Dac& dac, Channels& channels) {
    latch({.cause = cause,
           .stop = safety::StopKind::hard,
           .on_dac_clock = true,
           .tick = output.synthesiser.tick().n},
          output, dac, channels);
}

void latch_for_operator(DriveOutput& output, Dac& dac, Channels& channels) {
    latch_now(safety::Cause::operator_stop, output, dac, channels);
}

double peak(const std::vector<double>& volts) noexcept {
    double largest = 0;
    for (const double v : volts) largest = std::max(largest, std::abs(v));
    return largest;
}

// Records where the drive of the block that starts at `first` ends.
void note_drive(std::int64_t first, DriveOutput& output) noexcept {
    for (std::int64_t i = std::ssize(output.volts); i > 0; --i) {
        if (output.volts[static_cast<std::size_t>(i - 1)] == 0) continue;
        output.drives_until = first + i;
        return;
    }
    output.drives_until = std::min(output.drives_until, first);
}

double mean_square(const std::vector<double>& volts) noexcept {
    double sum = 0;
    for (const double v : volts) sum += v * v;
    return sum / static_cast<double>(volts.size());
}

// State of the output after the last block, and signs of life of the other threads.
safety::OutputSigns signs_of(const DriveOutput& output, const Channels& channels) {
    const Synthesiser& s = output.synthesiser;
    return {.tick = s.tick().n,
            .silent = s.silent(),
            .peak_V = peak(output.volts),
            .mean_square_V2 = mean_square(output.volts),
            .clamped = s.clamped(),
            .largest_clamped_V = s.largest_clamped(),
            .heard = channels.heard,
            .judged = channels.judged,
            .checked_to = {channels.checked_to},
            .checked_arrived = channels.checked_arrived,
            .played = output.played,
            .gathered = channels.gathered};
}

// Blocks that follow each other without sound are one silence.
void note_silence(std::int64_t first, const PlayTime& played, DriveOutput& output) {
    const std::int64_t from = std::min(first, first + std::ssize(output.volts) - played.unheard);
    output.empty_from = from > output.empty_to ? from : std::min(output.empty_from, from);
    output.empty_to = output.synthesiser.tick().n;
}

// A DAC that ran empty makes the base miss its predicted motion and its target: these findings are part of
// the underrun.
bool part_of_underrun(const safety::Trip& trip, const DriveOutput& output) {
    return (contradicts_prediction(trip) || misses_target(trip)) && trip.on_dac_clock &&
           trip.tick >= output.empty_from && trip.tick < output.empty_to;
}

// The output is silent after a stop of this cause: another one changes nothing but refuse an earlier clear.
bool rests_after(safety::Cause cause, const DriveOutput& output) {
    return output.synthesiser.stopped() && output.synthesiser.silent() && output.newest.cause == cause;
}

// An abort always leaves a trip.
void answer_aborts(DriveOutput& output, Dac& dac, Channels& channels) {
    const std::uint64_t aborts = channels.aborts;
    if (aborts == output.aborted) return;
    output.aborted = aborts;
    if (!rests_after(safety::Cause::operator_stop, output)) latch_for_operator(output, dac, channels);
    channels.aborts_answered = aborts;
}

// A contact that is not read any more counts as open.
void answer_contact(DriveOutput& output, Dac& dac, Channels& channels) {
    if (!output.has_contact) return;
    const std::int64_t now = output.synthesiser.tick().n;
    const std::uint64_t reads = channels.contact_reads, openings = channels.openings;
    if (reads != output.contact_reads || output.synthesiser.stopped()) output.contact_read_at = now;
    output.contact_reads = reads;
    const bool late = duration_s(now - output.contact_read_at, output.rate_hz) > contact_patience_s;
    if (openings == output.openings && !late) return;
    output.openings = openings;
    if (!rests_after(safety::Cause::abort_input, output))
        latch_now(safety::Cause::abort_input, output, dac, channels);
}

// A loop has failed.
void answer_failure(DriveOutput& output, Dac& dac, Channels& channels) {
    const int cause = channels.failed;
    if (cause < 0 || output.failed) return;
    output.failed = true;
    latch({.cause = static_cast<safety::Cause>(cause),
           .on_dac_clock = true,
           .tick = output.synthesiser.tick().n},
          output, dac, channels);
}

void answer_clears(DriveOutput& output, Dac& dac, Channels& channels) {
    if (const auto clearance = channels.clearance.take()) output.clearance = clearance;
    if (!output.clearance) return;
    const Clearance& clear = *output.clearance;
    const bool opened =
        output.has_contact && (clear.openings != output.openings || channels.contact != Contact::closed);
    // The reduction waits for an answer. A trip that it has not seen yet is one, else it gets another.
    if (clear.trips != output.newest.number) {
        output.clearance.reset();
    } else if (clear.aborts != output.aborted) {
        output.clearance.reset();
        latch_for_operator(output, dac, channels);
    } else if (opened) {
        output.clearance.reset();
        latch_now(safety::Cause::abort_input, output, dac, channels);
    } else if (output.synthesiser.release()) {
        output.clearance.reset();
        output.guard.rearm();
        ++channels.releases;
    }
}

void answer_trips(DriveOutput& output, Dac& dac, Channels& channels) {
    report(output, channels);
    answer_aborts(output, dac, channels);
    answer_contact(output, dac, channels);
    answer_failure(output, dac, channels);
    // The output's own trips first: an empty DAC also makes the base miss its predicted motion.
    if (const auto trip = output.guard.check(signs_of(output, channels), channels.warnings))
        latch(*trip, output, dac, channels);
    while (const auto trip = channels.sensed.pop())
        if (!part_of_underrun(*trip, output)) latch(*trip, output, dac, channels);
    while (const auto trip = channels.ordered.pop())
        if (part_of_underrun(*trip, output))
            ++channels.excused;
        else
            latch(*trip, output, dac, channels);
    answer_clears(output, dac, channels);
}

void take_drive(DriveOutput& output, Channels& channels) {
    auto newest = channels.drive.take();
    if (newest && newest->stop_s <= 0 && newest->underruns != output.underruns) newest.reset();
    const auto command = output.enable.admit(newest, output.synthesiser);
    if (!command) return;
    output.synthesiser.set(*command);
    if (command->stop_s > 0) push_change(output, channels);
}

}  // namespace

DriveOutput::DriveOutput(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
                         const std::optional<safety::Limits>& limits, double accelerometer_rate_hz)
    : full_scale_V{dac.full_scale_V},
      rate_hz{dac.rate_hz},
      synthesiser{dac.rate_hz, frequency, drive_limit(dac.full_scale_V, limits)},
      guard{dac.rate_hz, accelerometer_rate_hz, limits},
      triggers{dac.rate_hz, frames_per_second},
      volts(block),
      pulses(block),
      queued{dac, block, synthesiser, triggers},
      enable{dac.rate_hz, dac.enable_before_s} {}

void output_step(DriveOutput& output, Dac& dac, Channels& channels) {
    Synthesiser& synthesiser = output.synthesiser;
    if (const auto limits = channels.output_limits.take()) {
        output.guard.hold_to(*limits);
        synthesiser.limit(drive_limit(output.full_scale_V, limits));
    }
    answer_trips(output, dac, channels);
    take_drive(output, channels);
    output.queued.add(synthesiser, output.triggers);
    synthesiser.fill(output.volts);
    output.triggers.fill(output.pulses);
    push_change(output, channels);
    const std::int64_t first = synthesiser.tick().n - std::ssize(output.volts);
    note_drive(first, output);
    output.enable.note(first, synthesiser, output.drives_until);
    dac.enable(output.enable.on());
    channels.enabled = output.enable.on();
    const PlayTime played = dac.write(output.volts, output.pulses);
    if (!channels.played.push(played)) ++channels.lost.plays_lost;
    output.played = played;
    if (played.lost > 0) {  // the next sample starts from silence, never at full level
        synthesiser.silence(played.lost);
        output.triggers.skip(played.lost);
        output.queued.clear();
        output.enable.restart();
        ++output.underruns;
        output.contact_read_at = synthesiser.tick().n;  // no block was written meanwhile
        push_change(output, channels);
        note_silence(first, played, output);
    }
    channels.silent = synthesiser.silent() ? channels.silent + std::ssize(output.volts) : 0;
    channels.stopped = synthesiser.stopped();
    channels.lost.samples_clamped = synthesiser.clamped();
}

}  // namespace shaker::acquisition
