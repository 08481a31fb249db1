// Orders to the sequence from outside.
#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "daemon/run/sequence.hpp"
#include "drivers/errors.hpp"

namespace shaker::run {

void Sequence::require_idle(const char* what, const acquisition::Channels& channels) const {
    if (state() == RunState::tripped || channels.stopped)
        throw InputError{
            fmt::format("{} cannot start while the bench is tripped; look at the cause, clear the "
                        "trip, then start again",
                        what)};
    if (driving(state()))
        throw InputError{fmt::format("{} cannot start while the bench is {}; stop the drive first", what,
                                     row_of(state()).shown)};
    if (state() != RunState::idle)
        throw InputError{fmt::format("{} cannot start while the bench is {}; wait until it is idle", what,
                                     row_of(state()).shown)};
    if (walker_.has_target() && !walker_.sees())
        throw InputError{
            fmt::format("{} cannot start: the walker is in no picture of the last {:.0f} ms (newest picture: "
                        "{:.3g} s ago); "
                        "check the cameras, their trigger, the light and the walker",
                        what, 1e3 * walker_.most_age_s(), walker_.age_s())};
}

void Sequence::aim(const char* what, const Drive& drive, const acquisition::Channels& channels) {
    require_idle(what, channels);
    order_ = {};
    notes_.clear();
    measured_.clear();
    part_ = {0, 0};
    controller_.aim(drive);
    const double frequency = Synthesiser::realised(drive.frequency, dac_rate_hz_);
    if (frequency != frequency_) walker_.set_frequency(frequency);
    frequency_ = frequency;
    permit_.reset();
}

void Sequence::begin(const Drive& drive, const Task& task, acquisition::Channels& channels,
                     const std::optional<safety::EdgePermit>& permit) {
    aim("a run", drive, channels);
    permit_ = permit;
    plan_.task = task;
    arm(channels);
}

void Sequence::close_loop(bool on) {
    if (state() != RunState::idle)
        throw InputError{
            fmt::format("the loop cannot be switched while the bench is {}; wait until it is idle",
                        row_of(state()).shown)};
    plan_.controller.equalise = on;
    controller_.close_loop(on);
}

void Sequence::identify(const Drive& drive, acquisition::Channels& channels) {
    if (!plan_.controller.identify || !plan_.controller.equalise)
        throw InputError{"identification is switched off in the settings (identify or closed_loop is false)"};
    aim("identification", drive, channels);
    controller_.forget();
    order_.only_identify = true;
    arm(channels);
}

void Sequence::end(acquisition::Channels& channels) {
    const RunState now = state();
    if (!driving(now) || now == RunState::ramp_down)
        throw InputError{fmt::format("there is no drive to stop: the bench is {}", row_of(now).shown)};
    keep_whole_periods();
    come_down(channels);
}

void Sequence::leave(acquisition::Channels& channels) {
    leaving_ = true;
    note("interrupted");
    const RunState now = state();
    const auto* run = std::get_if<Run>(&state_);
    if (run != nullptr && run->measuring) interrupted_part_ = {part_.from_s, std::min(part_.to_s, now_s_)};
    if (driving(now) && now != RunState::ramp_down) come_down(channels);
}

void Sequence::set(const Drive& drive, const Task& task, acquisition::Channels& channels) {
    if (state() != RunState::run)
        throw InputError{
            fmt::format("the set-point cannot be changed while the bench is {}; wait until it is running",
                        row_of(state()).shown)};
    if (permit_ && !permit_->over())
        throw InputError{
            "the walker is still beyond the edge limit; the set-point can change when it is inside"};
    keep_whole_periods();
    plan_.task = task;
    state_ = run_state(now_s_);
    order_.settling_noted = false;
    controller_.set(drive);
    if (drive.frequency != frequency_) {
        frequency_ = Synthesiser::realised(drive.frequency, dac_rate_hz_);
        walker_.set_frequency(frequency_);
    }
    note_mains();
    guard_.expect_another(channels);
    go_for_target(1, channels);
}

void Sequence::hold() {
    keep_whole_periods();
    if (auto* run = std::get_if<Run>(&state_)) run->left = 0;
}

void Sequence::hold_to(const safety::Limits& limits, acquisition::Channels& channels) {
    plan_.limits = limits;
    guard_.hold_to(limits);
    plan_.controller.volts_limit = limits.drive.abort * usable_drive;
    controller_.limit(plan_.controller.volts_limit);
    channels.output_limits.post(limits);
    channels.input_limits.post(limits);
}

void Sequence::stop(acquisition::Channels& channels, const safety::Trip& why) {
    safety::Trip trip = why;
    trip.on_dac_clock = true;
    trip.tick = static_cast<std::int64_t>(now_s_ * dac_rate_hz_);
    if (!channels.ordered.push(trip)) ++channels.lost.trips_lost;
}

void Sequence::clear(std::uint64_t aborts, acquisition::Channels& channels) {
    auto* tripped = std::get_if<Tripped>(&state_);
    if (tripped == nullptr)
        throw InputError{fmt::format("there is no trip to clear: the bench is {}", row_of(state()).shown)};
    if (tripped->phase != Tripped::Phase::silent)
        throw InputError{"the drive is not silent yet; wait until it is, then clear the trip"};
    const std::uint64_t openings = channels.openings;
    if (channels.contact != Contact::closed)
        throw InputError{
            "the contact of the abort input is open or cannot be read; close it, then clear the trip"};
    channels.clearance.post({newest_trip_, aborts, openings});
    tripped->phase = Tripped::Phase::clearing;
}

}  // namespace shaker::run
