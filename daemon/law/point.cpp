#include "daemon/law/point.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numbers>

#include "daemon/law/phase_fits.hpp"
#include "daemon/reduction/series.hpp"

namespace shaker::law {

namespace {

using std::numbers::pi;

// Biharmonic at rho = 1/2, at the frequency with most of these points.
std::vector<const Point*> as_in_the_paper(std::span<const Point> points) {
    std::map<double, std::vector<const Point*>> at;
    for (const Point& p : points)
        if (p.asked.biharmonic() && p.asked.rho == 0.5) at[p.asked.frequency].push_back(&p);
    if (at.empty()) return {};
    return std::ranges::max_element(at, {}, [](const auto& f) { return f.second.size(); })->second;
}

double rounded(double x) { return std::round(x * 1e9) / 1e9; }

// phi modulo pi, in [0, pi), and whether it was folded an odd number of times.
std::pair<double, bool> folded(double phi) {
    const double turns = std::floor(phi / pi);
    return {phi - turns * pi, static_cast<long>(turns) % 2 != 0};
}

}  // namespace

bool Point::take(const reduction::MeasuredHarmonic& h) {
    if (h.q < 1 || h.q > max_harmonics || !std::isfinite(h.amplitude.value)) return false;
    const auto finite = [](double x) { return std::isfinite(x) ? x : 0; };
    base.at(h.q) = std::polar(h.amplitude.value, finite(h.phase.value));
    base_sd[static_cast<std::size_t>(h.q - 1)] = finite(h.amplitude.sigma);
    if (h.q != 2) return true;
    const double noise = phase_noise(*this), seen = finite(h.phase.sigma);
    constexpr double clearly = 1.2;  // errors of amplitudes and phases differ a little
    turn_sd = seen > clearly * noise ? std::sqrt(seen * seen - noise * noise) : 0;
    return true;
}

double phase_noise(const Point& p) noexcept {
    const double a1 = std::abs(p.base.at(1)), a2 = std::abs(p.base.at(2));
    return std::hypot(p.base_sd[1] / a2, 2 * p.base_sd[0] / a1);
}

Point point_of(const reduction::Reduction& result, const Drive& asked) {
    Point p;
    p.asked = asked;
    p.frequency = result.frequency.value;
    p.gamma = result.gamma;
    p.rho = result.rho;
    p.phi = result.phi;
    p.v_D = result.v_D;
    p.periods = static_cast<int>(result.periods.size());
    p.tilt = result.tilt.angle;
    if (std::isfinite(result.systematic.phi)) p.turn_told = result.systematic.phi;
    if (const auto doubts = reduction::doubts_of(result); !doubts.empty()) p.doubt = doubts.front();
    if (p.periods > 0) p.phases_per_period = result.frames / most_views / p.periods;
    p.cycle = result.cycle;
    p.stick = result.stick;
    for (const reduction::MeasuredHarmonic& h : result.harmonics) p.take(h);
    return p;
}

bool add_paired(std::vector<Point>& points, Point p) {
    if (!std::isfinite(p.v_D.value) || !(p.v_D.sigma > 0) || p.base.order() == 0) return false;
    p.number = points.empty() ? 1 : points.back().number + 1;
    const auto partner = std::ranges::find_if(points, [&](const Point& other) {
        return other.partner == 0 && reduction::mirrored(other.asked, p.asked);
    });
    if (partner != points.end()) {
        partner->partner = p.number;
        p.partner = partner->number;
    }
    points.push_back(std::move(p));
    return true;
}

std::map<double, std::vector<Folded>> by_gamma(std::span<const Point> points) {
    std::map<double, std::vector<Folded>> groups;
    for (const Point* p : as_in_the_paper(points)) {
        const auto [x, mirrored] = folded(p->phi.value);
        groups[rounded(p->asked.gamma)].push_back(
            {p, x, mirrored ? -p->v_D.value : p->v_D.value, p->v_D.sigma, phi_error(*p)});
    }
    for (auto& [gamma, group] : groups) std::ranges::sort(group, {}, &Folded::x);
    return groups;
}

std::map<double, std::vector<Folded>> by_phi(std::span<const Point> points) {
    std::map<double, std::vector<Folded>> groups;
    for (const Point* p : as_in_the_paper(points)) {
        auto [x, mirrored] = folded(p->asked.phi);
        if (pi - x < 1e-6) x -= pi, mirrored = !mirrored;  // 180 deg is 0
        groups[std::abs(std::round(x * 1e6) / 1e6)].push_back(
            {p, p->gamma.value, mirrored ? -p->v_D.value : p->v_D.value, p->v_D.sigma, p->gamma.sigma});
    }
    for (auto& [phi, group] : groups) std::ranges::sort(group, {}, &Folded::x);
    return groups;
}

std::vector<Folded> merged(const std::vector<Folded>& group, double same, double share) {
    std::vector<Folded> out;
    std::vector<int> counts;
    for (const Folded& f : group) {
        if (!out.empty() && f.x - out.back().x <= same + share * f.x) {
            const int n = ++counts.back();
            Folded& m = out.back();
            m.x += (f.x - m.x) / n;
            m.v_D += (f.v_D - m.v_D) / n;
            m.sigma = std::hypot(m.sigma * (n - 1), f.sigma) / n;
            m.x_sigma = std::hypot(m.x_sigma * (n - 1), f.x_sigma) / n;
        } else {
            out.push_back(f);
            counts.push_back(1);
        }
    }
    return out;
}

std::string in_g(double gamma) { return fmt::format("{:.4g} g", gamma / paper_g); }

}  // namespace shaker::law
