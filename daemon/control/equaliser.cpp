#include "daemon/control/equaliser.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace shaker::control {

namespace {
constexpr std::size_t judged_windows = 10;
constexpr int longest_wait = 40;  // windows for a change to settle
constexpr int most_blocks = 40;   // at one level
constexpr int fresh_blocks = 15;  // after this many the plant is reset to the identified response
constexpr double much_worse = 3, least_harm = 0.03;  // times the previous error; of the target
constexpr double slightly_worse = 1.1;
constexpr int most_worse = 1;                          // consecutive steps
constexpr double near_enough = 0.3, small_step = 0.1;  // of the target
// Of the target; less is the last of the approach, where plants are least linear.
constexpr double least_event = 0.01;
constexpr double least_motion = 0.05;  // of the motion expected of the drive
constexpr double noisy = 3e-4;         // of gamma; above it the pace is halved
constexpr double fastest = 0.25;       // share of the error corrected per window
constexpr int known_worth = 50;        // windows that a drive is worth that was locked before
constexpr double as_predicted = 0.1;   // of a known drive's norm

template <class Unit>
Harmonics<Unit> combined(const Harmonics<Unit>& x, const Harmonics<Unit>& y, double factor) {
    Harmonics<Unit> sum = x;
    for (std::size_t q = 0; q < max_harmonics; ++q) sum.a[q] += factor * y.a[q];
    return sum;
}

template <class Unit>
Harmonics<Unit> scaled(Harmonics<Unit> h, double factor) {
    for (auto& a : h.a) a *= factor;
    return h;
}

double sum_of_amplitudes(const Harmonics<Acceleration>& h) {
    double sum = 0;
    for (const auto& a : h.a) sum += std::abs(a);
    return sum;
}

bool finite(const PeriodWindow& w) {
    return std::isfinite(w.sd) &&
           std::ranges::all_of(w.measured.a, [](const auto& a) { return std::isfinite(std::abs(a)); });
}
}  // namespace

double peak(const Harmonics<Voltage>& volts) {
    constexpr int points = 512;
    double largest = 0;
    double before = value_at(volts, -two_pi / points), here = value_at(volts, 0);
    for (int i = 0; i < points; ++i) {
        const double after = value_at(volts, two_pi * (i + 1) / points);
        const double curve = before - 2 * here + after, slope = 0.5 * (after - before);
        const bool turning = std::abs(slope) < std::abs(curve);
        largest = std::max(largest, std::abs(turning ? here - 0.5 * slope * slope / curve : here));
        before = here;
        here = after;
    }
    return largest;
}

Equaliser::Equaliser(const Harmonics<Acceleration>& target,
                     const std::array<std::complex<double>, max_harmonics>& response,
                     const EqualiserSettings& settings)
    : settings_{settings},
      target_{target},
      gamma_{sum_of_amplitudes(target)},
      plant_{settings.harmonics, response},
      first_{plant_},
      level_{settings.from_below ? 0 : settings.levels.size() - 1},
      limit_V_{settings.volts_limit} {
    volts_ = plant_.drive(aim());
    keep_within_limit();
}

Harmonics<Acceleration> Equaliser::aim() const {
    return scaled(target_, settings_.levels[level_] * reached_);
}

Harmonics<Acceleration> Equaliser::error_of(const Harmonics<Acceleration>& measured) const {
    Harmonics<Acceleration> wanted = aim(), seen = measured;
    for (const int q : settings_.hidden)
        if (wanted.at(q) == 0.0) seen.at(q) = 0;
    return combined(turned(wanted, best_lag(wanted, seen)), seen, -1);
}

// Scales drive and target together: the shape stays, gamma is reduced and reported. This also keeps the
// integral from winding up at the limit.
void Equaliser::keep_within_limit() {
    const double share = peak(volts_) / limit_V_;
    if (share > 1) {
        volts_ = scaled(volts_, 1 / share);
        drift_ = scaled(drift_, 1 / share);
        reached_ /= share;
    } else if (reached_ < 1 && share < 0.9 && !unreachable_) {
        reached_ = std::min(1.0, 1.02 * reached_);
    }
}

Equaliser::Report Equaliser::take(const PeriodWindow& window) {
    Report report;
    const double noise = settings_.noise > 0 ? settings_.noise : window.sd;
    if (finite(window) && gamma_ > 0 && mode_ != Mode::failed) {
        const Harmonics<Acceleration> error = error_of(window.measured);
        report.error = norm(error, settings_.harmonics) / norm(aim(), settings_.harmonics);
        judge(error, noise, report);
        report.no_motion = !moves(window, noise);
        if (report.no_motion)
            before_.reset();
        else if (mode_ == Mode::track)
            track(window, error, noise, report);
        else if (window.steady)
            converge(window, noise);
    }
    report.mode = mode_;
    report.level = settings_.levels[level_] * reached_;
    report.reached = reached_;
    report.noise = noise / gamma_;
    report.unreachable = unreachable_;
    report.gain = gain_;
    return report;
}

bool Equaliser::moves(const PeriodWindow& window, double noise) const {
    const int k = settings_.harmonics;
    const double must = norm(plant_.motion(window.volts), k);
    return norm(window.measured, k) >= least_motion * must || must < 10 * noise * std::sqrt(2.0 * k);
}

void Equaliser::judge(const Harmonics<Acceleration>& error, double noise, Report& report) {
    errors_.push_back(error);
    if (errors_.size() > judged_windows) errors_.pop_front();
    const auto n = static_cast<double>(errors_.size());
    const double spread = 3 * noise / std::sqrt(0.5 * n);  // three sd of the mean of a complex amplitude
    const double gamma = gamma_ * settings_.levels[level_] * reached_;
    report.locked = mode_ == Mode::track && errors_.size() == judged_windows;
    for (int q = 1; q <= settings_.harmonics; ++q) {
        std::complex<double> mean = 0;
        for (const auto& e : errors_) mean += e.at(q) / n;
        report.residual[static_cast<std::size_t>(q - 1)] = std::abs(mean) / gamma;
        const double own = std::abs(target_.at(q)) * gamma / gamma_;
        const double allowed = kept_within * (own > 0 ? own : gamma);
        report.noise_limited = report.noise_limited || spread > allowed;
        report.locked = report.locked && std::abs(mean) < std::max(allowed, spread);
    }
}

// Waits until a change has died away, then averages a block: one window, four when noise matters.
void Equaliser::converge(const PeriodWindow& window, double noise) {
    ++waited_;
    const double root = std::sqrt(2.0 * settings_.harmonics);
    const double size = norm(error_of(window.measured), settings_.harmonics);
    const double still = std::max({2 * noise * root, 0.05 * size, 1e-4 * norm(aim(), settings_.harmonics)});
    const bool settled =
        before_ && norm(combined(window.measured, *before_, -1), settings_.harmonics) <= still;
    before_ = window.measured;
    if (!settled && waited_ < longest_wait) {
        sum_ = {};  // earlier windows belong to another state of the plant
        summed_ = 0;
        return;
    }
    sum_ = combined(sum_, window.measured, 1);
    ++summed_;
    if (size < 7 * noise * root && summed_ < 4) return;
    const Block block{volts_, scaled(sum_, 1.0 / summed_)};
    step(block, noise / std::sqrt(summed_));
    before_.reset();
    sum_ = {};
    waited_ = summed_ = 0;
}

void Equaliser::step(const Block& block, double noise) {
    const int k = settings_.harmonics;
    if (!std::exchange(delay_measured_, true))
        measure_delay(block, noise);
    else if (last_)
        learn(combined(block.volts, last_->volts, -1), combined(block.measured, last_->measured, -1), noise);
    last_ = block;
    double size = norm(error_of(block.measured), k);
    const bool top = level_ + 1 == settings_.levels.size();
    // With an error this small the target is not out of reach, or its known drive is still valid.
    const double near = known_ || blocks_ >= most_blocks ? 0.01 : 3e-3;
    if (top && size < std::max(near * norm(aim(), k), 3.5 * noise * std::sqrt(2.0 * k))) {
        mode_ = Mode::track;
        good_ = {volts_, plant_, settings_.levels[level_]};
        drift_ = {};
        far_ = 0;
        const auto same_drive = static_cast<std::size_t>(known_ ? summed_ : 0);
        while (errors_.size() > same_drive) errors_.pop_front();
        if (known_) return;
        volts_ = combined(volts_, plant_.drive(error_of(block.measured)), 1);
        keep_within_limit();
        followed_ = summed_;
        return;
    }
    known_ = false;
    if (!top && size < 0.15 * norm(aim(), k)) {
        good_ = {volts_, plant_, settings_.levels[level_]};
        ++level_;
        blocks_ = 0;
        last_error_ = INFINITY;
        size = norm(error_of(block.measured), k);
    } else if (does_harm(size) && blocks_ < most_blocks) {
        // Takes the step back and resets the plant to the identified response. Not repeated when
        // it does not help: then the step was not the cause.
        ++blocks_;
        worse_ = 0;
        last_error_ = size;
        volts_ = before_step_;
        plant_ = first_;
        share_ = 0.5;
        last_.reset();
        return;
    } else {
        share_ = size > 1.3 * last_error_ ? std::max(0.25, 0.5 * share_) : std::min(1.0, 1.5 * share_);
        last_error_ = size;
        if (++blocks_ > most_blocks) return fall_back();
        if (blocks_ % fresh_blocks == 0) plant_ = first_;  // the learned plant does not converge
    }
    before_step_ = block.volts;
    Harmonics<Voltage> change = plant_.drive(error_of(block.measured));
    const double most = norm(volts_, k) / std::max(norm(change, k), 1e-300);
    volts_ = combined(volts_, change, std::min(share_, most));
    if (good_ && peak(volts_) > 2 * settings_.levels[level_] / good_->level * peak(good_->volts))
        return fall_back();
    keep_within_limit();
}

// True if the error rose much in one step, or a little in several.
bool Equaliser::does_harm(double size) {
    worse_ = size > slightly_worse * last_error_ ? worse_ + 1 : 0;
    return size > least_harm * norm(aim(), settings_.harmonics) &&
           (size > much_worse * last_error_ || worse_ > most_worse);
}

// A small step after which the base moved very differently from the prediction shows another change during
// the step (such as a walker put on the base); the plant does not learn from it.
void Equaliser::learn(const Harmonics<Voltage>& stepped, Harmonics<Acceleration> moved, double noise) {
    const int k = settings_.harmonics;
    const Harmonics<Acceleration> predicted = plant_.motion(stepped);
    for (const int q : settings_.hidden) moved.at(q) = predicted.at(q);
    const double size = norm(predicted, k), off = norm(combined(moved, predicted, -1), k),
                 all = norm(aim(), k);
    if (off > 1.5 * size && size < small_step * all && norm(moved, k) > least_event * all) return;
    gain_ *= plant_.learn(stepped, moved, noise);
}

// A known drive is held from its first window on; it is judged when the walker has come nearer to its motion.
void Equaliser::track(const PeriodWindow& window, const Harmonics<Acceleration>& error, double noise,
                      Report& report) {
    const bool unjudged = known_ && errors_.size() < judged_windows;
    if (!(unjudged || (report.locked && (hold_ || known_)))) {
        ++followed_;
        averaged_ = report.locked ? averaged_ + 1 : std::min(followed_, static_cast<int>(judged_windows));
        held_windows_ = 0;
        holds_ = known_ = false;
        follow(window, noise);
        if (!report.locked) mean_ = volts_;
        return;
    }
    if (!known_ && !std::exchange(holds_, true)) {
        volts_ = mean_;
        held_.begin(averaged_);
    }
    if (!window.steady) return;
    report.held = ++held_windows_;
    if (unjudged || !held_.add(error, noise, settings_.harmonics)) return;
    report.held = held_windows_ = 0;
    volts_ = combined(volts_, plant_.drive(held_.correction()), 1);
    keep_within_limit();
}

// Delay compensated: the error belongs to the drive of its window, so corrections that are still under way
// are not made twice. The integral `drift_` removes the lag behind a steady change of the plant.
void Equaliser::follow(const PeriodWindow& window, double noise) {
    const Harmonics<Acceleration> error = error_of(window.measured);
    const Harmonics<Voltage> correction = plant_.drive(error), right = combined(window.volts, correction, 1);
    mean_ = combined(mean_, combined(right, mean_, -1), 1.0 / std::min(averaged_, longest_hold));
    const double pace = settings_.pace * (noise > noisy * gamma_ * reached_ ? 0.5 : 1);
    const double mu = std::max(pace, std::min(1.0 / followed_, fastest));
    drift_ = combined(drift_, correction, 0.2 * pace * pace);
    volts_ = combined(combined(scaled(volts_, 1 - mu), right, mu), drift_, 1);
    keep_within_limit();
    const double size = norm(error, settings_.harmonics), all = norm(aim(), settings_.harmonics);
    Harmonics<Acceleration> mean;
    for (const auto& e : errors_) mean = combined(mean, e, 1.0 / static_cast<double>(errors_.size()));
    far_ = size > std::max(0.02 * all, 8.5 * noise * std::sqrt(2.0 * settings_.harmonics)) ? far_ + 1 : 0;
    if (far_ >= 3 || (errors_.size() == judged_windows && norm(mean, settings_.harmonics) > 0.01 * all))
        enter_converge();
}

void Equaliser::enter_converge() {
    mode_ = Mode::converge;
    level_ = settings_.levels.size() - 1;
    drift_ = {};
    last_.reset();
    before_.reset();
    sum_ = {};
    waited_ = summed_ = blocks_ = followed_ = averaged_ = held_windows_ = far_ = 0;
    holds_ = known_ = false;
    share_ = 1;
    last_error_ = INFINITY;
    worse_ = 0;
    errors_.clear();
}

// More drive gave no more motion, or the wrong shape: returns to the last drive that worked and holds it.
void Equaliser::fall_back() {
    // A drive that came near the target is safe to hold.
    if (!good_ && last_error_ < near_enough * norm(aim(), settings_.harmonics))
        good_ = {before_step_, first_, settings_.levels[level_]};
    if (!good_) {
        mode_ = Mode::failed;
        volts_ = {};
        return;
    }
    volts_ = good_->volts;
    plant_ = good_->plant;
    reached_ *= good_->level;
    level_ = settings_.levels.size() - 1;
    limit_V_ = 1.05 * peak(volts_);
    unreachable_ = true;
    enter_converge();
    mode_ = Mode::track;
}

void Equaliser::limit(double volts) {
    settings_.volts_limit = volts;
    limit_V_ = unreachable_ ? std::min(limit_V_, volts) : volts;
    keep_within_limit();
}

void Equaliser::retarget(const Harmonics<Acceleration>& target, const Harmonics<Voltage>* known) {
    const Harmonics<Acceleration> before = aim();
    const double worked = gamma_ * settings_.levels[level_] * reached_;
    target_ = target;
    gamma_ = sum_of_amplitudes(target);
    level_ = settings_.levels.size() - 1;
    // The reachable share of another target does not apply to this one.
    reached_ = 1;
    unreachable_ = false;
    limit_V_ = settings_.volts_limit;
    // A plant learned near one target may be wrong far from it: uses the one of learned and identified
    // that predicts the present motion better.
    const auto misfit = [&](const PlantMatrix& plant) {
        const Harmonics<Acceleration> predicted = plant.motion(volts_);
        return norm(combined(turned(before, best_lag(before, predicted)), predicted, -1),
                    settings_.harmonics);
    };
    if (misfit(first_) < misfit(plant_)) plant_ = first_;
    // The old motion has a lag in the frame of the plant; the new target keeps it.
    const double lag = best_lag(before, plant_.motion(volts_));
    volts_ = combined(volts_, plant_.drive(combined(turned(aim(), lag), turned(before, lag), -1)), 1);
    if (good_) {  // the last good drive holds up to its gamma, in the new shape as predicted by the plant
        const double share = gamma_ > worked ? worked / gamma_ : 1;
        good_ = {scaled(volts_, share), plant_, share};
    }
    const int k = settings_.harmonics;
    const double predicted = norm(volts_, k);
    const bool use = known != nullptr && std::abs(norm(*known, k) - predicted) < as_predicted * predicted;
    if (use) volts_ = *known;
    keep_within_limit();
    enter_converge();
    hold_ = false;
    known_ = use;
    held_.begin(known_worth);
}

}  // namespace shaker::control
