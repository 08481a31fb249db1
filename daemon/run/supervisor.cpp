#include "daemon/run/supervisor.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::run {

namespace {
constexpr double strong = 0.1;  // of the largest harmonic: then its own ratio of motion to drive is known
constexpr double loose =
    0.6;  // tolerance while the response is a data sheet's, being found out, or of another target
constexpr double tight = 0.3;          // and once it was measured
constexpr double near = 0.1;           // of the target: the loop's error when it has nearly arrived
constexpr double clear_of_noise = 30;  // sd
constexpr double same = 0.1;           // of the motion, that it may differ from the window before
constexpr double least_gravity = 0.5;  // m/s^2; a sensor that shows less has no constant part, but an offset
constexpr double most_gravity_off = 0.4;  // share of it
// Clear of the noise: its axis and its ratio to the drive mean something.
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
    if (ordered_) return;
    ordered_ = true;
    if (!channels.ordered.push(trip)) ++channels.lost.trips_lost;
}

void Supervisor::look_at_rest(const control::PeriodWindows::Window& window, acquisition::Channels& channels) {
    const auto& g = window.estimate.mean;
    const double seen = std::hypot(g[0], g[1], g[2]), share = seen / gravity_;
    if (seen < least_gravity || std::abs(share - 1) < most_gravity_off) return;
    if (!limits_.detectors[static_cast<std::size_t>(safety::Cause::gravity)]) return;
    order({.cause = safety::Cause::gravity,
           .on_dac_clock = true,
           .value = share,
           .limit = 1 + most_gravity_off,
           .tick = tick_at(window.to_s)},
          channels);
}

void Supervisor::look(const control::PeriodWindows::Window& window,
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
             moves(window, controller.noise()) &&  // also under small corrections, which never end
             distance(window.motion.measured, before_) <
                 same * control::norm(window.motion.measured, control::controlled_harmonics)) {
        posted_ = expectation(window, judged.target, controller, timebase, tick, channels.warnings);
        channels.expectation.post(*posted_);
    }
    before_ = window.motion.measured;
}

// The ratio of motion to drive where the motion is strong and meant, the response elsewhere: what is weak, or
// in no target, may be the plant's own distortion or the walker's, which the drive takes away.
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
    e.dac_sample = dac_rate_hz_ * seconds(timebase.at(tick));
    e.dac_per_tick = clocks_.look(timebase, tick, warnings);
    e.sigma = controller.noise() * std::sqrt(0.5 * window.estimate.samples);
    // On the way to a target a walker may take the place of what the drive is about to change.
    const bool on_the_way = aimed && controller.report().error > near;
    e.tolerance = !on_the_way && (controller.identified() || controller.report().locked) ? tight : loose;
    return e;
}

void Supervisor::expect_another(acquisition::Channels& channels) {
    if (!posted_) return;
    posted_->tolerance = loose;
    channels.expectation.post(*posted_);
}

void Supervisor::look(const control::IdentifiedResponse& response, bool ended, double now_s,
                      acquisition::Channels& channels) {
    const bool axis_known = std::ranges::any_of(accelerometer_.shaker_axis, [](double u) { return u != 0; });
    if (const auto trip = loop_.check(response, axis_known, ended, tick_at(now_s))) order(*trip, channels);
}

void Supervisor::found(safety::Cause cause, double value, double limit, double now_s,
                       acquisition::Channels& channels) {
    if (!limits_.detectors[static_cast<std::size_t>(cause)]) return;
    order({.cause = cause, .on_dac_clock = true, .value = value, .limit = limit, .tick = tick_at(now_s)},
          channels);
}

void Supervisor::look(const WalkerMonitor& walker, double now_s, acquisition::Channels& channels) {
    if (walker.lost() >= limits_.tracking_lost_frames)
        found(safety::Cause::tracking_lost, walker.lost(), limits_.tracking_lost_frames, now_s, channels);
    if (walker.edge_mm() && *walker.edge_mm() < limits_.edge_mm)
        found(safety::Cause::walker_edge, *walker.edge_mm(), limits_.edge_mm, now_s, channels);
}

void Supervisor::look(const std::vector<acquisition::CameraStream>& cameras, double now_s,
                      acquisition::Channels& channels) {
    for (const acquisition::CameraStream& c : cameras)
        if (now_s - c.until_s > limits_.camera_missing_s)
            found(safety::Cause::camera_missing, now_s - c.until_s, limits_.camera_missing_s, now_s,
                  channels);
}

}  // namespace shaker::run
