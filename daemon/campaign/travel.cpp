#include "daemon/campaign/travel.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::campaign {

namespace {

constexpr double rounding = 1e-9;  // periods
// In gamma / (omega f): remaining error of D when the runner finds the drift steady.
constexpr double steady = 6e-5;
constexpr double least_return_gamma = paper_g;  // m/s^2; below it a walker may not move at all
constexpr int steady_periods = 7;  // with this D that it needs: six values, each from two periods

Walk exact_walk(const Drive& drive, double mu, double g, int settle_at_most) {
    Walk walk;
    try {
        const walker::WalkerLaw law{walker::coulomb(drive, mu, g)};
        const walker::SteadyState cycle = settle(law);
        walk.v_D = cycle.v_D;
        const double allowed = steady * law.velocity_scale() * law.period();
        walk.settling = steady_periods;
        for (walker::Walker walker{law};
             walk.settling < settle_at_most && std::abs(walker.advance_period() - cycle.D) > allowed;)
            ++walk.settling;
    } catch (const InputError& error) {
        walk.why = error.what();
    }
    return walk;
}

}  // namespace

std::vector<double> numbers_of(const Drive& drive) {
    std::vector<double> numbers{drive.frequency, drive.gamma, drive.rho, drive.phi};
    for (const std::complex<double>& share : drive.overtones)
        numbers.insert(numbers.end(), {share.real(), share.imag()});
    return numbers;
}

WalkPredictor::WalkPredictor(double mu, double g, int settle_at_most)
    : mu_{mu}, g_{g}, settle_at_most_{settle_at_most} {}

const Walk& WalkPredictor::at(const Drive& drive) {
    const auto [known, missing] = known_.try_emplace(numbers_of(drive));
    if (missing) known->second = exact_walk(drive, mu_, g_, settle_at_most_);
    return known->second;
}

ReturnDrives::ReturnDrives(const std::vector<Point>& points, const Timing& timing) {
    for (const Point& p : points) {
        double& gamma = gamma_.try_emplace(p.asked.drive.frequency, least_return_gamma).first->second;
        gamma = std::max(gamma, p.asked.drive.gamma);
    }
    for (const auto& [frequency, most] : timing.most_return_gamma)
        if (const auto known = gamma_.find(frequency); known != gamma_.end())
            known->second = std::min(known->second, most);
}

Drive ReturnDrives::at(int direction, double frequency) const {
    const auto known = gamma_.find(frequency);
    return {.frequency = frequency,
            .gamma = known == gamma_.end() ? least_return_gamma : known->second,
            .rho = 0.5,
            .phi = direction > 0 ? 0 : std::numbers::pi};
}

double kept_way(const Walk& walk, const Walk& back, const Timing& timing, double frequency) {
    return (timing.kept * std::abs(walk.v_D) + std::abs(back.v_D)) / frequency;
}

Travel travel(const PointSettings& point, const Walk& walk, const Timing& timing, double free_way) {
    const int asked = point.precision > 0 ? point.most_periods : point.plan.periods;
    const double frequency = point.drive.frequency;
    Travel t{.v_D = walk.v_D,
             .period_s = 1 / frequency,
             .settling = timing.drive_settles + point.plan.settle,
             .periods = asked,
             .why = walk.why};
    if (point.plan.settle == 0) t.settling = std::max(timing.drive_settles, walk.settling);
    if (!t.why.empty()) return t;
    const double step = std::abs(walk.v_D) / frequency;  // way of a period, m
    const double before = step * (t.settling + 2 * timing.ramp);
    double most = step > 0 ? std::floor((free_way - before) / step + rounding) : asked;
    if (free_way <= 0 || (most < least_pass_periods && most < asked)) {
        t.periods = 0;
        t.why = fmt::format(
            "settling and {} periods need {:.1f} mm, the free way is {:.1f} mm; a wider view, a smaller "
            "gamma or a "
            "higher frequency helps",
            least_pass_periods, 1e3 * (before + least_pass_periods * step), 1e3 * std::max(free_way, 0.0));
        return t;
    }
    const double held =
        (timing.recording_s - timing.start_s) * frequency - timing.starts - t.settling - 2 * timing.ramp;
    if (held < least_pass_periods && held < asked) {
        t.periods = 0;
        t.why = fmt::format(
            "start, settling and {} periods need {:.0f} s, a recording is ended after {:.0f} s: raise "
            "longest_recording_s",
            least_pass_periods, timing.recording_s + (least_pass_periods - held) / frequency,
            timing.recording_s);
        return t;
    }
    most = std::min(most, std::floor(held));
    const int in_a_pass = most < asked ? static_cast<int>(most) : asked;
    t.passes = (asked + in_a_pass - 1) / in_a_pass;
    t.periods = std::max((asked + t.passes - 1) / t.passes, std::min(least_pass_periods, asked));
    t.last_periods = std::max(asked - (t.passes - 1) * t.periods, std::min(least_pass_periods, asked));
    t.way = before + step * t.periods;
    return t;
}

double best_start(const Travel& travel) { return (travel.v_D < 0 ? 1 : -1) * travel.way / 2; }

Stage lead(const Travel& travel, const Timing& timing, double free_way, double& place) {
    Stage stage{.begin = place, .end = place};
    if (!travel.fits()) return stage;
    const double direction = travel.v_D < 0 ? -1 : 1;
    const double start = best_start(travel);
    const auto go_to_start = [&] {
        stage.returned += std::abs(place - start);
        stage.returning_s += timing.return_s + std::abs(place - start) / timing.return_mps;
        place = start;
    };
    if (std::abs(place + direction * travel.way) > free_way / 2) go_to_start();
    stage.begin = place;
    for (int pass = 1; pass <= travel.passes; ++pass) {
        if (pass > 1) go_to_start();
        const int periods = pass < travel.passes ? travel.periods : travel.last_periods;
        stage.settling_s += (travel.settling + timing.ramp) * travel.period_s;
        stage.measuring_s += periods * travel.period_s;
        stage.other_s += timing.result_s;
        place += travel.v_D * travel.period_s * (2 * timing.ramp + travel.settling + periods);
    }
    stage.end = place;
    return stage;
}

}  // namespace shaker::campaign
