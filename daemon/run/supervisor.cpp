#include "daemon/run/supervisor.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/safety/limits.hpp"

namespace shaker::run {

namespace {
// A harmonic above this share of the largest one: its own ratio of motion to drive is used.
constexpr double strong = 0.1;
// Relative tolerance of the expectation while the response is the data sheet's or another target's.
constexpr double loose = 0.6;
constexpr double anything = 1e6;       // during a loop check
constexpr double tight = 0.3;          // relative tolerance for a measured response
constexpr double near = 0.1;           // loop error, share of the target, below which the target is reached
constexpr double clear_of_noise = 30;  // motion / standard deviation of the noise
constexpr double settling_step_s = 0.5, longest_settling_s = 60;
constexpr double settled_mps3 = 0.1;  // m/s^3: 2 mm/s^2 in a period of 20 Hz
constexpr double clear_of_mean = 5;   // errors of a window's mean
constexpr double same = 0.1;          // largest relative change between windows of constant motion
// True when the motion is well above the noise, so that its axis and its ratio to the drive are meaningful.
bool moves(const control::PeriodWindows::Window& window, double noise) {
    return control::norm(window.motion.measured, control::controlled_harmonics) >
               clear_of_noise * noise * std::sqrt(2.0 * control::controlled_harmonics) &&
           control::norm(window.motion.volts, control::controlled_harmonics) > 0;
}
double distance(const Harmonics<Acceleration>& a, const Harmonics<Acceleration>& b) {
    double squares = 0;
    for (std::size_t q = 0; q < max_harmonics; ++q) squares += std::norm(a.a[q] - b.a[q]);
    return std::sqrt(squares);
}
}  // namespace

void Supervisor::order(const safety::Trip& trip, acquisition::Channels& channels) {
    const std::uint64_t excused = channels.excused;
    if (ordered_ && excused == excused_) return;
    excused_ = excused;
    ordered_ = channels.ordered.push(trip);
    if (!ordered_) ++channels.lost.trips_lost;  // the next finding tries again
}

// Windows are compared half a second apart.
bool Supervisor::settled(const control::PeriodWindows::Window& window) noexcept {
    const auto& now = window.estimate.mean;
    if (!(rest_from_s_ <= window.to_s)) rest_from_s_ = window.to_s;
    if (window.to_s > rest_from_s_ + longest_settling_s) return true;
    if (window.to_s < rest_s_ + settling_step_s) return settles_ == false;
    const double change = std::hypot(now[0] - rest_[0], now[1] - rest_[1], now[2] - rest_[2]);
    const double noise = window.estimate.residual / std::sqrt(std::max(window.estimate.samples, 1));
    if (std::isfinite(rest_s_))
        settles_ = change > settled_mps3 * (window.to_s - rest_s_) + clear_of_mean * noise;
    rest_ = now;
    rest_s_ = window.to_s;
    return settles_ == false;
}

bool Supervisor::check_at_rest(const control::PeriodWindows::Window& window,
                               acquisition::Channels& channels) {
    if (!accelerometer_.gravity) return settled(window);
    const auto& g = window.estimate.mean;
    const double seen = std::hypot(g[0], g[1], g[2]);
    const double most = safety::most_gravity_off(!accelerometer_.calibration.empty());
    if (!safety::gravity_wrong(seen, gravity_, most)) return true;
    if (!limits_.detectors[static_cast<std::size_t>(safety::Cause::gravity)]) return true;
    order({.cause = safety::Cause::gravity,
           .on_dac_clock = true,
           .value = seen / gravity_,
           .limit = 1 + most,
           .tick = tick_at(window.to_s)},
          channels);
    return false;
}

void Supervisor::check(const control::PeriodWindows::Window& window,
                       const control::DriveController& controller, Standing standing,
                       const calibration::Timebase& timebase, AccelTick tick,
                       acquisition::Channels& channels) {
    const safety::JudgedWindow judged{
        .estimate = window.estimate,
        .motion = window.motion,
        .response = controller.response_at(controller.drive().frequency),
        .target = standing.followed ? harmonics(controller.drive()) : Harmonics<Acceleration>{},
        .report = controller.report(),
        .noise = controller.noise(),
        .tick = tick_at(window.to_s),
        .followed = standing.followed};
    if (const auto trip = loop_.check(judged, channels.warnings))
        order(*trip, channels);
    else if (standing.current &&
             moves(window, controller.noise()) &&  // small corrections continue and do not matter here
             distance(window.motion.measured, before_) <
                 same * control::norm(window.motion.measured, control::controlled_harmonics)) {
        posted_ = expectation(window, judged.target, controller, timebase, tick, channels.warnings);
        channels.expectation.post(*posted_);
    }
    before_ = window.motion.measured;
}

// For strong harmonics in the target: the measured ratio of motion to drive. For all others: the known
// response, because their motion may be distortion by plant or walker, which the drive compensates.
safety::Expectation Supervisor::expectation(const control::PeriodWindows::Window& window,
                                            const Harmonics<Acceleration>& target,
                                            const control::DriveController& controller,
                                            const calibration::Timebase& timebase, AccelTick tick,
                                            safety::Warnings& warnings) {
    safety::Expectation e{.response = controller.response_at(controller.drive().frequency),
                          .frequency = controller.drive().frequency,
                          .axis = window.estimate.axis,
                          .at = tick};
    double largest = 0;
    for (const auto& a : window.motion.measured.a) largest = std::max(largest, std::abs(a));
    const bool aimed = control::norm(target, max_harmonics) > 0;
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        if (aimed && target.a[q] == 0.0) continue;
        const std::complex<double> volts = window.motion.volts.a[q], motion = window.motion.measured.a[q];
        if (std::abs(motion) > strong * largest && std::abs(volts) > 0) e.response[q] = motion / volts;
    }
    if (!accelerometer_.response.none())  // the guard compares the samples as the sensor gives them
        for (std::size_t q = 0; q < max_harmonics; ++q)
            e.response[q] *= accelerometer_.response.at(static_cast<double>(q + 1) * e.frequency);
    e.dac_sample = dac_rate_hz_ * seconds(timebase.at(tick));
    e.dac_per_tick = clocks_.check(timebase, tick, warnings);
    e.sigma = controller.noise() * std::sqrt(0.5 * window.estimate.samples);
    // Before the target is reached, a change by the walker may look like one by the drive.
    const bool on_the_way = aimed && controller.report().error > near;
    e.tolerance = !on_the_way && (controller.identified() || controller.report().locked) ? tight : loose;
    return e;
}

void Supervisor::expect_another(acquisition::Channels& channels) {
    if (!posted_) return;
    posted_->tolerance = loose;
    channels.expectation.post(*posted_);
}

void Supervisor::loop_check(bool begins, acquisition::Channels& channels) {
    if (!posted_) return;
    safety::Expectation e = *posted_;
    if (begins) e.tolerance = anything;
    channels.expectation.post(e);
}

void Supervisor::check(const control::IdentifiedResponse& response, bool ended, double now_s,
                       acquisition::Channels& channels) {
    const bool axis_known = std::ranges::any_of(accelerometer_.shaker_axis, [](double u) { return u != 0; });
    if (const auto trip = loop_.check(response, axis_known, ended, tick_at(now_s))) order(*trip, channels);
}

bool Supervisor::stop(safety::Trip trip, double now_s, acquisition::Channels& channels) {
    if (!limits_.detectors[static_cast<std::size_t>(trip.cause)]) return false;
    trip.on_dac_clock = true;
    trip.tick = tick_at(now_s);
    order(trip, channels);
    return true;
}

void Supervisor::check(const WalkerMonitor& walker, double now_s, acquisition::Channels& channels) {
    if (walker.lost() >= limits_.tracking_lost_frames)
        stop({.cause = safety::Cause::tracking_lost,
              .value = static_cast<double>(walker.lost()),
              .limit = static_cast<double>(limits_.tracking_lost_frames)},
             now_s, channels);
    if (walker.edge_mm() && *walker.edge_mm() < limits_.edge_mm)
        stop({.cause = safety::Cause::walker_edge, .value = *walker.edge_mm(), .limit = limits_.edge_mm},
             now_s, channels);
}

bool Supervisor::check_view(const WalkerMonitor& walker, double now_s, acquisition::Channels& channels) {
    if (walker.blind())
        return !stop({.cause = safety::Cause::camera_missing, .value = now_s - walker.until_s()}, now_s,
                     channels);
    if (!walker.watches() || walker.age_s() <= walker.most_age_s()) return true;
    return !stop(
        {.cause = safety::Cause::camera_missing, .value = walker.age_s(), .limit = walker.most_age_s()},
        now_s, channels);
}

}  // namespace shaker::run
