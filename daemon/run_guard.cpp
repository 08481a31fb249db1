#include "daemon/run_guard.hpp"

#include <algorithm>
#include <cmath>

namespace shaker {

namespace {
constexpr double strong = 0.1;  // of the largest harmonic: then its own ratio of motion to drive is known
constexpr double loose =
    0.6;  // tolerance while the response is a data sheet's, being found out, or of another target
constexpr double tight = 0.3;                 // and once it was measured
constexpr double near = 0.1;                  // of the target: the loop's error when it has nearly arrived
constexpr double clear_of_noise = 30;         // sd
constexpr double same = 0.1;                  // of the motion, that it may differ from the window before
constexpr double standard_gravity = 9.80665;  // m/s^2
constexpr double least_gravity = 0.5;  // m/s^2; a sensor that shows less has no constant part, but an offset
constexpr double most_gravity_off = 0.4;  // share of it
// Clear of the noise: its axis and its ratio to the drive mean something.
bool moves(const MotionWindows::Window& window, double noise) {
    return norm(window.motion.measured, controlled_harmonics) >
               clear_of_noise * noise * std::sqrt(2.0 * controlled_harmonics) &&
           norm(window.motion.volts, controlled_harmonics) > 0;
}
double distance(const Harmonics<Acceleration>& a, const Harmonics<Acceleration>& b) {
    double squares = 0;
    for (std::size_t q = 0; q < max_harmonics; ++q) squares += std::norm(a.a[q] - b.a[q]);
    return std::sqrt(squares);
}
}  // namespace

void RunGuard::order(const Trip& trip, Lanes& lanes) {
    if (ordered_) return;
    ordered_ = true;
    if (!lanes.ordered.push(trip)) ++lanes.lost.trips_lost;
}

void RunGuard::look_at_rest(const MotionWindows::Window& window, Lanes& lanes) {
    const auto& g = window.estimate.mean;
    const double seen = std::hypot(g[0], g[1], g[2]), share = seen / standard_gravity;
    if (seen < least_gravity || std::abs(share - 1) < most_gravity_off) return;
    if (!limits_.detectors[static_cast<std::size_t>(Cause::gravity)]) return;
    order({.cause = Cause::gravity,
           .on_dac_clock = true,
           .value = share,
           .limit = 1 + most_gravity_off,
           .tick = tick_at(window.to_s)},
          lanes);
}

void RunGuard::look(const MotionWindows::Window& window, const DriveKeeper& keeper, Standing standing,
                    const DriveClock& clock, AccelTick tick, Lanes& lanes) {
    const JudgedWindow judged{
        .estimate = window.estimate,
        .motion = window.motion,
        .response = keeper.response_at(keeper.drive().frequency),
        .target = standing.followed ? harmonics(keeper.drive()) : Harmonics<Acceleration>{},
        .report = keeper.report(),
        .noise = keeper.noise(),
        .tick = tick_at(window.to_s),
        .followed = standing.followed};
    if (const auto trip = loop_.check(judged, lanes.warnings))
        order(*trip, lanes);
    else if (standing.current &&
             moves(window, keeper.noise()) &&  // also under small corrections, which never end
             distance(window.motion.measured, before_) <
                 same * norm(window.motion.measured, controlled_harmonics)) {
        posted_ = expectation(window, judged.target, keeper, clock, tick, lanes.warnings);
        lanes.expectation.post(*posted_);
    }
    before_ = window.motion.measured;
}

// The ratio of motion to drive where the motion is strong and meant, the response elsewhere: what is weak, or
// in no target, may be the plant's own distortion or the walker's, which the drive takes away.
Expectation RunGuard::expectation(const MotionWindows::Window& window, const Harmonics<Acceleration>& target,
                                  const DriveKeeper& keeper, const DriveClock& clock, AccelTick tick,
                                  Warnings& warnings) {
    Expectation e{.response = keeper.response_at(keeper.drive().frequency),
                  .frequency = keeper.drive().frequency,
                  .axis = window.estimate.axis,
                  .at = tick};
    double largest = 0;
    for (const auto& a : window.motion.measured.a) largest = std::max(largest, std::abs(a));
    const bool aimed = norm(target, max_harmonics) > 0;
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        if (aimed && target.a[q] == 0.0) continue;
        const std::complex<double> volts = window.motion.volts.a[q], motion = window.motion.measured.a[q];
        if (std::abs(motion) > strong * largest && std::abs(volts) > 0) e.response[q] = motion / volts;
    }
    e.dac_sample = dac_rate_hz_ * seconds(clock.master(tick));
    e.dac_per_tick = clocks_.look(clock, tick, warnings);
    e.sigma = keeper.noise() * std::sqrt(0.5 * window.estimate.samples);
    // On the way to a target a walker may take the place of what the drive is about to change.
    const bool on_the_way = aimed && keeper.report().error > near;
    e.tolerance = !on_the_way && (keeper.identified() || keeper.report().locked) ? tight : loose;
    return e;
}

void RunGuard::expect_another(Lanes& lanes) {
    if (!posted_) return;
    posted_->tolerance = loose;
    lanes.expectation.post(*posted_);
}

void RunGuard::look(const IdentifiedResponse& response, bool ended, double now_s, Lanes& lanes) {
    const bool axis_known = std::ranges::any_of(accelerometer_.shaker_axis, [](double u) { return u != 0; });
    if (const auto trip = loop_.check(response, axis_known, ended, tick_at(now_s))) order(*trip, lanes);
}

void RunGuard::found(Cause cause, double value, double limit, double now_s, Lanes& lanes) {
    if (!limits_.detectors[static_cast<std::size_t>(cause)]) return;
    order({.cause = cause, .on_dac_clock = true, .value = value, .limit = limit, .tick = tick_at(now_s)},
          lanes);
}

void RunGuard::look(const WalkerWatch& walker, double now_s, Lanes& lanes) {
    if (walker.lost() >= limits_.tracking_lost_frames)
        found(Cause::tracking_lost, walker.lost(), limits_.tracking_lost_frames, now_s, lanes);
    if (walker.edge_mm() && *walker.edge_mm() < limits_.edge_mm)
        found(Cause::walker_edge, *walker.edge_mm(), limits_.edge_mm, now_s, lanes);
}

void RunGuard::look(const std::vector<CameraTake>& cameras, double now_s, Lanes& lanes) {
    for (const CameraTake& c : cameras)
        if (now_s - c.until_s > limits_.camera_missing_s)
            found(Cause::camera_missing, now_s - c.until_s, limits_.camera_missing_s, now_s, lanes);
}

}  // namespace shaker
