#include "daemon/law/law_cycle.hpp"

#include <cmath>
#include <vector>

namespace shaker::law {

namespace {

using namespace std::complex_literals;
using walker::WalkerSetting;

constexpr std::size_t law_phases = 1024;  // harmonic 16 of a kinked v has an error of 0.03 %
constexpr int first_pushes = 3;  // of the push, without a start; each leaves a share m/M_eff of the error

// In the frame of the base all forces on the walker are 1 + push times as large (pushed_walker.hpp).
WalkerSetting law_setting(const Point& point, double since, const LawSetting& law) {
    const double off = std::isfinite(point.place) ? point.place - law.middle : 0;
    const double factor =
        std::max(0.1, (1 + law.excess * std::exp(-(std::isfinite(since) ? since : 0) / law.excess_s)) *
                          (1 + law.slope * off));
    WalkerSetting s;
    s.frequency = point.frequency;
    s.base = point.base;
    s.tilt = law.tilt;
    s.g = law.g * (1 + law.push);
    s.friction = law.friction;
    s.friction.mu_k *= factor;
    s.friction.mu_s = law.static_ratio * s.friction.mu_k;
    s.friction.viscous *= 1 + law.push;
    for (std::size_t i = 0; i < max_harmonics; ++i)
        s.vertical.a[i] = point.base.a[i] * std::complex<double>{law.with, -law.quarter} * (1 + law.push);
    return s;
}

// Harmonics of the acceleration that belongs to a velocity at uniform law_phases of the period.
Amplitudes acceleration_of(const std::vector<double>& v, double omega) {
    static const std::vector<std::complex<double>> turns = [] {
        std::vector<std::complex<double>> t;
        for (std::size_t i = 0; i < law_phases; ++i)
            t.push_back(std::polar(1.0, -two_pi * static_cast<double>(i) / law_phases));
        return t;
    }();
    Amplitudes out{};
    for (std::size_t q = 1; q <= max_harmonics; ++q) {
        std::complex<double> sum = 0;
        for (std::size_t i = 0; i < law_phases; ++i) sum += v[i] * turns[i * q % law_phases];
        out[q - 1] = 2i / static_cast<double>(law_phases) * sum * (1i * static_cast<double>(q) * omega);
    }
    return out;
}

LawCycle law_settled(const WalkerSetting& setting, const walker::WarmStart& start, double tolerance) {
    LawCycle out{.start = start};
    std::vector<double> v(law_phases);
    const double omega = two_pi * setting.frequency;
    if (setting.friction.closed_form()) {
        const walker::WalkerLaw law{setting};
        const bool one = setting.friction.mu_s == setting.friction.mu_k;
        const walker::SteadyState cycle = one ? settle_quickly(law, start.v) : settle(law, start.v);
        out.v_D = cycle.v_D;
        out.start.v = cycle.v0;
        walker::Walker walker{law, cycle.v0};
        for (std::size_t i = 0; i < law_phases; ++i)
            v[i] = walker.advance_to(static_cast<double>(i) / law_phases).v;
    } else {
        walker::IntegratedWalker walker{setting, start.v, tolerance};
        walker.observe(law_phases);
        const walker::SteadyState cycle = settle_quickly(walker, out.start);
        out.v_D = cycle.v_D;
        const TrigPolynomial v_base = base_velocity(setting);
        for (std::size_t i = 0; i < law_phases; ++i)
            v[i] = walker.relative()[i] + v_base(two_pi * static_cast<double>(i) / law_phases);
    }
    out.walker = acceleration_of(v, omega);
    return out;
}

}  // namespace

LawCycle law_cycle(const Point& point, double since, const LawSetting& law, double tolerance,
                   const LawCycle* start) {
    WalkerSetting setting = law_setting(point, since, law);
    LawCycle out;
    if (start != nullptr) out = *start;
    for (int round = start != nullptr ? first_pushes - 1 : 0; round < first_pushes; ++round) {
        for (std::size_t i = 0; i < max_harmonics; ++i)
            setting.base.a[i] = point.base.a[i] + law.push * out.walker[i];
        out = law_settled(setting, out.start, tolerance);
        for (auto& a : out.walker) a /= 1 + law.push;  // v_R' + Q = (1 + r) a_w
    }
    return out;
}

}  // namespace shaker::law
