#include "daemon/safety/predicted_motion.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::safety {

namespace {

constexpr double most_slack = 1.5;  // times the change, at the resonance of a weakly damped shaker
constexpr double sweep_slack = 8;   // times the motion; the frequency may pass a resonance

bool same_frequency(double a, double b) noexcept { return std::abs(a - b) <= 1e-9 * std::abs(b); }

}  // namespace

void PredictedMotion::expect(const Expectation& expectation) noexcept {
    if (newest_ && !same_frequency(expectation.frequency, newest_->frequency)) before_ = newest_;
    newest_ = expectation;
    mapped_ = expectation.dac_sample >= map_from_;
    predict(from_);
    predict(to_);
    weigh();
}

void PredictedMotion::hear(const DriveChange& change) noexcept {
    if (change.ramp == 0 && change.stop == 0) {  // underrun: the signal played last is unknown
        waiting_count_ = 0;
        begin(change);
        from_ = to_;
        map_from_ = first_;  // older clock maps are invalid
        mapped_ = false;
        return;
    }
    while (waiting_count_ > 0 && change.voids(waiting_[(first_waiting_ + waiting_count_ - 1) % most_waiting]))
        --waiting_count_;
    if (waiting_count_ == most_waiting) {  // no map, so no change was applied: only the newest matter
        begin(waiting_[first_waiting_]);
        first_waiting_ = (first_waiting_ + 1) % most_waiting;
        --waiting_count_;
    }
    waiting_[(first_waiting_ + waiting_count_++) % most_waiting] = change;
    if (!mapped_) frequency_ = change.command.frequency;
}

void PredictedMotion::begin(const DriveChange& change) noexcept {
    if (change.stop > 0) {
        if (change.command.sequence == 0) stopped_ = true;
        if (fade_ > 0) return;  // the drive is fading or silent already
        fade_first_ = static_cast<double>(change.first.n);
        if (change.ramp > 0) held_ = fade_first_ - first_;
        fade_ = static_cast<double>(change.stop);
        return;
    }
    const bool silent = stopped_ || fade_ > 0;
    left_ = silent ? 0 : slack_at(static_cast<double>(change.first.n) - first_);
    from_ = silent ? End{.volts = {}, .frequency = to_.frequency, .step = to_.step} : to_;
    stopped_ = false;
    fade_ = 0;
    to_ = {.volts = change.command.volts,
           .frequency = change.command.frequency,
           .step = 0x1p-64 * static_cast<double>(high_word(change.step))};
    first_ = static_cast<double>(change.first.n);
    ramp_ = held_ = static_cast<double>(change.ramp);
    phase_ = 0x1p-64 * static_cast<double>(high_word(change.phase));
    frequency_ = to_.frequency;
    predict(from_);
    predict(to_);
    weigh();
}

void PredictedMotion::predict(End& end) const noexcept {
    if (end.volts.order() == 0) {
        end.motion = {};
        end.known = true;
        return;
    }
    end.known = false;
    for (const auto* e : {&newest_, &before_}) {
        if (!*e || !same_frequency(end.frequency, (*e)->frequency)) continue;
        end.known = true;
        for (std::size_t k = 0; k < max_harmonics; ++k) end.motion[k] = (*e)->response[k] * end.volts.a[k];
        return;
    }
}

void PredictedMotion::weigh() noexcept {
    double from = 0, to = 0, between = 0;
    for (std::size_t k = 0; k < max_harmonics; ++k) {
        from += 0.5 * std::norm(from_.motion[k]);
        to += 0.5 * std::norm(to_.motion[k]);
        between += 0.5 * std::norm(to_.motion[k] - from_.motion[k]);
    }
    sweeps_ = !same_frequency(from_.frequency, to_.frequency);
    change_rms_ = std::sqrt(sweeps_ ? std::max(from, to) : between);
    order_ = std::max(from_.volts.order(), to_.volts.order());
}

// The larger of the transients of the newest change and of those before it.
double PredictedMotion::slack_at(double x) const noexcept {
    // DAC samples.
    const double settling = newest_ ? newest_->settling_s * rate_hz_ * newest_->dac_per_tick : 0;
    if (!(settling > 0)) return 0;
    double slack = 0;
    if (change_rms_ > 0) {
        slack =
            change_rms_ * (sweeps_ ? sweep_slack : std::min(most_slack, 4 * settling / std::max(ramp_, 1.0)));
        if (x > ramp_) slack *= std::exp((ramp_ - x) / (sweeps_ ? 2 * settling : settling));
    }
    return std::max(slack, left_ * std::exp(-std::max(x, 0.0) / settling));
}

// The slack of a ramp from the motion to zero.
double PredictedMotion::fade_slack(double x, double rms) const noexcept {
    const double settling = newest_->settling_s * rate_hz_ * newest_->dac_per_tick;
    if (!(settling > 0)) return 0;
    const double slack = rms * std::min(most_slack, 4 * settling / fade_);
    return x > fade_ ? slack * std::exp((fade_ - x) / settling) : slack;
}

std::optional<double> PredictedMotion::dac_sample(AccelTick tick) const noexcept {
    if (!mapped_) return std::nullopt;
    return newest_->dac_sample + newest_->dac_per_tick * static_cast<double>(tick.n - newest_->at.n);
}

std::optional<PredictedMotion::Sample> PredictedMotion::at(AccelTick tick) noexcept {
    const auto now = dac_sample(tick);
    if (!now) return std::nullopt;
    while (waiting_count_ > 0 && static_cast<double>(waiting_[first_waiting_].first.n) <= *now) {
        begin(waiting_[first_waiting_]);
        first_waiting_ = (first_waiting_ + 1) % most_waiting;
        --waiting_count_;
    }
    if (stopped_ || !to_.known || (!from_.known && std::min(*now - first_, held_) < ramp_))
        return std::nullopt;

    // Phase under a raised-cosine ramp of the frequency, in closed form.
    const double x = *now - first_;
    const double in_ramp = std::min(x, ramp_);
    const double raised = std::min(x, held_);
    const double weight = raised < ramp_ ? 0.5 - 0.5 * std::cos(std::numbers::pi * raised / ramp_) : 1;
    double turns = phase_ + from_.step * in_ramp;
    if (x < ramp_) {
        const double angle = std::numbers::pi * x / ramp_;
        turns += (to_.step - from_.step) * 0.5 * (x - ramp_ / std::numbers::pi * std::sin(angle));
    } else {
        turns += (to_.step - from_.step) * 0.5 * ramp_ + to_.step * (x - ramp_);
    }
    const double angle = two_pi * (turns - std::floor(turns));
    const double c = std::cos(angle), s = std::sin(angle);
    double re = 0, im = 0, squares = 0;
    for (auto k = static_cast<std::size_t>(order_); k-- > 0;) {
        const double a_re = from_.motion[k].real() + weight * (to_.motion[k].real() - from_.motion[k].real());
        const double a_im = from_.motion[k].imag() + weight * (to_.motion[k].imag() - from_.motion[k].imag());
        squares += a_re * a_re + a_im * a_im;
        const double sum_re = re + a_re, sum_im = im + a_im;
        re = sum_re * c - sum_im * s;
        im = sum_re * s + sum_im * c;
    }
    const double rms = std::sqrt(0.5 * squares);
    if (fade_ <= 0) return Sample{im, rms, slack_at(x)};
    const double faded = std::min((*now - fade_first_) / fade_, 1.0);
    const double left = 0.5 + 0.5 * std::cos(std::numbers::pi * faded);
    return Sample{left * im, left * rms, std::max(slack_at(x), fade_slack(*now - fade_first_, rms))};
}

}  // namespace shaker::safety
