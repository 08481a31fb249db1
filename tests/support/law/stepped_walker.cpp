#include "tests/support/law/stepped_walker.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/support/law/synthetic_points.hpp"

namespace shaker::test {

namespace {

using walker::FrictionLaw;

struct State {
    double v_R = 0, zeta = 0;
};

/// The equations of friction.hpp, written again.
class Stepped {
public:
    Stepped(const Harmonics<Acceleration>& free, double frequency, const law::LawSetting& law, double factor,
            int steps)
        : law_{law},
          f_{law.friction},
          r_{law.push},
          mu_{law.friction.mu_k * factor},
          steps_{steps},
          h_{1 / frequency / steps} {
        for (int i = 0; i <= 2 * steps; ++i) {
            const double theta = std::numbers::pi * i / steps;
            double a = 0, z = 0;
            for (int q = 1; q <= max_harmonics; ++q) {
                const std::complex<double> turn = std::polar(1.0, q * theta), A = free.at(q);
                a += (A * turn).imag();
                z += (A * std::complex<double>{law.with, -law.quarter} * turn).imag();
            }
            free_.push_back(a);
            normal_.push_back(law.g * std::cos(law.tilt) + z);
        }
    }

    /// One period. Returns the way on the base, m.
    double period(State& s, std::vector<double>& a_w) {
        double way = 0;
        a_w.resize(static_cast<std::size_t>(steps_));
        for (int i = 0; i < steps_; ++i) {
            const auto k = static_cast<std::size_t>(2 * i);
            a_w[static_cast<std::size_t>(i)] = walker_acceleration(s, k);
            way += step(s, k);
        }
        return way;
    }

private:
    [[nodiscard]] double pull() const { return law_.g * std::sin(law_.tilt); }
    [[nodiscard]] bool elastic() const { return f_.law == FrictionLaw::dahl; }
    // a_w in slip with sign.
    [[nodiscard]] double slipping(const State& s, std::size_t k, int sign) const {
        const double b = sign < 0 ? f_.backward : 1, speed = sign * s.v_R;
        double share = sign * b;
        if (f_.law == FrictionLaw::logarithmic)
            share *= 1 + f_.log_share * std::log1p(std::max(0.0, speed) / f_.log_velocity);
        if (f_.law == FrictionLaw::stribeck)
            share *= 1 + (law_.static_ratio - 1) * std::exp(-std::pow(s.v_R / f_.stribeck, 2));
        if (elastic()) share = s.zeta;
        return pull() - mu_ * normal_[k] * share - f_.viscous * s.v_R;
    }
    // What a walker at rest on the base needs of friction, as a_w - pull: a_B = Q - r a_w = a_w.
    [[nodiscard]] double needed(std::size_t k) const { return free_[k] / (1 + r_) - pull(); }
    [[nodiscard]] bool holds(std::size_t k) const {
        const double b = needed(k) > 0 ? f_.backward : 1;
        return std::abs(needed(k)) <= mu_ * law_.static_ratio * normal_[k] * b;
    }
    [[nodiscard]] double walker_acceleration(const State& s, std::size_t k) const {
        if (elastic()) return slipping(s, k, 1);
        if (s.v_R == 0 && holds(k)) return free_[k] / (1 + r_);
        return slipping(s, k, direction(s, k));
    }
    [[nodiscard]] int direction(const State& s, std::size_t k) const {
        return s.v_R > 0 ? 1 : s.v_R < 0 ? -1 : needed(k) > 0 ? -1 : 1;
    }
    [[nodiscard]] State rates(const State& s, std::size_t k, int sign) const {
        const double b = s.v_R < 0 ? f_.backward : 1;
        const double zeta = elastic() ? (s.v_R - std::abs(s.v_R) * s.zeta / b) / f_.presliding : 0;
        return {(1 + r_) * slipping(s, k, sign) - free_[k], zeta};
    }
    // From half-step k to k + 2. Returns the way.
    double step(State& s, std::size_t k) const {
        if (!elastic() && s.v_R == 0 && holds(k)) return 0;
        const int sign = direction(s, k);
        const auto ahead = [](const State& a, const State& rate, double h) {
            return State{a.v_R + h * rate.v_R, a.zeta + h * rate.zeta};
        };
        const State k1 = rates(s, k, sign), k2 = rates(ahead(s, k1, h_ / 2), k + 1, sign),
                    k3 = rates(ahead(s, k2, h_ / 2), k + 1, sign), k4 = rates(ahead(s, k3, h_), k + 2, sign);
        const double before = s.v_R;
        s.zeta += h_ / 6 * (k1.zeta + 2 * k2.zeta + 2 * k3.zeta + k4.zeta);
        s.v_R += h_ / 6 * (k1.v_R + 2 * k2.v_R + 2 * k3.v_R + k4.v_R);
        if (elastic() || s.v_R * sign > 0 || before == 0) {
            if (!elastic() && s.v_R * sign <= 0) s.v_R = 0;
            return h_ * (before + s.v_R) / 2 - h_ * h_ / 12 * (k4.v_R - k1.v_R);
        }
        const double part = before / (before - s.v_R), way = h_ * part * before / 2;
        s.v_R = 0;
        if (holds(k + 2)) return way;
        const double rest = (1 - part) * h_, rate = rates(s, k + 2, direction(s, k + 2)).v_R;
        s.v_R = rest * rate;
        return way + rest * s.v_R / 2;
    }

    law::LawSetting law_;
    walker::Friction f_;
    double r_, mu_;
    int steps_;
    double h_;
    std::vector<double> free_, normal_;  // at half-steps
};

}  // namespace

SteppedCycle stepped_cycle(const Harmonics<Acceleration>& free, double frequency, const law::LawSetting& law,
                           double factor, int steps) {
    Stepped walker{free, frequency, law, factor, steps};
    State s;
    std::vector<double> a_w;
    double way = 0, before = 0;
    for (int n = 0;; ++n) {
        if (n == 5000) throw std::runtime_error{"the stepped walker has not settled"};
        const double v = s.v_R;
        way = walker.period(s, a_w);
        const double change = s.v_R - v, factor_of = before != 0 ? change / before : 0;
        if (n > 2 && std::abs(change) < 1e-9 * (1 - std::clamp(factor_of, 0.0, 0.99))) break;
        before = change;
        if (n % 4 == 3 && factor_of > 0 && factor_of < 0.999) {  // the limit of the series
            const double next = s.v_R + change * factor_of / (1 - factor_of);
            if (next * s.v_R > 0) s.v_R = next, before = 0;
        }
    }
    SteppedCycle out{way * frequency, free};
    for (int q = 1; q <= max_harmonics; ++q) {
        std::complex<double> sum = 0;
        for (int i = 0; i < steps; ++i)
            sum += a_w[static_cast<std::size_t>(i)] * std::polar(1.0, -two_pi * q * i / steps);
        out.base.at(q) -= law.push * std::complex<double>{0, 2.0 / steps} * sum;
    }
    return out;
}

law::Point stepped_point(const Drive& asked, const law::LawSetting& law, int number, int partner,
                         double time_s, double place, int steps) {
    const double factor = (1 + law.excess * std::exp(-time_s / law.excess_s)) * (1 + law.slope * place);
    const SteppedCycle cycle = stepped_cycle(harmonics(asked), asked.frequency, law, factor, steps);
    law::Point p = measured_point(asked, cycle.base, {cycle.v_D, 2e-6}, number, partner);
    p.time_s = time_s;
    p.place = place;
    return p;
}

std::vector<law::Point> stepped_points(const law::LawSetting& law, int steps) {
    std::vector<law::Point> points;
    for (const auto& [gamma, null] : {std::pair{0.68, 2.4}, {1.0, 2.17}, {2.0, 1.9}})
        for (const double phi : {0.0, null - 0.25})
            for (const int mirror : {0, 1}) {
                const int n = static_cast<int>(points.size()) + 1;
                const Drive asked{.gamma = gamma * paper_g, .phi = phi + mirror * std::numbers::pi};
                points.push_back(stepped_point(asked, law, n, mirror == 0 ? n + 1 : n - 1, 10.0 * (n - 1),
                                               0.04 * std::sin(7.0 * n), steps));
            }
    return points;
}

}  // namespace shaker::test
