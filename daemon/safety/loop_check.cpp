#include "daemon/safety/loop_check.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/control/equaliser.hpp"
#include "daemon/safety/limits.hpp"

namespace shaker::safety {

namespace {

constexpr double share = 0.05;      // of the target
constexpr double clear = 10;        // times the noise
constexpr double most_mps2 = 0.5;   // peak; the walker begins to slip at mu g
constexpr double free_share = 0.5;  // of the response at the highest level; below it the base sticks
constexpr double sure = 3;          // errors
constexpr double most_error = 0.2;  // of the expected motion
constexpr double least_gain = 0.6, most_gain = 1.6;     // of an identified response
constexpr double least_alone = 0.8, most_alone = 1.25;  // of any, when nothing else shows the sensor's gain

double peak_of(const Harmonics<Acceleration>& a) {
    double largest = 0;
    for (int i = 0; i < 512; ++i) largest = std::max(largest, std::abs(value_at(a, two_pi * i / 512)));
    return largest;
}

// x as a multiple of `of`, by least squares over the harmonics.
std::complex<double> relative(const auto& x, const auto& of) {
    std::complex<double> sum = 0;
    double squares = 0;
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        sum += std::conj(of[q]) * x[q];
        squares += std::norm(of[q]);
    }
    return squares > 0 ? sum / squares : 1.0;
}

/// Drive and response of the check relative to the target's drive and the response in use.
struct LowLevel {
    double drive = 0;
    std::complex<double> response = 1;
};

LowLevel low_level(const LoopCheckPlan& plan, double full_V) {
    const double full = peak_of(plan.target);
    const double wanted = std::min(std::max(share * full, clear * plan.noise), most_mps2);
    LowLevel low{std::min(1.0, full > 0 ? wanted / full : 0)};
    if (plan.identified == nullptr) return low;
    for (const control::IdentifiedLevel& level : plan.identified->levels) {
        const std::complex<double> response = relative(level.h, plan.identified->h);
        if (std::abs(response) < free_share) continue;
        if (&level != &plan.identified->levels.front())
            low.drive = std::clamp(level.peak_V / full_V, low.drive, 1.0);
        low.response = response;
        break;
    }
    return low;
}

}  // namespace

LoopCheck::LoopCheck(const LoopCheckPlan& plan)
    : least_gain_{!plan.gain_shown             ? least_alone
                  : plan.identified != nullptr ? least_gain
                                               : 1 / most_sheet_gain},
      most_gain_{!plan.gain_shown             ? most_alone
                 : plan.identified != nullptr ? most_gain
                                              : most_sheet_gain},
      direction_known_{plan.direction_known} {
    for (std::size_t q = 0; q < max_harmonics; ++q)
        if (plan.target.a[q] != 0.0) volts_.a[q] = plan.target.a[q] / plan.response[q];
    const LowLevel low = low_level(plan, control::peak(volts_));
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        volts_.a[q] *= low.drive;
        expected_.a[q] = low.drive * low.response * plan.target.a[q];
    }
}

bool LoopCheck::take(const Harmonics<Acceleration>& measured, int window_periods) {
    ratios_.push_back(relative(measured.a, expected_.a));
    taken_ += window_periods;
    return taken_ >= periods && ratios_.size() > 1;
}

std::complex<double> LoopCheck::ratio() const {
    std::complex<double> sum = 0;
    for (const auto& r : ratios_) sum += r;
    return sum / static_cast<double>(ratios_.size());
}

double LoopCheck::error() const {
    const auto n = static_cast<double>(ratios_.size());
    double squares = 0;
    for (const auto& r : ratios_) squares += std::norm(r - ratio());
    return std::sqrt(squares / (n - 1) / n);
}

LoopCheck::Verdict LoopCheck::verdict() const {
    const double gain = std::abs(ratio()), doubt = error();
    if (!(gain >= std::max(least_seen, sure * doubt)) || doubt > most_error) return Verdict::noise;
    if (direction_known_ && ratio().real() < 0) return Verdict::polarity;
    return gain < least_gain_ || gain > most_gain_ ? Verdict::gain : Verdict::agrees;
}

std::optional<Trip> LoopCheck::trip() const {
    const double gain = std::abs(ratio());
    const auto soft = [](Cause cause, double value, double limit) {
        return Trip{.cause = cause, .on_dac_clock = true, .value = value, .limit = limit};
    };
    switch (verdict()) {
        case Verdict::noise:
            return soft(Cause::sensor_open, gain, std::max(least_seen, sure * error()));
        case Verdict::polarity:
            return soft(Cause::polarity, ratio().real(), 0);
        case Verdict::gain:
            return soft(Cause::gain_limit, gain, gain < least_gain_ ? least_gain_ : most_gain_);
        case Verdict::agrees:
            break;
    }
    return std::nullopt;
}

std::string LoopCheck::finding() const {
    const std::string gain =
        fmt::format("the base moves {:.3g} +- {:.2g} times as much as expected", std::abs(ratio()), error());
    switch (verdict()) {
        case Verdict::noise:
            return fmt::format(
                "loop check: noise: {}; the sensor's noise hides the motion; its lead or the "
                "amplifier may be off",
                gain);
        case Verdict::polarity:
            return fmt::format("loop check: polarity: {}, in the opposite direction", gain);
        case Verdict::gain:
            return fmt::format("loop check: gain: {} (allowed {} to {})", gain, least_gain_, most_gain_);
        case Verdict::agrees:
            break;
    }
    return fmt::format("loop check: gain {:.3g} +- {:.2g}, polarity right", std::abs(ratio()), error());
}

}  // namespace shaker::safety
