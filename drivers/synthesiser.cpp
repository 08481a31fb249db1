#include "drivers/synthesiser.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

// Samples are computed in this many lanes, which the compiler turns into vector instructions. Each lane
// does the arithmetic of a single sample.
constexpr std::size_t channels = 8;
using Channels = std::array<double, channels>;
using Phases = std::array<std::uint64_t, channels>;

/// Cosine and sine of phase / 2^64 turns, error below 2e-16. The C library's functions differ in the last
/// bit between processors. Taylor terms up to x^16 suffice up to an eighth of a turn.
void unit_circle(const Phases& phase, Channels& cosine, Channels& sine) noexcept {
    constexpr auto inverse_factorial = [] {
        std::array<double, 17> a{1};
        double product = 1;
        for (std::size_t n = 1; n < a.size(); ++n) a[n] = 1 / (product *= static_cast<double>(n));
        return a;
    }();
    Channels x;
    Channels quarter;
    for (std::size_t i = 0; i < channels; ++i) {
        const std::uint64_t nearest = (phase[i] + (std::uint64_t{1} << 61)) >> 62;
        x[i] =
            static_cast<double>(static_cast<std::int64_t>(phase[i] - (nearest << 62))) * (two_pi * 0x1p-64);
        quarter[i] = static_cast<double>(nearest & 3);
    }
    for (std::size_t i = 0; i < channels; ++i) {
        const double minus_square = -x[i] * x[i];
        double c = inverse_factorial[16];
        double s = inverse_factorial[15];
        for (std::size_t n = 14; n >= 2; n -= 2) {
            c = c * minus_square + inverse_factorial[n];
            s = s * minus_square + inverse_factorial[n - 1];
        }
        c = c * minus_square + 1;
        s *= x[i];
        const bool odd = quarter[i] == 1 || quarter[i] == 3;
        const double c_turned = odd ? s : c;
        const double s_turned = odd ? c : s;
        cosine[i] = quarter[i] == 1 || quarter[i] == 2 ? -c_turned : c_turned;
        sine[i] = quarter[i] >= 2 ? -s_turned : s_turned;
    }
}

constexpr std::uint64_t half_turn = std::uint64_t{1} << 63;

/// Cosine of an angle that advances by `step` per sample, for the samples from `first` on.
void cosines(std::uint64_t from, std::uint64_t step, std::int64_t first, Channels& cosine) noexcept {
    Phases phase;
    for (std::size_t i = 0; i < channels; ++i)
        phase[i] = from + (static_cast<std::uint64_t>(first) + i) * step;
    Channels sine;
    unit_circle(phase, cosine, sine);
}

/// Raised cosine from 0 at sample 0 of the ramp towards 1 at sample `ramp`, for the samples from `first` on.
void ramp_weights(std::int64_t first, std::int64_t ramp, Channels& weight) noexcept {
    cosines(0, half_turn / static_cast<std::uint64_t>(ramp), first, weight);
    for (double& w : weight) w = 0.5 - 0.5 * w;
}

/// Phase per sample, the share `weight` of the way from one step to the other, rounded to 2^-64 turn.
Turns step_between(Turns from, Turns to, double weight) noexcept {
    const auto difference = static_cast<double>(static_cast<std::int64_t>(high_word(to) - high_word(from)));
    return from + turns_of(static_cast<std::uint64_t>(static_cast<std::int64_t>(weight * difference)), 0);
}

/// Im sum_q a_q z^q by Horner's rule, where coefficient(q - 1, lane) is a_q in that lane.
template <class Coefficient>
void evaluate(int order, const Phases& phase, Channels& volts, Coefficient coefficient) noexcept {
    Channels c;
    Channels s;
    unit_circle(phase, c, s);
    Channels re{};
    volts.fill(0);
    for (int q = order; q >= 1; --q) {
        for (std::size_t i = 0; i < channels; ++i) {
            const auto [a_re, a_im] = coefficient(static_cast<std::size_t>(q - 1), i);
            const double sum_re = re[i] + a_re;
            const double sum_im = volts[i] + a_im;
            re[i] = sum_re * c[i] - sum_im * s[i];
            volts[i] = sum_re * s[i] + sum_im * c[i];
        }
    }
}

struct Complex {
    double re;
    double im;
};

/// At least one period in 2^32 samples, and every harmonic below half the rate.
bool playable(double frequency, int order, double rate_hz) noexcept {
    return frequency >= rate_hz * 0x1p-32 && frequency * std::max(order, 1) < rate_hz / 2;
}

/// Finite, and small enough that the sums do not overflow.
bool finite(const Harmonics<Voltage>& volts) noexcept {
    double sum = 0;
    for (const auto& a : volts.a) sum += std::abs(a.real()) + std::abs(a.imag());
    return std::isfinite(4 * sum);
}

}  // namespace

std::vector<DriveChange> in_effect(std::vector<DriveChange> changes) {
    std::vector<DriveChange> made;
    for (const DriveChange& c : changes) {
        while (!made.empty() && c.voids(made.back())) made.pop_back();
        made.push_back(c);
    }
    return made;
}

std::size_t in_force_at(std::span<const DriveChange> changes, double dac_sample) {
    auto void_from = std::numeric_limits<std::int64_t>::max();
    for (std::size_t i = changes.size(); i-- > 0;) {
        const DriveChange& c = changes[i];
        if (c.first.n >= void_from) continue;
        if (static_cast<double>(c.end().n) <= dac_sample) return i;
        if (c.taken_back > 0) void_from = c.first.n;
    }
    return 0;
}

Synthesiser::Synthesiser(double rate_hz, double frequency, double limit_V)
    : rate_hz_{rate_hz}, limit_V_{limit_V}, next_limit_V_{limit_V}, step_{0}, last_step_{1} {
    if (!(rate_hz > 0 && std::isfinite(rate_hz)))
        throw InputError{"sample rate " + std::to_string(rate_hz) + " Hz: must be positive"};
    if (!playable(frequency, 1, rate_hz))
        throw InputError{"frequency " + std::to_string(frequency) + " Hz: must be at least " +
                         std::to_string(rate_hz * 0x1p-32) + " and below " + std::to_string(rate_hz / 2) +
                         " Hz"};
    if (!(limit_V > 0 && std::isfinite(limit_V)))
        throw InputError{"voltage limit " + std::to_string(limit_V) + " V: must be positive"};
    step_ = turns_per_sample(frequency, rate_hz);
    change_.command.frequency = frequency;
}

void Synthesiser::set(const DriveCommand& command) noexcept {
    if (stopping_ && tick_.n == stop_first_.n + stop_samples_) end_stop();
    if (command.stop_s > 0) reported_.reset();  // a refused stop is not reported
    if (command.stop_s > 0 && !stopped_ && std::isfinite(command.stop_s)) {
        begin_stop(std::llround(command.stop_s * rate_hz_), command.sequence, false);
    } else if (!stopped_ && !stopping_ && finite(command.volts) && command.ramp_periods >= 1 &&
               playable(command.frequency, command.volts.order(), rate_hz_)) {
        pending_ = command;
    } else {
        ++refused_;
    }
}

void Synthesiser::limit(double limit_V) noexcept {
    if (!(limit_V > 0 && std::isfinite(limit_V))) return;
    next_limit_V_ = limit_V;
    if (std::abs(last_V_) <= limit_V) limit_V_ = limit_V;
}

void Synthesiser::fill(std::span<double> volts) noexcept {
    reported_.reset();
    while (!volts.empty()) {
        const auto n = next_stretch(static_cast<std::int64_t>(volts.size()));
        const auto stretch = volts.first(static_cast<std::size_t>(n));
        if (ramping_)
            fill_ramp(stretch);
        else
            fill_steady(stretch);
        volts = volts.subspan(stretch.size());
    }
}

void Synthesiser::skip(std::int64_t samples) noexcept {
    reported_.reset();
    while (samples > 0) {
        const std::int64_t n = next_stretch(samples);
        if (ramping_) {
            skip_ramp(n);
        } else {
            phase_ += static_cast<Turns>(n) * step_;
            last_step_ = step_;
            tick_.n += n;
        }
        samples -= n;
    }
}

void Synthesiser::silence(std::int64_t samples) noexcept {
    pending_.reset();
    skip(samples);
    if (ramping_) end_ramp();
    volts_ = {};
    order_ = 0;
    last_V_ = 0;
    limit_V_ = next_limit_V_;
    stopping_ = false;
    change_ = {{.volts = {}, .frequency = change_.command.frequency}, tick_, 0, phase_, step_};
    reported_ = change_;
}

void Synthesiser::stop(std::int64_t samples, bool ramp_goes_on) noexcept {
    reported_.reset();
    if (!stopped_ || stopping_) begin_stop(samples, 0, ramp_goes_on);
    stopped_ = true;
}

// The volts of this moment are those of both ends of the ramp.
void Synthesiser::hold_ramp() noexcept {
    Channels weight;
    ramp_weights(tick_.n - change_.first.n, change_.ramp, weight);
    for (std::size_t q = 0; q < max_harmonics; ++q)
        volts_.a[q] += weight[0] * (change_.command.volts.a[q] - volts_.a[q]);
    change_.command.volts = volts_;
}

void Synthesiser::begin_stop(std::int64_t samples, std::uint64_t sequence, bool ramp_goes_on) noexcept {
    samples = std::max<std::int64_t>(samples, 1);
    pending_.reset();
    const bool earlier = stopping_ && tick_.n + samples < stop_first_.n + stop_samples_;
    if (stopping_ && !earlier) return;
    if (earlier) {
        const std::uint64_t step = (half_turn - stop_angle_) / static_cast<std::uint64_t>(stop_samples_);
        stop_angle_ += static_cast<std::uint64_t>(tick_.n - stop_first_.n) * step;
    } else {
        stop_angle_ = 0;
    }
    stopping_ = true;
    stop_first_ = tick_;
    stop_samples_ = samples;
    const bool holds = ramping_ && !ramp_goes_on;
    if (holds) hold_ramp();
    reported_ = {{.volts = {}, .frequency = change_.command.frequency, .sequence = sequence},
                 tick_,
                 holds ? samples : 0,
                 phase_,
                 ramping_ ? change_.step : step_,
                 samples};
}

void Synthesiser::go_back(const Synthesiser& earlier, std::span<double> volts) noexcept {
    const Synthesiser now = *this;
    *this = earlier;
    fill(volts);
    clamped_ = now.clamped_;
    largest_clamped_ = now.largest_clamped_;
    refused_ = now.refused_;
    limit(now.next_limit_V_);
}

bool Synthesiser::release() noexcept {
    if (stopping_ && tick_.n == stop_first_.n + stop_samples_) end_stop();
    if (stopping_) return false;
    stopped_ = false;
    return true;
}

std::int64_t Synthesiser::next_stretch(std::int64_t wanted) noexcept {
    if (stopping_) {
        if (tick_.n == stop_first_.n + stop_samples_)
            end_stop();
        else
            wanted = std::min(wanted, stop_first_.n + stop_samples_ - tick_.n);
    }
    if (ramping_ && tick_.n == change_.first.n + change_.ramp) end_ramp();
    if (ramping_) return std::min(wanted, change_.first.n + change_.ramp - tick_.n);
    if (!pending_) return wanted;
    if (phase_ < last_step_) {
        begin_change();
        return std::min(wanted, change_.ramp);
    }
    // The phase wraps after 2^128 - phase_, which is -phase_ in unsigned arithmetic; phase_ is not 0
    // here.
    const Turns to_wrap = (-phase_ - 1) / step_ + 1;
    return std::min(wanted, static_cast<std::int64_t>(to_wrap));
}

void Synthesiser::begin_change() noexcept {
    const double period = 0x1p128 / static_cast<double>(step_);
    change_ = {*pending_, tick_, std::llround(pending_->ramp_periods * period), phase_,
               turns_per_sample(pending_->frequency, rate_hz_)};
    order_ = std::max(volts_.order(), change_.command.volts.order());
    pending_.reset();
    reported_ = change_;
    ramping_ = true;
}

void Synthesiser::end_ramp() noexcept {
    volts_ = change_.command.volts;
    order_ = volts_.order();
    step_ = change_.step;
    ramping_ = false;
}

// A ramp of the frequency continues to its end; only the volts become zero.
void Synthesiser::end_stop() noexcept {
    stopping_ = false;
    volts_ = {};
    change_.command.volts = {};
    order_ = 0;
    limit_V_ = next_limit_V_;
}

void Synthesiser::fill_steady(std::span<double> volts) noexcept {
    for (std::size_t done = 0; done < volts.size(); done += channels) {
        Phases phase;
        for (std::size_t i = 0; i < channels; ++i) phase[i] = high_word(phase_ + i * step_);
        Channels block;
        evaluate(order_, phase, block, [this](std::size_t q, std::size_t) {
            return Complex{volts_.a[q].real(), volts_.a[q].imag()};
        });
        const std::size_t n = std::min(channels, volts.size() - done);
        put(block, volts.subspan(done, n));
        phase_ += n * step_;
    }
    last_step_ = step_;
}

void Synthesiser::fill_ramp(std::span<double> volts) noexcept {
    std::array<Complex, max_harmonics> from;
    std::array<Complex, max_harmonics> change;
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        from[q] = {volts_.a[q].real(), volts_.a[q].imag()};
        const auto difference = change_.command.volts.a[q] - volts_.a[q];
        change[q] = {difference.real(), difference.imag()};
    }
    for (std::size_t done = 0; done < volts.size(); done += channels) {
        const std::size_t n = std::min(channels, volts.size() - done);
        Channels weight;
        ramp_weights(tick_.n - change_.first.n, change_.ramp, weight);
        Phases phase{};
        for (std::size_t i = 0; i < n; ++i) {
            phase[i] = high_word(phase_);
            last_step_ = step_between(step_, change_.step, weight[i]);
            phase_ += last_step_;
        }
        Channels block;
        evaluate(order_, phase, block, [&](std::size_t q, std::size_t i) {
            return Complex{from[q].re + weight[i] * change[q].re, from[q].im + weight[i] * change[q].im};
        });
        put(block, volts.subspan(done, n));
    }
}

void Synthesiser::skip_ramp(std::int64_t samples) noexcept {
    for (std::int64_t done = 0; done < samples; done += channels) {
        Channels weight;
        ramp_weights(tick_.n - change_.first.n, change_.ramp, weight);
        const auto n = std::min(static_cast<std::int64_t>(channels), samples - done);
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
            last_step_ = step_between(step_, change_.step, weight[i]);
            phase_ += last_step_;
        }
        tick_.n += n;
    }
}

/// Copies the first samples of a block out, multiplied by the weight of a stop and cut at the limit.
void Synthesiser::put(std::span<const double> block, std::span<double> volts) noexcept {
    for (std::size_t i = 0; i < volts.size(); ++i) {
        const double cut = std::clamp(block[i], -limit_V_, limit_V_);
        if (cut != block[i]) {
            ++clamped_;
            largest_clamped_ = std::max(largest_clamped_, std::abs(block[i]));
        }
        volts[i] = cut;
    }
    if (stopping_) {
        Channels weight;
        cosines(stop_angle_, (half_turn - stop_angle_) / static_cast<std::uint64_t>(stop_samples_),
                tick_.n - stop_first_.n, weight);
        for (std::size_t i = 0; i < volts.size(); ++i) volts[i] *= 0.5 + 0.5 * weight[i];
    }
    if (!volts.empty()) last_V_ = volts.back();
    tick_.n += static_cast<std::int64_t>(volts.size());
}

double Synthesiser::realised(double frequency, double rate_hz) noexcept {
    return static_cast<double>(static_cast<long double>(turns_per_sample(frequency, rate_hz)) * 0x1p-128L *
                               rate_hz);
}

}  // namespace shaker
