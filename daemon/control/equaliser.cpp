#include "daemon/control/equaliser.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

std::size_t index(int q) { return static_cast<std::size_t>(q - 1); }

double norm(const Harmonics<Voltage>& h) {
    double sum = 0;
    for (const auto& a : h.a) sum += std::norm(a);
    return std::sqrt(sum);
}

double peak(const Harmonics<Voltage>& h) {
    constexpr int points = 256;
    double most = 0;
    for (int i = 0; i < points; ++i) most = std::max(most, std::abs(value_at(h, two_pi * i / points)));
    return most;
}

void require(bool ok, const std::string& what, double value, const std::string& allowed) {
    if (!ok)
        throw InputError("equaliser: " + what + " is " + std::to_string(value) + "; allowed are " + allowed);
}

}  // namespace

double Equaliser::largest_gain(int delay_periods) noexcept {
    return 2.0 / 3 * std::sin(std::numbers::pi / (2 * (2 * delay_periods + 1)));
}

Equaliser::Equaliser(const EqualiserSettings& s) : settings_(s) {
    require(s.order >= 1 && s.order <= max_harmonics, "order", s.order, "1 to 16");
    require(s.delay_periods >= 0 && s.delay_periods <= 20, "delay_periods", s.delay_periods, "0 to 20");
    const double most = largest_gain(s.delay_periods);
    require(s.mu > 0 && s.mu <= most, "mu", s.mu,
            "more than 0 to " + std::to_string(most) + " at this delay");
    require(s.limit_V > 0 && std::isfinite(s.limit_V), "limit_V", s.limit_V, "finite values above 0");
    require(s.step > 0 && s.step <= 1, "step", s.step, "more than 0 to 1");
    require(s.start_level > 0 && s.start_level <= 1, "start_level", s.start_level, "more than 0 to 1");
    for (int q = 1; q <= s.order; ++q) {
        const double size = std::abs(s.response[index(q)]);
        require(size > 0 && std::isfinite(size), "response of harmonic " + std::to_string(q), size,
                "finite values above 0");
    }
}

void Equaliser::set_target(const Harmonics<Acceleration>& target) {
    Harmonics<Voltage> change;
    Harmonics<Acceleration> next;
    for (int q = 1; q <= settings_.order; ++q) {
        const Complex r = target.at(q);
        require(std::isfinite(std::abs(r)), "target of harmonic " + std::to_string(q), std::abs(r),
                "finite values");
        next.at(q) = r;
        change.at(q) = (started_ ? r - report_.scale * asked_.at(q) : settings_.start_level * r) /
                       settings_.response[index(q)];
    }
    asked_ = next;
    for (int q = 1; q <= settings_.order; ++q) drive_.at(q) += change.at(q);
    if (next.order() == 0) drive_ = {};  // what was played against distortion goes too
    mean_error_ = {};
    best_ = {};
    report_ = {};
    measured_ = 0;
    started_ = norm(drive_) > 0;
    limit_peak();
}

bool Equaliser::plausible(const HarmonicEstimate& m) const noexcept {
    if (!m.valid) return false;
    double seen = 0, expected = 0;
    for (int q = 1; q <= settings_.order; ++q) {
        seen += std::norm(m.harmonics.at(q));
        expected += std::norm(settings_.response[index(q)] * drive_.at(q));
    }
    return std::isfinite(seen) && seen >= 0.01 * expected;
}

double Equaliser::lag(const Harmonics<Acceleration>& measured) const noexcept {
    const int q = std::norm(asked_.at(1)) > 0 ? 1 : 2;
    if (settings_.order < q || std::norm(asked_.at(q)) == 0 || std::norm(measured.at(q)) == 0) return 0;
    return std::remainder(std::arg(asked_.at(q)) - std::arg(measured.at(q)), two_pi) / q;
}

/// The error to act on: none for a harmonic that only gets worse by being corrected.
Equaliser::Complex Equaliser::correction(int q, Complex error, double sd) noexcept {
    const std::size_t i = index(q);
    if (report_.held[i]) return 0;
    Best& best = best_[i];
    const double size = std::abs(error);
    // Distortion grows with the drive: an unwanted harmonic is judged once the wanted ones are there.
    const bool early = measured_ <= settings_.delay_periods + 1 || (asked_.at(q) == 0.0 && !near_);
    if (early || size < best.error) {
        best = {size, drive_.at(q), 0};
    } else if (size > 2 * best.error + 6 * sd + 1e-3 * report_.gamma) {
        ++best.grown;
    } else {
        best.grown = 0;
    }
    if (best.grown > 3 * (settings_.delay_periods + 1)) {
        report_.held[i] = true;
        drive_.at(q) = best.drive;
        return 0;
    }
    return error;
}

void Equaliser::apply(const Harmonics<Voltage>& change, double room) noexcept {
    const double size = norm(change);
    const double part = size > room ? room / size : 1.0;
    for (int q = 1; q <= settings_.order; ++q) drive_.at(q) += part * change.at(q);
}

void Equaliser::limit_peak() noexcept {
    double top = peak(drive_);
    if (top > settings_.limit_V) {
        const double part = settings_.limit_V / top;
        for (auto& u : drive_.a) u *= part;
        report_.scale *= part;
        top = settings_.limit_V;
    } else if (top < 0.9 * settings_.limit_V) {
        report_.scale = std::min(1.0, 1.02 * report_.scale);
    }
    report_.peak_V = top;
    report_.gamma = report_.scale * (std::abs(asked_.at(1)) + std::abs(asked_.at(2)));
}

void Equaliser::judge() noexcept {
    double size = 0;
    for (const auto& r : asked_.a) size += std::abs(r);
    const double reference = report_.scale * size;
    bool all = measured_ >= 10;
    for (int q = 1; q <= settings_.order; ++q) {
        const double residual = std::abs(mean_error_[index(q)]);
        report_.residual_db[index(q)] =
            reference > 0 ? 20 * std::log10(std::max(residual / reference, 1e-9)) : 0.0;
        all = all && report_.residual_db[index(q)] < -60;
    }
    report_.locked = all && reference > 0;
}

const Harmonics<Voltage>& Equaliser::update(const HarmonicEstimate& measured) noexcept {
    report_.implausible = !plausible(measured);
    if (report_.implausible) {
        ++report_.ignored;
        report_.locked = false;
        return drive_;
    }
    report_.ignored = 0;
    ++measured_;
    const double delta = lag(measured.harmonics);
    report_.lag_turns = delta / two_pi;
    near_ = true;
    for (int q = 1; q <= settings_.order; ++q) {
        const double size = report_.scale * std::abs(asked_.at(q));
        near_ =
            near_ && std::abs(std::abs(measured.harmonics.at(q)) - size) <= 0.1 * size + 0.05 * report_.gamma;
    }
    Harmonics<Voltage> change;
    const double memory = std::max(0.1, 1.0 / measured_);
    for (int q = 1; q <= settings_.order; ++q) {
        const Complex seen = measured.harmonics.at(q) * std::polar(1.0, q * delta);
        const Complex error = report_.scale * asked_.at(q) - seen;
        mean_error_[index(q)] += memory * (error - mean_error_[index(q)]);
        const Complex act = correction(q, error, measured.sd[index(q)]);
        change.at(q) = settings_.mu * act / settings_.response[index(q)];
    }
    apply(change, settings_.step * norm(drive_));
    limit_peak();
    judge();
    return drive_;
}

}  // namespace shaker
