#include "daemon/law/slope_mu.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "daemon/law/least_squares.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::law {

namespace {

constexpr double part_frames = 4;
// A walker this slow may be at rest: in errors of v, and of the base's velocity, whose scale is another
// sensor's.
constexpr double rest_errors = 5, rest_share = 5e-3;
constexpr double level_error = 5e-4;  // rad, of a base that was set up with a machinist's level

/// The known phases of a point's cycle, continued beyond one period.
class Unrolled {
public:
    explicit Unrolled(const Point& p) : c_{&p.cycle} {
        for (std::size_t i = 0; i < c_->phase.size(); ++i) {
            if (!std::isfinite(c_->v_mps[i]) || !std::isfinite(c_->v_base_mps[i])) continue;
            rows_.push_back(i);
            most_ = std::max(most_, std::abs(c_->v_base_mps[i]));
        }
    }
    [[nodiscard]] double phase(std::size_t i) const {
        return c_->phase[row(i)] + static_cast<double>(i / rows_.size());
    }
    [[nodiscard]] double v(std::size_t i) const { return c_->v_mps[row(i)]; }
    [[nodiscard]] double v_sd(std::size_t i) const { return c_->v_sd_mps[row(i)]; }
    [[nodiscard]] double v_R(std::size_t i) const { return v(i) - c_->v_base_mps[row(i)]; }
    [[nodiscard]] std::size_t size() const { return rows_.size(); }
    /// The base's largest velocity, m/s.
    [[nodiscard]] double most() const { return most_; }

private:
    [[nodiscard]] std::size_t row(std::size_t i) const { return rows_[i % rows_.size()]; }
    const reduction::Cycle* c_;
    std::vector<std::size_t> rows_;
    double most_ = 0;
};

struct Kink {
    double phase = 0, error = 0;  // 0..1, 1
};

// Sorted.
std::vector<Kink> kinks(const Point& p, const Unrolled& cycle) {
    std::vector<Kink> out;
    for (std::size_t i = 0; i < cycle.size(); ++i) {
        const double a = cycle.v_R(i), b = cycle.v_R(i + 1);
        if ((a > 0) != (b > 0))
            out.push_back({cycle.phase(i) + (cycle.phase(i + 1) - cycle.phase(i)) * a / (a - b)});
    }
    for (const auto& s : p.stick)
        for (const double end : {s.from, s.to}) out.push_back({end, std::isfinite(s.sd) ? s.sd : 0});
    for (Kink& k : out) k.phase -= std::floor(k.phase);
    std::ranges::sort(out, {}, &Kink::phase);
    return out;
}

bool sticks_at(const Point& p, double phase) {
    return std::ranges::any_of(p.stick, [&](const auto& s) {
        const double since = phase - s.from - std::floor(phase - s.from);
        return since <= s.to - s.from;
    });
}

struct Curve {
    std::vector<double> gamma, theta;
};

struct Solved {
    double mu = NAN, error = NAN, rms = NAN;
    double by_theta = 0;  // d mu for a common change of all Theta
    std::vector<double> gain;
};

// Gauss-Newton for Eq. (8), equal weights.
Solved solve(const Curve& c, double g) {
    Solved out;
    out.mu = walker::mu_from_no_stick_theta(c.theta.back(), c.gamma.back(), 0.5, g);
    for (int round = 0; round < 50; ++round) {
        double top = 0, weight = 0, squares = 0;
        out.gain.clear();
        for (std::size_t i = 0; i < c.gamma.size(); ++i) {
            const double s = std::min(std::numbers::pi * out.mu * g / c.gamma[i], 1 - 1e-9);
            const double slope = 2 * std::numbers::pi * g / c.gamma[i] / std::sqrt(1 - s * s);
            const double off = c.theta[i] - 2 * std::asin(s);
            top += slope * off;
            weight += slope * slope;
            squares += off * off;
            out.gain.push_back(slope);
        }
        for (double& w : out.gain) w /= weight;
        out.mu += top / weight;
        const auto n = static_cast<double>(c.gamma.size());
        out.rms = std::sqrt(squares / n);
        out.error = n > 1 ? std::sqrt(squares / (n - 1) / weight) : NAN;
        if (std::abs(top / weight) < 1e-12) break;
    }
    return out;
}

std::vector<FrictionAt> friction_at(std::span<const Point> points, double g,
                                    const calibration::Estimate& tilt) {
    constexpr double step = 1.6, unit = 1e-3;                     // m/s
    constexpr std::size_t for_a_line = 3;                         // of unknown slope and scatter
    std::map<std::pair<bool, int>, std::vector<SlipForce>> bins;  // forwards, step of |v_R|
    for (const Point& p : points)
        for (const SlipForce& f : slip_forces(p))
            bins[{f.v_R > 0, static_cast<int>(std::floor(std::log(std::abs(f.v_R) / unit) / std::log(step)))}]
                .push_back(f);
    std::vector<FrictionAt> out;
    for (const auto& [key, parts] : bins) {
        const auto n = static_cast<Eigen::Index>(parts.size());
        Eigen::MatrixXd line = Eigen::MatrixXd::Ones(n, 2);
        Eigen::VectorXd mu(n), sigma(n);
        double weights = 0, v_R = 0;
        for (Eigen::Index i = 0; i < n; ++i) {
            const SlipForce& f = parts[static_cast<std::size_t>(i)];
            mu[i] =
                (key.first ? 1 : -1) * (g * std::sin(tilt.value) - f.a.value) / (g * std::cos(tilt.value));
            sigma[i] = f.a.sigma / (g * std::cos(tilt.value));
            line(i, 1) = f.v_R;
            weights += 1 / (sigma[i] * sigma[i]);
            v_R += f.v_R / (sigma[i] * sigma[i]);
        }
        v_R /= weights;
        line.col(1).array() -= v_R;
        const Linear fit =
            least_squares(line.leftCols(parts.size() < for_a_line ? 1 : 2), mu, sigma, Weights::by_error);
        const double scatter = fit.freedom > 0 ? std::max(1.0, fit.chi2 / fit.freedom) : 1;
        out.push_back({v_R,
                       {fit.x[0], std::hypot(std::sqrt(fit.covariance(0, 0) * scatter), tilt.sigma)},
                       static_cast<int>(n)});
    }
    std::ranges::sort(out, {}, &FrictionAt::v_R);
    return out;
}

}  // namespace

std::vector<SlipForce> slip_forces(const Point& p) {
    std::vector<SlipForce> out;
    const Unrolled cycle{p};
    if (cycle.size() < 20 || !(p.phases_per_period > 0)) return out;
    const std::vector<Kink> at = kinks(p, cycle);
    const double frame = 1 / p.phases_per_period;
    for (std::size_t i = 0; i < at.size(); ++i) {
        const Kink& next = at[(i + 1) % at.size()];
        const auto margin = [&](const Kink& k) { return p.kink_frames * frame + 2 * k.error; };
        const double from = at[i].phase + margin(at[i]),
                     to = next.phase + (i + 1 < at.size() ? 0 : 1) - margin(next);
        if (to - from < part_frames * frame || sticks_at(p, (from + to) / 2)) continue;
        const double parts = std::floor((to - from) / (part_frames * frame));
        std::size_t first = 0;
        while (cycle.phase(first) < from) ++first;
        for (double part = 1; part <= parts; ++part) {
            const double end = from + (to - from) * part / parts;
            double way = 0, widest = 0;  // integral of v_R over the phase; between two phases
            std::size_t last = first;
            for (; cycle.phase(last + 1) <= end; ++last) {
                const double step = cycle.phase(last + 1) - cycle.phase(last);
                way += step * (cycle.v_R(last) + cycle.v_R(last + 1)) / 2;
                widest = std::max(widest, step);
            }
            const double length = cycle.phase(last) - cycle.phase(first), dt = length / p.frequency,
                         at_rest = std::max(rest_share * cycle.most(),
                                            rest_errors * std::max(cycle.v_sd(first), cycle.v_sd(last)));
            const calibration::Estimate a{(cycle.v(last) - cycle.v(first)) / dt,
                                          std::hypot(cycle.v_sd(last), cycle.v_sd(first)) / dt};
            const bool whole = length > part_frames * frame / 2 && widest < part_frames * frame;
            if (whole && a.sigma > 0 && std::abs(way / length) > at_rest)
                out.push_back({first, last, way / length, a});
            first = last;
        }
    }
    return out;
}

SlopeFit fit_slopes(std::span<const Point> points, double g) {
    SlopeFit out;
    out.mu = {.name = "mu_k", .unit = "1"};
    out.tilt = {.name = "tilt from slopes", .unit = "rad"};
    out.viscous = {.name = "viscous friction", .unit = "s-1"};
    std::vector<SlipForce> parts;
    for (const Point& p : points)
        for (const SlipForce& part : slip_forces(p)) parts.push_back(part);
    bool both = false;
    for (const SlipForce& part : parts) both = both || (part.v_R > 0) != (parts.front().v_R > 0);
    if (!both) {
        out.mu.note = parts.empty() ? "no slip is long enough between its kinks for the rate of the frames"
                                    : "slips of one direction only: friction and tilt cannot be separated";
        out.tilt.note = out.mu.note;
        return out;
    }
    const auto n = static_cast<Eigen::Index>(parts.size());
    Eigen::MatrixXd A(n, 3);
    Eigen::VectorXd y(n), sigma(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const SlipForce& part = parts[static_cast<std::size_t>(i)];
        A.row(i) << (part.v_R > 0 ? -g : g), g, -part.v_R;
        y[i] = part.a.value;
        sigma[i] = part.a.sigma;
    }
    const Linear fit = least_squares(A.leftCols(2), y, sigma, Weights::by_error),
                 viscous = least_squares(A, y, sigma, Weights::by_error);
    const auto fill = [&](Fit& to, const Linear& from, Eigen::Index k) {
        to.value = from.x[k];
        to.error = std::sqrt(from.covariance(k, k));
        to.chi2 = from.chi2;
        to.freedom = from.freedom;
        to.points = static_cast<int>(n);
    };
    fill(out.mu, fit, 0);
    fill(out.tilt, fit, 1);
    fill(out.viscous, viscous, 2);
    out.mu.note = misfit(fit.chi2, fit.freedom, "the slips scatter more than the errors of v(t)");
    const double scatter = std::sqrt(std::max(1.0, viscous.chi2 / std::max(1, viscous.freedom)));
    if (std::abs(out.viscous.value) > 4 * scatter * out.viscous.error)
        out.viscous.note = "the friction in slips depends on the velocity, and mu_k is a mean";
    out.covariance = {
        {"mu_k", "tilt"},
        {fit.covariance(0, 0), fit.covariance(0, 1), fit.covariance(1, 0), fit.covariance(1, 1)}};
    return out;
}

Friction friction_by_velocity(std::span<const Point> points, double g, const calibration::Estimate& tilt,
                              std::string_view from) {
    Friction out{{}, tilt, std::string{from}};
    if (!std::isfinite(tilt.value) || !std::isfinite(tilt.sigma)) {
        const Fit slips = fit_slopes(points, g).tilt;
        const bool known = std::isfinite(slips.value) && std::isfinite(slips.error);
        out.tilt =
            known ? calibration::Estimate{slips.value, slips.error} : calibration::Estimate{0, level_error};
        out.tilt_from = known ? "by the slips, as if friction were the same in both directions"
                              : "not known, the base is taken as level";
    }
    out.at = friction_at(points, g, out.tilt);
    return out;
}

Fit fit_no_stick(std::span<const Fit> nulls, double mu_ac, double g) {
    Fit fit{.name = "mu_ns", .unit = "1"};
    Curve measured, expected;
    double chi2 = 0;
    for (const Fit& null : nulls) {
        measured.gamma.push_back(null.gamma);
        measured.theta.push_back(null.value - std::numbers::pi / 2);
        const double theta = walker::coulomb_theta(null.gamma / (mu_ac * g));
        if (std::isfinite(theta)) {
            expected.gamma.push_back(null.gamma);
            expected.theta.push_back(theta);
        }
    }
    if (measured.gamma.empty()) {
        fit.note = "no null phase: v_D changes sign in phi at no gamma";
        return fit;
    }
    const Solved solved = solve(measured, g);
    fit.value = solved.mu;
    fit.error = solved.error;
    fit.points = static_cast<int>(nulls.size());
    fit.freedom = fit.points - 1;
    for (const Fit& null : nulls) {
        const double theta = walker::no_stick_theta(null.gamma, fit.value, 0.5, g);
        chi2 += std::pow((null.value - std::numbers::pi / 2 - theta) / null.error, 2);
    }
    if (fit.freedom > 0) fit.chi2 = chi2;
    if (std::isnan(fit.error)) fit.error = solved.gain[0] * nulls[0].error;
    fit.note = "no-stick definition of the paper, 13 to 23 % below the friction coefficient of Coulomb's law";
    if (expected.gamma.size() == measured.gamma.size()) {
        const double mu = solve(expected, g).mu;
        fit.note += fmt::format("; at these gammas a walker with mu_ac gives {:.4f}, {:.1f} %", mu,
                                100 * (mu / mu_ac - 1));
    }
    return fit;
}

}  // namespace shaker::law
