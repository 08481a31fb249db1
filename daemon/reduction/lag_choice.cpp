#include "daemon/reduction/lag_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/drive.hpp"

namespace shaker::reduction {
namespace {

std::string milliseconds(double s) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.1f ms", 1e3 * s);
    return text.data();
}

/// Correlation of both shapes after moving the accelerometer's by `delta` (master time): 1 is perfect.
double likeness(const std::vector<CommonHarmonic>& common, double w, double delta) {
    double product = 0, accel = 0, camera = 0;
    for (const CommonHarmonic& c : common) {
        product += c.weight * (c.accel * std::conj(c.camera) * std::polar(1.0, -c.q * w * delta)).real();
        accel += c.weight * std::norm(c.accel);
        camera += c.weight * std::norm(c.camera);
    }
    return product / std::sqrt(accel * camera);
}

struct Shift {
    double like;
    bool flipped;  // sign of the axis reversed
    double late;   // in the middle of the record
    double first;  // at the clock's first sample; the whole periods nearest to 0
};

double golden_maximum(const std::vector<CommonHarmonic>& common, double w, double sign, double low,
                      double high) {
    constexpr double golden = 0.6180339887498949;
    for (int i = 0; i < 60; ++i) {
        const double a = high - golden * (high - low), b = low + golden * (high - low);
        if (sign * likeness(common, w, a) < sign * likeness(common, w, b)) {
            low = a;
        } else {
            high = b;
        }
    }
    return (low + high) / 2;
}

std::vector<Shift> maxima(const std::vector<CommonHarmonic>& common, double w, double offset,
                          const LagPrior& prior) {
    constexpr int steps = 96;
    const double period = two_pi / w, h = period / steps;
    std::vector<Shift> out;
    for (const double sign : {1.0, -1.0}) {
        for (int i = 0; i < steps; ++i) {
            const double here = sign * likeness(common, w, i * h);
            if (here < sign * likeness(common, w, (i - 1) * h) ||
                here <= sign * likeness(common, w, (i + 1) * h)) {
                continue;
            }
            const double delta = golden_maximum(common, w, sign, (i - 1) * h, (i + 1) * h);
            double late = std::remainder(offset - delta, period),
                   first = late + prior.since_first_s * prior.rate;
            if (const double whole = std::rint(first / period); whole != 0) {
                late -= whole * period;
                first -= whole * period;
            }
            out.push_back({sign * likeness(common, w, delta), sign < 0, late, first});
        }
    }
    return out;
}

/// Finds all possible delays besides the chosen one: of the equal shapes, each with whole periods.
void set_spread(LagChoice& chosen, const std::vector<Shift>& equal, double period, const LagPrior& prior,
                std::vector<std::string>& notes) {
    const double reach = prior.uncertainty_s + 3 * prior.rate_sd * std::abs(prior.since_first_s);
    double squares = 0, farthest = 0;
    int possible = 0;
    bool other_sign = false;
    for (const Shift& m : equal) {
        const auto low = std::ceil((-reach - m.first) / period),
                   high = std::floor((reach - m.first) / period);
        for (double n = low; n <= high; ++n) {
            const double apart = m.first + n * period - chosen.first_s;
            squares += apart * apart;
            farthest = std::max(farthest, std::abs(apart));
            other_sign = other_sign || m.flipped != chosen.flipped;
            ++possible;
        }
    }
    if (possible < 2) return;
    chosen.spread_s = std::sqrt(squares / possible);
    if (other_sign && !prior.axis_given) {
        notes.emplace_back(
            "the shape of the drive does not determine the sign of the shaker axis; the smaller clock lag "
            "was taken");
    }
    notes.push_back(std::to_string(possible) + " lags of the accelerometer within its clock uncertainty of " +
                    milliseconds(prior.uncertainty_s) + " fit the motion, up to " + milliseconds(farthest) +
                    " apart; the one nearest to zero was used, and the lag's error contains the others");
}

}  // namespace

std::vector<CommonHarmonic> common_motion(const calibration::HarmonicFit& accel,
                                          const calibration::HarmonicFit& base) {
    std::vector<CommonHarmonic> out;
    for (int q = 1; q <= std::min({accel.order(), base.order(), 3}); ++q) {
        if (!base.stands_out(q) || !accel.stands_out(q)) continue;
        const double w = two_pi * base.frequency_hz * q;
        const double sd = w * w * base.amplitude_sd(q);
        const double accel_phase = accel.phase_sd(q), base_phase = base.phase_sd(q);
        out.push_back({q, accel.at(q), -w * w * base.at(q), 1 / (sd * sd),
                       accel_phase * accel_phase + base_phase * base_phase});
    }
    return out;
}

LagChoice choose_lag(const std::vector<CommonHarmonic>& common, double frequency_hz, double offset_s,
                     const LagPrior& prior, std::vector<std::string>& notes) {
    const double w = two_pi * frequency_hz;
    double noise = 0, signal = 0, best = -1;
    for (const CommonHarmonic& c : common) {
        noise += 1;
        signal += c.weight * std::norm(c.camera);
    }
    std::vector<Shift> equal = maxima(common, w, offset_s, prior);
    for (const Shift& m : equal) best = std::max(best, m.like);
    const double tolerance = std::max(1e-3, 12 * noise / signal);
    std::erase_if(equal, [&](const Shift& m) { return m.like < best - tolerance; });
    if (prior.axis_given && !std::ranges::all_of(equal, &Shift::flipped))
        std::erase_if(equal, &Shift::flipped);
    const Shift& nearest =
        *std::ranges::min_element(equal, {}, [](const Shift& m) { return std::abs(m.first); });
    LagChoice out{nearest.late, nearest.first, nearest.flipped};
    set_spread(out, equal, two_pi / w, prior, notes);
    if (prior.axis_given && out.flipped) {
        notes.emplace_back("the given shaker axis points towards -x of the cameras; its sign was reversed");
    }
    if (best < 0.98) {
        notes.push_back("the base's motion differs in shape between cameras and accelerometer (likeness " +
                        std::to_string(best).substr(0, 5) + ")");
    }
    return out;
}

}  // namespace shaker::reduction
