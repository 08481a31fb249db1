#include "calibration/accelerometer/tumble.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

/// A signed permutation: the sensor's axis i is the counts' axis from[i] times sign[i].
struct AxisOrder {
    std::array<std::size_t, 3> from{0, 1, 2};
    std::array<double, 3> sign{1, 1, 1};
    [[nodiscard]] Vector operator()(const Vector& of_counts) const noexcept {
        return {sign[0] * of_counts[from[0]], sign[1] * of_counts[from[1]], sign[2] * of_counts[from[2]]};
    }
    /// "axes x and y are exchanged", "axis z is reversed", ...; empty for the identity.
    [[nodiscard]] std::string sentence() const;
};

constexpr double clearly_better = 0.5;  // in the sum of cosines of all attitudes
constexpr std::ptrdiff_t fewest_names = 6;

double cosine(const Vector& a, const Vector& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Sum of the cosines between names and directions in this order.
double agreement(const AxisOrder& order, std::span<const Attitude> attitudes,
                 std::span<const Vector> directions) {
    double sum = 0;
    for (std::size_t i = 0; i < attitudes.size(); ++i)
        if (const auto up = direction_of(attitudes[i].name)) sum += cosine(*up, order(directions[i]));
    return sum;
}

std::string AxisOrder::sentence() const {
    std::vector<std::string> moved, reversed;
    for (std::size_t i = 0; i < 3; ++i) {
        if (from[i] != i) moved.emplace_back(1, "xyz"[i]);
        if (sign[i] < 0) reversed.emplace_back(1, "xyz"[i]);
    }
    std::string text;
    if (moved.size() == 2) text = fmt::format("axes {} and {} are swapped", moved[0], moved[1]);
    if (moved.size() == 3)
        text = fmt::format("all axes are swapped: x, y, z arrive as {}, {}, {}", "xyz"[from[0]],
                           "xyz"[from[1]], "xyz"[from[2]]);
    if (!reversed.empty())
        text +=
            fmt::format("{}ax{} {} {} flipped", text.empty() ? "" : "; ", reversed.size() == 1 ? "is" : "es",
                        fmt::join(reversed, ", "), reversed.size() == 1 ? "is" : "are");
    if (text.empty()) return text;
    return text + " against the names of the attitudes; the gain matrix corrects it";
}

/// The order that fits the names best; the identity if fewer than six attitudes have one. directions: of up,
/// in the counts' axes. InputError names an attitude farther than same_attitude from its name.
AxisOrder axis_order(std::span<const Attitude> attitudes, std::span<const Vector> directions) {
    AxisOrder best, order;
    const auto named = std::ranges::count_if(attitudes, [](const Attitude& a) { return !a.name.empty(); });
    double most = agreement(best, attitudes, directions) + clearly_better;
    do {
        for (int signs = 0; signs < 8 && named >= fewest_names; ++signs) {
            for (std::size_t k = 0; k < 3; ++k) order.sign[k] = (signs >> k & 1) != 0 ? -1 : 1;
            const double sum = agreement(order, attitudes, directions);
            if (sum > most) most = sum, best = order;
        }
    } while (std::ranges::next_permutation(order.from).found);
    for (std::size_t i = 0; i < attitudes.size(); ++i) {
        const auto up = direction_of(attitudes[i].name);
        if (!up || cosine(*up, best(directions[i])) > std::cos(same_attitude)) continue;
        throw InputError{fmt::format(
            "{}: the sensor was held {:.0f} deg away from it, near {}; hold it again or correct its name",
            label_of(i, attitudes[i]),
            std::acos(std::clamp(cosine(*up, best(directions[i])), -1.0, 1.0)) * 180 / std::numbers::pi,
            nearest_attitude(best(directions[i])))};
    }
    return best;
}

using Parameters = Eigen::Matrix<double, 9, 1>;
using Normal = Eigen::MatrixXd;  // 9 x 9; of fixed size it costs the compiler 4 s more

constexpr double parts_of_record = 10;
constexpr double unlikely = 1e-4;        // chance of chi2 below which the errors are widened
constexpr double worst_residual = 1e-3;  // g rms
constexpr int most_steps = 50;
constexpr double longest_step = 0.3, last_step = 1e-13;

Eigen::Vector3d eigen(const Vector& v) { return {v[0], v[1], v[2]}; }

// Derivative of |(I + E) a + b| / g for |a| = g and unit vector n along a; Tumble lists the parameters.
Parameters derivative(const Eigen::Vector3d& n) {
    Parameters d;
    d << n[0] * n[0], n[1] * n[1], n[2] * n[2], 2 * n[0] * n[1], 2 * n[0] * n[2], 2 * n[1] * n[2], n;
    return d;
}

Eigen::Matrix3d tensor(const Parameters& p) {
    Eigen::Matrix3d e;
    e << p[0], p[3], p[4], p[3], p[1], p[5], p[4], p[5], p[2];
    return e;
}

// a = gain * counts + rest.
struct Model {
    Eigen::Matrix3d gain;
    Eigen::Vector3d rest = Eigen::Vector3d::Zero();
    [[nodiscard]] Eigen::Vector3d operator()(const Vector& counts) const {
        return gain * eigen(counts) + rest;
    }
};

// One Gauss-Newton problem at a model: normal equations and residuals.
struct Equations {
    Normal normal = Normal::Zero(9, 9);
    Parameters right = Parameters::Zero();
    double chi2 = 0, squares = 0;  // squares: of the residuals, g^2
    double largest = 0;            // residual over its standard error
    std::size_t of = 0;            // its attitude
};

// variance: of the attitudes' means, counts^2.
Equations equations(std::span<const Attitude> attitudes, const Model& model, const Vector& variance,
                    double g) {
    Equations all;
    for (std::size_t i = 0; i < attitudes.size(); ++i) {
        const Eigen::Vector3d a = model(attitudes[i].mean), n = a.normalized();
        const Eigen::Vector3d by_counts = model.gain.transpose() * n / g;
        const double sigma = std::sqrt(by_counts.cwiseAbs2().dot(eigen(variance)));
        const double residual = a.norm() / g - 1;
        const Parameters d = derivative(n) / sigma;
        all.normal += d * d.transpose();
        all.right -= d * (residual / sigma);
        all.chi2 += residual * residual / sigma / sigma;
        all.squares += residual * residual;
        if (std::abs(residual / sigma) < all.largest) continue;
        all.largest = std::abs(residual / sigma);
        all.of = i;
    }
    return all;
}

Eigen::Matrix3d order_matrix(const AxisOrder& order, const Vector& nominal) {
    Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        m(i, static_cast<Eigen::Index>(order.from[k])) = order.sign[k] * nominal[order.from[k]];
    }
    return m;
}

// Turns the model so that it is a symmetric matrix times `start`.
void turn_to(const Eigen::Matrix3d& start, Model& model) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd{model.gain * start.inverse(),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV};
    const Eigen::Matrix3d back = svd.matrixV() * svd.matrixU().transpose();
    model.gain = back * model.gain;
    model.rest = back * model.rest;
}

// Pooled over the attitudes: the noise is the sensor's.
Vector variance_of_means(std::span<const Attitude> attitudes) {
    Vector variance{};
    for (std::size_t k = 0; k < 3; ++k) {
        for (const Attitude& a : attitudes)
            variance[k] += a.variance[k] / parts_of_record / static_cast<double>(attitudes.size());
        // Without noise that dithers it, rounding is an error of the mean.
        if (variance[k] < 1e-7) variance[k] = 1.0 / 12;
    }
    return variance;
}

void require_rest(std::span<const Attitude> attitudes, const Vector& nominal, double g) {
    const Vector counts_per_g{g / nominal[0], g / nominal[1], g / nominal[2]};
    for (std::size_t i = 0; i < attitudes.size(); ++i)
        if (const std::string why = motion_in(attitudes[i], counts_per_g); !why.empty())
            throw InputError{label_of(i, attitudes[i]) + ": " + why + "; hold it still and record it again"};
}

void require_spread(std::span<const Vector> directions) {
    const double condition = condition_of(directions);
    if (condition <= worst_condition) return;
    throw InputError{fmt::format(
        "{} attitudes do not determine gains and offsets: the condition number is {:.3g}, at most {:.0f} is "
        "allowed; hold the sensor also at {}",
        directions.size(), condition, worst_condition, fmt::join(missing_attitudes(directions), ", "))};
}

Model solved(std::span<const Attitude> attitudes, const Eigen::Matrix3d& start, const Vector& variance,
             double g) {
    Model model{start};
    for (int i = 0; i < most_steps; ++i) {
        const Equations e = equations(attitudes, model, variance, g);
        Parameters step = e.normal.ldlt().solve(e.right);
        step *= std::min(1.0, longest_step / step.cwiseAbs().maxCoeff());
        const Eigen::Matrix3d change = Eigen::Matrix3d::Identity() + tensor(step);
        model.gain = change * model.gain;
        model.rest = change * model.rest + g * step.tail<3>();
        if (step.cwiseAbs().maxCoeff() < last_step) break;
    }
    turn_to(start, model);
    return model;
}

// Chance of chi2; a small one widens the errors and is named.
void judge(Tumble& fit, const Equations& e, std::span<const Attitude> attitudes) {
    const double ratio = fit.chi2 / fit.degrees_of_freedom;
    fit.chance =
        boost::math::cdf(boost::math::complement(boost::math::chi_squared(fit.degrees_of_freedom), fit.chi2));
    const double rms = fit.rms_residual / fit.gravity.value;
    const std::string worst = label_of(e.of, attitudes[e.of]);
    if (!(rms <= worst_residual))
        throw InputError{fmt::format(
            "the magnitude of the reading varies by {:.2g} g (rms) between the attitudes after the fit, at "
            "most {:.0e} g is allowed; {} deviates most: record the attitudes again",
            rms, worst_residual, worst)};
    if (fit.chance >= unlikely) return;
    for (double& c : fit.covariance) c *= ratio;
    fit.findings.push_back(
        fmt::format("the attitudes disagree by {:.2g} times their noise (chi2 {:.4g} of {}): errors are "
                    "widened; {} deviates most",
                    std::sqrt(ratio), fit.chi2, fit.degrees_of_freedom, worst));
}

}  // namespace

double Tumble::gain_error(const Vector& u) const noexcept {
    const Parameters d = derivative(eigen(u));
    const Eigen::Map<const Normal> c{covariance.data(), 9, 9};  // symmetric
    const Eigen::Matrix<double, 6, 1> e = d.head<6>();
    return std::hypot(std::sqrt(e.dot(c.topLeftCorner(6, 6) * e)), gravity.sigma / gravity.value);
}

double Tumble::reading_error(const Vector& u, const Vector& a) const noexcept {
    const double g = gravity.value;
    Parameters d;
    d << u[0] * a[0], u[1] * a[1], u[2] * a[2], u[0] * a[1] + u[1] * a[0], u[0] * a[2] + u[2] * a[0],
        u[1] * a[2] + u[2] * a[1], g * u[0], g * u[1], g * u[2];
    const Eigen::Map<const Normal> c{covariance.data(), 9, 9};  // symmetric
    const double along = u[0] * a[0] + u[1] * a[1] + u[2] * a[2];
    return std::hypot(std::sqrt(d.dot(c * d)), along * gravity.sigma / g);
}

Vector Tumble::offset_errors() const noexcept {
    Eigen::Matrix3d k;
    for (Eigen::Index i = 0; i < 9; ++i)
        k(i / 3, i % 3) = gain[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)];
    const Eigen::Map<const Normal> c{covariance.data(), 9, 9};  // symmetric
    const Eigen::Matrix3d back = k.inverse() * gravity.value;
    const Eigen::Vector3d variance = (back * c.bottomRightCorner(3, 3) * back.transpose()).diagonal();
    return {std::sqrt(variance[0]), std::sqrt(variance[1]), std::sqrt(variance[2])};
}

double condition_of(std::span<const Vector> directions) {
    if (directions.size() < 9) return std::numeric_limits<double>::infinity();
    Normal normal = Normal::Zero(9, 9);
    for (const Vector& n : directions) {
        const Parameters d = derivative(eigen(n).normalized());
        normal += d * d.transpose();
    }
    const auto values = Eigen::SelfAdjointEigenSolver<Normal>{normal, Eigen::EigenvaluesOnly}.eigenvalues();
    return values[0] > 0 ? values[8] / values[0] : std::numeric_limits<double>::infinity();
}

std::vector<Vector> nominal_directions(std::span<const Attitude> attitudes, const Vector& nominal) {
    std::vector<Vector> directions;
    for (const Attitude& a : attitudes) {
        const Eigen::Vector3d n = eigen(a.mean).cwiseProduct(eigen(nominal)).normalized();
        directions.push_back({n[0], n[1], n[2]});
    }
    return directions;
}

Vector guessed_scales(std::span<const Attitude> attitudes, double gravity) {
    Vector most{};
    for (const Attitude& a : attitudes)
        for (std::size_t k = 0; k < 3; ++k) most[k] = std::max(most[k], std::abs(a.mean[k]));
    // An axis that never pointed up or down is taken for one like the others.
    const double all = *std::ranges::max_element(most);
    Vector scales{};
    for (std::size_t k = 0; k < 3; ++k) scales[k] = gravity / (most[k] > all / 3 ? most[k] : all);
    return scales;
}

Tumble fit_tumble(std::span<const Attitude> attitudes, const Vector& nominal, const Estimate& gravity) {
    const double g = gravity.value;
    require_rest(attitudes, nominal, g);
    std::vector<Vector> directions = nominal_directions(attitudes, nominal);
    const AxisOrder order = axis_order(attitudes, directions);
    for (Vector& d : directions) d = order(d);
    require_spread(directions);
    const Vector variance = variance_of_means(attitudes);
    const Model model = solved(attitudes, order_matrix(order, nominal), variance, g);
    const Equations e = equations(attitudes, model, variance, g);

    Tumble fit{.gravity = gravity, .attitudes = static_cast<int>(attitudes.size())};
    const Normal covariance = e.normal.ldlt().solve(Normal::Identity(9, 9));
    const Eigen::Vector3d offset = model.gain.inverse() * model.rest;
    for (std::size_t i = 0; i < 9; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        fit.gain[i / 3][i % 3] = model.gain(row / 3, row % 3);
        if (i < 3) fit.offset_counts[i] = offset[row];
        for (Eigen::Index k = 0; k < 9; ++k)
            fit.covariance[9 * i + static_cast<std::size_t>(k)] = covariance(row, k);
    }
    fit.condition = condition_of(directions);
    fit.chi2 = e.chi2;
    fit.degrees_of_freedom = fit.attitudes - 9;
    fit.rms_residual = g * std::sqrt(e.squares / fit.attitudes);
    if (const std::string exchanged = order.sentence(); !exchanged.empty()) fit.findings.push_back(exchanged);
    if (fit.degrees_of_freedom > 0) judge(fit, e, attitudes);
    return fit;
}

Estimate normal_gravity(double latitude, double height) noexcept {
    // WGS 84 (NIMA TR8350.2): equatorial gravity, Somigliana's constant, eccentricity^2, semi-major axis,
    // flattening, and m = omega^2 a^2 b / GM.
    constexpr double at_equator = 9.7803253359, k = 0.00193185265241, e2 = 0.00669437999013, a = 6378137,
                     f = 1 / 298.257223563, m = 0.00344978650684, anomaly = 3e-4;
    const double s2 = std::pow(std::sin(latitude), 2);
    const double on_ellipsoid = at_equator * (1 + k * s2) / std::sqrt(1 - e2 * s2);
    const double h = height / a;
    return {on_ellipsoid * (1 - 2 * (1 + f + m - 2 * f * s2) * h + 3 * h * h), anomaly};
}

}  // namespace shaker::calibration
