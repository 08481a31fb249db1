#include "daemon/law/coulomb_fit.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "daemon/law/least_squares.hpp"
#include "drivers/errors.hpp"

namespace shaker::law {

namespace {

constexpr double lowest_mu = 0.02, highest_mu = 1, mu_step = 1.12;
constexpr std::size_t scanned = 40;  // points
constexpr double rough = 0.02;       // of gamma/omega, error of the law while mu is searched
constexpr int most_iterations = 12, least_moving = 3, least_pairs = 2;
constexpr double converged = 1e-3;  // of the standard error
constexpr int first_free = 9;       // lowest harmonic that the drive does not control
constexpr double tail = 3;

bool moves(const Point& p) { return std::abs(p.v_D.value) > 5 * p.v_D.sigma; }

double velocity_at(const Point& p, const Coulomb& law) { return pushed_cycle(p.base, p.frequency, law).v_D; }

// The mu of a grid that describes the points best, by a loss that bounds the weight of a single one.
double best_of_grid(std::span<const Point> points, const Coulomb& law) {
    const std::size_t every = std::max<std::size_t>(1, points.size() / scanned);
    double best = NAN, least = 1e300;
    for (double mu = lowest_mu; mu < highest_mu; mu *= mu_step) {
        Coulomb tried = law;
        tried.mu = mu;
        double loss = 0;
        for (std::size_t i = 0; i < points.size(); i += every) {
            const double off = points[i].v_D.value - velocity_at(points[i], tried);
            loss += std::log1p(std::pow(off / (rough * velocity_scale(points[i])), 2));
        }
        if (loss < least) least = loss, best = mu;
    }
    return best;
}

int mirror_pairs(std::span<const Point> points) {
    std::map<std::pair<int, int>, bool> known;
    for (const Point& p : points) known[{p.campaign, p.number}] = true;
    int pairs = 0;
    for (const Point& p : points) pairs += p.partner > p.number && known.contains({p.campaign, p.partner});
    return pairs;
}

// r and s from P_q = -(r + i s/q + u/q^2) a_w,q, q = 9..16 of all points: a base on a damped spring, far
// above its resonance. Least squares in real parts (r, u) and imaginary parts (s), which are independent.
Fit fitted_push(std::span<const Point> points, const std::vector<LawPoint>& at, double& drag) {
    Fit fit{.name = "m/M_eff", .unit = "1"};
    double s_top = 0, s_weight = 0, squares = 0;
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
        bool counts = false;
        for (int q = first_free; q <= max_harmonics; ++q) {
            const std::complex<double> a = at[i].cycle.walker[static_cast<std::size_t>(q - 1)];
            const double sd = points[i].base_sd[static_cast<std::size_t>(q - 1)],
                         weight = std::norm(a) / (sd * sd);
            if (!(sd > 0) || weight == 0) continue;
            const std::complex<double> ratio = -points[i].base.at(q) / a;
            const Eigen::Vector2d row{1, 1.0 / (q * q)};
            normal += weight * row * row.transpose();
            right += weight * ratio.real() * row;
            s_top += weight * ratio.imag() / q;
            s_weight += weight / (q * q);
            squares += weight * std::norm(ratio);
            fit.freedom += 2;
            counts = true;
        }
        fit.points += counts ? 1 : 0;
    }
    if (fit.points == 0) {
        fit.note = "no point has harmonics 9 to 16 with errors: the push of the walker is left out";
        return fit;
    }
    const Eigen::Matrix2d covariance = normal.inverse();
    const Eigen::Vector2d x = covariance * right;
    drag = s_top / s_weight;
    fit.value = x[0];
    fit.error = std::sqrt(covariance(0, 0));
    fit.chi2 = squares - x.dot(right) - s_top * s_top / s_weight;
    fit.freedom -= 3;
    fit.note =
        misfit(fit.chi2, fit.freedom, "harmonics 9 to 16 of the base have another source than the walker");
    return fit;
}

/// The state of Gauss-Newton.
class Search {
public:
    Search(std::span<const Point> points, const CoulombOptions& options)
        : points_{points}, options_{options}, tilted_{options.free_tilt && shows_tilt(points)} {
        fit_.law.g = options.g;
        fit_.law.mu = options.start_mu > 0 ? options.start_mu : best_of_grid(points, fit_.law);
    }

    CoulombFit run() {
        evaluate();
        for (int round = 0; round < most_iterations; ++round) {
            const double before = fit_.law.push;
            fit_.push = fitted_push(points_, fit_.points, fit_.law.drag);
            fit_.law.push = fit_.push.value > 0 ? fit_.push.value : 0;
            if (fit_.law.push == 0) fit_.law.drag = 0;
            if (std::abs(fit_.law.push - before) > converged * fit_.push.error) evaluate();
            const Linear step = linear();
            const double d_mu = std::clamp(step.x[0], -0.3 * fit_.law.mu, 0.3 * fit_.law.mu);
            const double d_tilt =
                tilted_ ? std::clamp(step.x[1], -0.2 * fit_.law.mu, 0.2 * fit_.law.mu) : 0.0;
            fit_.law.mu += d_mu;
            fit_.law.tilt += d_tilt;
            evaluate();
            const double error = std::sqrt(step.covariance(0, 0));
            const double tilt_error = tilted_ ? std::sqrt(step.covariance(1, 1)) : 1;
            if (std::abs(d_mu) < converged * error && std::abs(d_tilt) < converged * tilt_error)
                return finished();
        }
        fit_.mu = {.name = "mu_ac", .unit = "1", .points = static_cast<int>(points_.size())};
        fit_.mu.refused = true;
        fit_.mu.note = fmt::format("the fit did not converge; the last mu was {:.4g}", fit_.law.mu);
        fit_.tilt = {.name = "tilt", .unit = "rad"};
        return fit_;
    }

private:
    void evaluate() {
        std::vector<LawPoint> next;
        for (std::size_t i = 0; i < points_.size(); ++i)
            next.push_back(
                law_point(points_[i], fit_.law, fit_.points.empty() ? nullptr : &fit_.points[i].cycle));
        fit_.points = std::move(next);
    }

    [[nodiscard]] double error_of(std::size_t i) const {
        return std::hypot(points_[i].v_D.sigma, fit_.points[i].base_error);
    }

    [[nodiscard]] Linear linear() {
        const auto n = static_cast<Eigen::Index>(points_.size());
        Eigen::MatrixXd A(n, tilted_ ? 2 : 1);
        Eigen::VectorXd y(n), sigma(n);
        for (Eigen::Index k = 0; k < n; ++k) {
            const auto i = static_cast<std::size_t>(k);
            A(k, 0) = fit_.points[i].by_mu;
            if (tilted_) A(k, 1) = fit_.points[i].by_tilt;
            y[k] = points_[i].v_D.value - fit_.points[i].v_D;
            sigma[k] = error_of(i);
        }
        return least_squares(A, y, sigma, Weights::by_error);
    }

    CoulombFit finished() {
        const Linear last = linear();
        fit_.gain.assign(last.gain.row(0).begin(), last.gain.row(0).end());
        fit_.mu = {.name = "mu_ac",
                   .value = fit_.law.mu,
                   .error = std::sqrt(last.covariance(0, 0)),
                   .unit = "1",
                   .chi2 = last.chi2,
                   .freedom = last.freedom,
                   .points = static_cast<int>(points_.size())};
        fit_.mu.note = misfit(
            last.chi2, last.freedom,
            "Coulomb's law with one mu does not describe the points; \"shakerd law\" compares other laws");
        fit_.mu.refused = !fit_.mu.note.empty();
        fit_.tilt = {.name = "tilt", .unit = "rad"};
        fit_.covariance = {{"mu_ac"}, {last.covariance(0, 0)}};
        if (tilted_) {
            fit_.tilt.value = fit_.law.tilt;
            fit_.tilt.error = std::sqrt(last.covariance(1, 1));
            fit_.tilt.chi2 = last.chi2;
            fit_.tilt.freedom = last.freedom;
            fit_.tilt.points = fit_.mu.points;
            fit_.covariance.names.emplace_back("tilt");
            fit_.covariance.values = {last.covariance(0, 0), last.covariance(0, 1), last.covariance(1, 0),
                                      last.covariance(1, 1)};
        } else {
            fit_.tilt.note =
                "not fitted: fewer than two pairs of mirror partners; the base is taken as level";
        }
        for (std::size_t i = 0; i < points_.size(); ++i) {
            LawPoint& p = fit_.points[i];
            p.z = (points_[i].v_D.value - p.v_D) / error_of(i);
            fit_.beyond_3 += std::abs(p.z) > tail;
        }
        without_push();
        return std::move(fit_);
    }

    void without_push() {
        Coulomb law = fit_.law;
        law.push = law.drag = 0;
        fit_.chi2_without_push = 0;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const double z = (points_[i].v_D.value - velocity_at(points_[i], law)) / error_of(i);
            fit_.chi2_without_push += z * z;
            fit_.beyond_3_without_push += std::abs(z) > tail;
        }
    }

    std::span<const Point> points_;
    CoulombOptions options_;
    bool tilted_;
    CoulombFit fit_;
};

}  // namespace

LawPoint law_point(const Point& point, const Coulomb& law, const PushedCycle* start) {
    LawPoint out;
    out.cycle = pushed_cycle(point.base, point.frequency, law, start);
    const Sensitivity by{out.cycle, point.frequency, law};
    out.v_D = out.cycle.v_D + law.drag * by.by_drag();
    out.by_mu = by({.mu = 1});
    out.by_tilt = by({.tilt = 1});
    out.by_push = by({.push = 1});
    out.by_gravity = by({.gravity = 1});
    const Amplitudes gradient = by.by_base();
    double variance = 0;
    for (std::size_t i = 0; i < max_harmonics; ++i) {
        variance += std::norm(gradient[i]) * std::pow(point.base_sd[i], 2);
        const double q = static_cast<double>(i + 1);
        const std::complex<double> along = std::conj(gradient[i]) * point.base.a[i];
        out.by_gain += along.real();
        out.by_turn -= along.imag() * (q - 1 / q) / 1.5;
    }
    out.base_error =
        std::sqrt(variance + std::pow(out.by_turn * std::hypot(point.turn_sd, point.turn_told), 2));
    return out;
}

bool shows_tilt(std::span<const Point> points) { return mirror_pairs(points) >= least_pairs; }

CoulombFit fit_coulomb(std::span<const Point> points, const CoulombOptions& options) {
    CoulombFit none;
    none.mu = {.name = "mu_ac", .unit = "1", .points = static_cast<int>(points.size())};
    none.tilt = {.name = "tilt", .unit = "rad"};
    none.push = {.name = "m/M_eff", .unit = "1"};
    const auto moving = std::count_if(points.begin(), points.end(), moves);
    if (moving < least_moving) {
        none.mu.note =
            fmt::format("{} of {} points move; at least {} are needed", moving, points.size(), least_moving);
        return none;
    }
    try {
        return Search{points, options}.run();
    } catch (const InputError& error) {  // no settled motion: tilt beyond the angle of friction
        none.mu.note = error.what();
        return none;
    }
}

}  // namespace shaker::law
