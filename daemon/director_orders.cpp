// What the director is told from outside.
#include <spdlog/fmt/fmt.h>

#include "daemon/director.hpp"
#include "drivers/errors.hpp"

namespace shaker {

void Director::aim(const char* what, const Drive& drive, const Lanes& lanes) {
    if (state_ != RunState::idle || lanes.stopped)
        throw InputError{
            fmt::format("{} was asked for in state {}; it can be in state idle only", what, name(state_))};
    restarts_ = 0;
    notes_.clear();
    measured_.clear();
    from_s_ = to_s_ = 0;
    only_identify_ = told_late_ = false;
    keeper_.aim(drive);
    const double frequency = Synthesiser::realised(drive.frequency, dac_rate_hz_);
    if (frequency != frequency_) walker_ = WalkerWatch{frequency};
    frequency_ = frequency;
}

void Director::begin(const Drive& drive, int periods, int settle, Lanes& lanes) {
    aim("a run", drive, lanes);
    plan_.periods = periods;
    plan_.settle = settle;
    arm(lanes);
}

void Director::close_loop(bool on) {
    if (state_ != RunState::idle)
        throw InputError{
            fmt::format("the loop was switched in state {}; it can be while nothing is driven (state idle)",
                        name(state_))};
    plan_.keeper.equalise = on;
    keeper_.close_loop(on);
}

void Director::identify(const Drive& drive, Lanes& lanes) {
    if (!plan_.keeper.identify || !plan_.keeper.equalise)
        throw InputError{
            "identification was asked for, but the settings say that the data sheet is to be taken"};
    aim("identification", drive, lanes);
    keeper_.forget();
    only_identify_ = true;
    arm(lanes);
}

void Director::end(Lanes& lanes) {
    if (state_ != RunState::identify && state_ != RunState::ramp && state_ != RunState::run)
        throw InputError{fmt::format("there is no drive to stop in state {}", name(state_))};
    measuring_ = false;
    come_down(lanes);
}

void Director::set(const Drive& drive, Lanes& lanes) {
    if (state_ != RunState::run)
        throw InputError{fmt::format(
            "a new set-point was given in state {}; it can be changed in state run only", name(state_))};
    measuring_ = told_late_ = false;
    keeper_.set(drive);
    if (drive.frequency != frequency_) {
        frequency_ = Synthesiser::realised(drive.frequency, dac_rate_hz_);
        walker_ = WalkerWatch{frequency_};
    }
    guard_.expect_another(lanes);
    go_for_target(1, lanes);
    run_from_s_ = now_s_;
}

void Director::hold_to(const Limits& limits, Lanes& lanes) {
    plan_.limits = limits;
    guard_.hold_to(limits);
    lanes.output_limits.post(limits);
    lanes.input_limits.post(limits);
}

void Director::stop(Lanes& lanes, const Trip& why) {
    Trip trip = why;
    trip.on_dac_clock = true;
    trip.tick = static_cast<std::int64_t>(now_s_ * dac_rate_hz_);
    if (!lanes.ordered.push(trip)) ++lanes.lost.trips_lost;
}

void Director::clear(Lanes& lanes) {
    if (state_ != RunState::tripped)
        throw InputError{fmt::format("nothing to clear: the run is in state {}", name(state_))};
    if (!done_) throw InputError{"the drive is not silent yet; clear the trip when it is"};
    ++lanes.releases;
    clearing_ = true;
    done_ = false;
}

// Idle is what may be armed: not before the output has let go.
void Director::finish_clearing(const Lanes& lanes) {
    if (lanes.stopped) return;
    guard_.rearm();
    trip_.reset();
    clearing_ = false;
    go(RunState::idle);
}

}  // namespace shaker
