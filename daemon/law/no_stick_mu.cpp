#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "daemon/law/slope_mu.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::law {

namespace {

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
