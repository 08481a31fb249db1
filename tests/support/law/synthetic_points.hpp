#pragma once
// Points that obey the law of friction exactly, or with noise.
#include <numbers>
#include <random>
#include <vector>

#include "daemon/law/pushed_walker.hpp"

namespace shaker::test {

/// A point with a measured base; its errors are those of the simulated bench.
inline law::Point measured_point(const Drive& asked, const Harmonics<Acceleration>& base,
                                 const calibration::Estimate& v_D, int number, int partner) {
    law::Point p;
    p.number = number;
    p.partner = partner;
    p.asked = asked;
    p.frequency = asked.frequency;
    p.base = base;
    p.base_sd.fill(3e-4);
    const Drive measured = drive_of(base, asked.frequency);
    p.gamma = {measured.gamma, 4e-4};
    p.rho = {measured.rho, 3e-5};
    p.phi = {measured.phi, 1e-4};
    p.v_D = v_D;
    return p;
}

/// A walker under `law` on a base that moves with the asked drive but for the walker's push, open loop;
/// errors as on the simulated bench, without noise. partner: 0: none.
inline law::Point exact_point(const Drive& asked, const law::Coulomb& law, int number = 1, int partner = 0) {
    law::Coulomb heavy = law;  // relative to the base: gravity (1 + r) g on the free base
    heavy.g *= 1 + law.push;
    heavy.push = 0;
    const law::PushedCycle cycle = law::pushed_cycle(harmonics(asked), asked.frequency, heavy);
    Harmonics<Acceleration> held = harmonics(asked);
    for (auto& a : held.a) a /= 1 + law.push;
    const law::Amplitudes a_w = segment_harmonics(cycle.segments, slip_acceleration(law), held);
    Harmonics<Acceleration> base = harmonics(asked);
    for (std::size_t i = 0; i < max_harmonics; ++i) base.a[i] -= law.push * a_w[i];
    return measured_point(asked, base, {cycle.v_D, 1e-6}, number, partner);
}

inline Drive drive_at(double gamma_in_g, double phi) { return {.gamma = gamma_in_g * paper_g, .phi = phi}; }

/// Phases around the null at two gammas and phi = 0, each with its mirror partner: 12 points.
inline std::vector<law::Point> exact_points(const law::Coulomb& law) {
    std::vector<law::Point> points;
    for (const auto& [gamma, phi] :
         {std::pair{0.68, 2.2}, {0.68, 2.6}, {1.0, 2.0}, {1.0, 2.4}, {1.5, 0.0}, {2.0, 1.9}}) {
        const int n = static_cast<int>(points.size());
        points.push_back(exact_point(drive_at(gamma, phi), law, n + 1, n + 2));
        points.push_back(exact_point(drive_at(gamma, phi + std::numbers::pi), law, n + 2, n + 1));
    }
    return points;
}

/// Adds the noise that the errors of the points state.
inline void add_noise(std::vector<law::Point>& points, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    for (law::Point& p : points) {
        p.v_D.value += p.v_D.sigma * normal(random);
        for (std::size_t i = 0; i < max_harmonics; ++i)
            p.base.a[i] += p.base_sd[i] * std::complex<double>{normal(random), normal(random)};
        p.phi.value = drive_of(p.base, p.frequency).phi;
    }
}

}  // namespace shaker::test
