#include "daemon/law/slope_mu.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "daemon/law/least_squares.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::law {

namespace {

// The quartic through 7 frames leaves this share of the noise in x; a parabola over many frames sees it
// whole.
constexpr double smoothed = 0.753;
constexpr double margin_frames = 4.5, least_frames = 6, least_length = 0.1;  // length in periods

/// The cycle of a point at any phase on its grid, continued beyond one period.
class Unrolled {
public:
    explicit Unrolled(const Point& p)
        : c_{&p.cycle}, n_{p.cycle.phase.size()}, D_{p.v_D.value / p.frequency} {}
    [[nodiscard]] double phase(std::size_t i) const {
        return c_->phase[i % n_] + static_cast<double>(i / n_);
    }
    [[nodiscard]] double x(std::size_t i) const { return c_->x_m[i % n_] + D_ * static_cast<double>(i / n_); }
    [[nodiscard]] double x_sd(std::size_t i) const { return c_->x_sd_m[i % n_]; }
    [[nodiscard]] double v_R(std::size_t i) const { return c_->v_mps[i % n_] - c_->v_base_mps[i % n_]; }
    [[nodiscard]] std::size_t size() const { return n_; }

private:
    const reduction::Cycle* c_;
    std::size_t n_;
    double D_;
};

// Phases of kinks in [0, 1), sorted.
std::vector<double> kinks(const Point& p, const Unrolled& cycle) {
    std::vector<double> out;
    for (std::size_t i = 0; i < cycle.size(); ++i) {
        const double a = cycle.v_R(i), b = cycle.v_R(i + 1);
        if ((a > 0) != (b > 0))
            out.push_back(cycle.phase(i) + (cycle.phase(i + 1) - cycle.phase(i)) * a / (a - b));
    }
    for (const auto& s : p.stick) {
        out.push_back(s.from);
        out.push_back(s.to);
    }
    for (double& phase : out) phase -= std::floor(phase);
    std::ranges::sort(out);
    return out;
}

bool sticks_at(const Point& p, double phase) {
    return std::ranges::any_of(p.stick, [&](const auto& s) {
        const double since = phase - s.from - std::floor(phase - s.from);
        return since <= s.to - s.from;
    });
}

// Columns 1, t, t^2/2 and the double integral of -v_R, which friction c v_R adds to x. t in s from the
// middle.
Eigen::MatrixXd columns(const Unrolled& cycle, const std::vector<std::size_t>& inside, double middle,
                        double T) {
    Eigen::MatrixXd A(static_cast<Eigen::Index>(inside.size()), 4);
    double t_before = 0, v_before = 0, once = 0, twice = 0;
    for (Eigen::Index k = 0; k < A.rows(); ++k) {
        const std::size_t i = inside[static_cast<std::size_t>(k)];
        const double t = (cycle.phase(i) - middle) * T, v_R = cycle.v_R(i);
        if (k > 0) {
            const double h = t - t_before, next = once + h * (v_before + v_R) / 2;
            twice += h * once + h * h * (2 * v_before + v_R) / 6;
            once = next;
        }
        A.row(k) << 1, t, t * t / 2, -twice;
        t_before = t;
        v_before = v_R;
    }
    return A;
}

std::optional<SlipPiece> fitted(const Point& p, const Unrolled& cycle, double from, double to) {
    std::vector<std::size_t> inside;
    for (std::size_t i = 0; i < 2 * cycle.size(); ++i)
        if (cycle.phase(i) >= from && cycle.phase(i) <= to) inside.push_back(i);
    const double frames = (to - from) * p.phases_per_period;
    if (inside.size() < 6) return std::nullopt;
    const auto n = static_cast<Eigen::Index>(inside.size());
    const double rows_per_frame = static_cast<double>(n) / frames;
    Eigen::MatrixXd A = columns(cycle, inside, (from + to) / 2, 1 / p.frequency);
    Eigen::VectorXd y(n), sigma(n);
    double v_R = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
        const std::size_t i = inside[static_cast<std::size_t>(k)];
        y[k] = cycle.x(i);
        sigma[k] = cycle.x_sd(i) / smoothed * std::sqrt(std::max(1.0, rows_per_frame));  // rows share frames
        v_R += cycle.v_R(i);
    }
    if (!(sigma.minCoeff() > 0)) return std::nullopt;
    const Eigen::VectorXd scale = A.cwiseAbs().colwise().maxCoeff();  // columns of like size, for the solver
    A = A * scale.cwiseInverse().asDiagonal();
    const Linear line = least_squares(A.leftCols(3), y, sigma, Weights::by_error),
                 bent = least_squares(A, y, sigma, Weights::by_error);
    return SlipPiece{.point = &p,
                     .sign = v_R > 0 ? 1 : -1,
                     .from = from,
                     .to = to,
                     .v_R = v_R / static_cast<double>(n),
                     .a = {line.x[2] / scale[2], std::sqrt(line.covariance(2, 2)) / scale[2]},
                     .viscous = {bent.x[3] / scale[3], std::sqrt(bent.covariance(3, 3)) / scale[3]}};
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

}  // namespace

std::vector<SlipPiece> slip_pieces(const Point& p, double frames) {
    std::vector<SlipPiece> pieces;
    if (p.cycle.phase.size() < 20 || !(p.phases_per_period > 0)) return pieces;
    const Unrolled cycle{p};
    const std::vector<double> at = kinks(p, cycle);
    const double margin = margin_frames / p.phases_per_period;
    for (std::size_t i = 0; i < at.size(); ++i) {
        const double from = at[i], to = i + 1 < at.size() ? at[i + 1] : at[0] + 1;
        const double length = to - from - 2 * margin;
        if (length < least_length || length * p.phases_per_period < least_frames) continue;
        if (sticks_at(p, (from + to) / 2)) continue;
        const double parts = std::max(1.0, std::floor(length * p.phases_per_period / frames));
        for (double k = 0; k < parts; ++k)
            if (const auto piece = fitted(p, cycle, from + margin + length * k / parts,
                                          from + margin + length * (k + 1) / parts))
                pieces.push_back(*piece);
    }
    return pieces;
}

std::vector<FrictionAt> friction_by_velocity(std::span<const Point> points, double g, double tilt) {
    constexpr double step = 1.6, unit = 1e-3;  // m/s
    constexpr std::size_t least = 3;
    std::map<std::pair<int, int>, std::vector<SlipPiece>> bins;  // sign, step of |v_R|
    for (const Point& p : points)
        for (const SlipPiece& piece : slip_pieces(p, least_frames))
            if (piece.a.sigma > 0 && piece.v_R != 0)
                bins[{piece.sign,
                      static_cast<int>(std::floor(std::log(std::abs(piece.v_R) / unit) / std::log(step)))}]
                    .push_back(piece);
    std::vector<FrictionAt> out;
    for (const auto& [key, pieces] : bins) {
        if (pieces.size() < least) continue;
        double weights = 0, mean = 0, v_R = 0, squares = 0;
        const auto mu_of = [&](const SlipPiece& s) {
            return s.sign * (g * std::sin(tilt) - s.a.value) / (g * std::cos(tilt));
        };
        for (const SlipPiece& s : pieces) {
            const double weight = std::pow(g / s.a.sigma, 2);
            weights += weight;
            mean += weight * mu_of(s);
            v_R += weight * s.v_R;
        }
        mean /= weights;
        for (const SlipPiece& s : pieces) squares += std::pow((mu_of(s) - mean) * g / s.a.sigma, 2);
        const auto n = static_cast<double>(pieces.size());
        out.push_back({v_R / weights,
                       {mean, std::sqrt(std::max(1.0, squares / (n - 1)) / weights)},
                       static_cast<int>(pieces.size())});
    }
    std::ranges::sort(out, {}, &FrictionAt::v_R);
    return out;
}

SlopeFit fit_slopes(std::span<const Point> points, double g) {
    SlopeFit out;
    out.mu = {.name = "mu_k", .unit = "1"};
    out.tilt = {.name = "tilt from slopes", .unit = "rad"};
    out.viscous = {.name = "viscous friction", .unit = "s-1"};
    std::vector<SlipPiece> pieces;
    for (const Point& p : points)
        for (const SlipPiece& piece : slip_pieces(p)) pieces.push_back(piece);
    bool both = false;
    for (const SlipPiece& piece : pieces) both = both || piece.sign != pieces.front().sign;
    if (!both) {
        out.mu.note = pieces.empty() ? "no slip is long enough between its kinks for the rate of the frames"
                                     : "slips of one direction only: friction and tilt cannot be separated";
        out.tilt.note = out.mu.note;
        return out;
    }
    const auto n = static_cast<Eigen::Index>(pieces.size());
    Eigen::MatrixXd A(n, 2);
    const Eigen::MatrixXd bend = Eigen::MatrixXd::Ones(n, 1);
    Eigen::VectorXd y(n), sigma(n), viscous(n), viscous_sigma(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const SlipPiece& piece = pieces[static_cast<std::size_t>(i)];
        A.row(i) << -piece.sign * g, g;
        y[i] = piece.a.value;
        sigma[i] = piece.a.sigma;

        viscous[i] = piece.viscous.value;
        viscous_sigma[i] = piece.viscous.sigma;
    }
    const Linear fit = least_squares(A, y, sigma, Weights::by_error);
    const Linear curved = least_squares(bend, viscous, viscous_sigma, Weights::by_error);
    const auto fill = [&](Fit& to, const Linear& from, Eigen::Index k) {
        to.value = from.x[k];
        to.error = std::sqrt(from.covariance(k, k));
        to.chi2 = from.chi2;
        to.freedom = from.freedom;
        to.points = static_cast<int>(n);
    };
    fill(out.mu, fit, 0);
    fill(out.tilt, fit, 1);
    fill(out.viscous, curved, 0);
    out.mu.note = misfit(fit.chi2, fit.freedom, "the slips scatter more than the errors of x(t)");
    const double scatter = std::sqrt(std::max(1.0, curved.chi2 / std::max(1, curved.freedom)));
    if (std::abs(out.viscous.value) > 4 * scatter * out.viscous.error)
        out.viscous.note = "the friction in slips depends on the velocity, and mu_k is a mean";
    out.covariance = {
        {"mu_k", "tilt"},
        {fit.covariance(0, 0), fit.covariance(0, 1), fit.covariance(1, 0), fit.covariance(1, 1)}};
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
