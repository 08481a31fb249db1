#include "daemon/control/harmonic_estimator.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace shaker {

namespace {
constexpr int most_columns = 2 * max_harmonics + 1;
constexpr double largest_gap = 0.1;  // turns
}  // namespace

struct HarmonicEstimator::Work {
    Eigen::Index harmonics;
    Eigen::Vector3d axis;
    Eigen::MatrixXd basis;  // a row a sample
    Eigen::MatrixX3d a;
    Eigen::Index rows = 0;
    std::int64_t period = -1;
    double first = 0, last = 0, gap = 0;  // turns
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_columns, most_columns> normal;
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, most_columns, 3> right;
    Eigen::LLT<decltype(normal)> solver;

    Work(int k, int samples, std::array<double, 3> u)
        : harmonics{k}, axis{u[0], u[1], u[2]}, basis{samples, 2 * Eigen::Index{k} + 1}, a{samples, 3} {}
    [[nodiscard]] bool complete() const {
        const double edge =
            std::max(first - static_cast<double>(period), static_cast<double>(period) + 1 - last);
        return rows >= 3 * harmonics && std::max(gap, edge) < largest_gap;
    }
    [[nodiscard]] std::optional<PeriodEstimate> estimate();
    [[nodiscard]] Eigen::Vector3d strongest() const;
};

// Principal direction of the lock-in vectors of harmonics 1 and 2: where the shaker moves the sensor.
Eigen::Vector3d HarmonicEstimator::Work::strongest() const {
    const Eigen::Matrix3d scatter = right.middleRows(1, 4).transpose() * right.middleRows(1, 4);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen{scatter};
    Eigen::Vector3d u = eigen.eigenvectors().col(2);
    Eigen::Index largest = 0;
    u.cwiseAbs().maxCoeff(&largest);
    return u[largest] < 0 ? Eigen::Vector3d{-u} : u;
}

std::optional<PeriodEstimate> HarmonicEstimator::Work::estimate() {
    if (!complete()) return std::nullopt;
    const auto b = basis.topRows(rows);
    const auto y = a.topRows(rows);
    const Eigen::Index columns = 2 * harmonics + 1;
    normal.resize(columns, columns);
    normal.noalias() = b.transpose().lazyProduct(b);
    right.noalias() = b.transpose().lazyProduct(y);
    solver.compute(normal);
    if (solver.info() != Eigen::Success) return std::nullopt;
    solver.solveInPlace(right);
    const Eigen::Vector3d u = axis.isZero() ? strongest() : axis;
    PeriodEstimate e;
    e.period = period;
    e.samples = static_cast<int>(rows);
    e.axis = {u[0], u[1], u[2]};
    for (Eigen::Index q = 1; q <= harmonics; ++q)
        e.along.at(static_cast<int>(q)) = {right.row(2 * q - 1).dot(u), right.row(2 * q).dot(u)};
    double squares = 0;
    for (Eigen::Index i = 0; i < rows; ++i) {
        const double r = (y.row(i) - b.row(i) * right).dot(u);
        squares += r * r;
    }
    const auto freedom = static_cast<double>(std::max<Eigen::Index>(1, rows - columns));
    e.sd = std::sqrt(2 * squares / freedom / static_cast<double>(rows));
    if (!std::isfinite(e.sd)) return std::nullopt;
    return e;
}

HarmonicEstimator::HarmonicEstimator(int harmonics, int samples, std::array<double, 3> axis)
    : work_{std::make_unique<Work>(harmonics, samples, axis)} {}
HarmonicEstimator::~HarmonicEstimator() = default;
HarmonicEstimator::HarmonicEstimator(HarmonicEstimator&&) noexcept = default;
HarmonicEstimator& HarmonicEstimator::operator=(HarmonicEstimator&&) noexcept = default;

std::optional<PeriodEstimate> HarmonicEstimator::add(double turns, const std::array<double, 3>& a) {
    Work& w = *work_;
    const auto period = static_cast<std::int64_t>(std::floor(turns));
    std::optional<PeriodEstimate> done;
    if (period != w.period) {
        if (w.period >= 0) done = w.estimate();
        w.period = period;
        w.rows = 0;
        w.first = turns;
        w.gap = 0;
    } else {
        w.gap = std::max(w.gap, turns - w.last);
    }
    w.last = turns;
    if (w.rows == w.basis.rows()) return done;
    const std::complex<double> z = std::polar(1.0, two_pi * (turns - static_cast<double>(period)));
    std::complex<double> power = 1;
    w.basis(w.rows, 0) = 1;
    for (Eigen::Index q = 1; q <= w.harmonics; ++q) {
        power *= z;
        w.basis(w.rows, 2 * q - 1) = power.imag();
        w.basis(w.rows, 2 * q) = power.real();
    }
    for (int k = 0; k < 3; ++k) w.a(w.rows, k) = a[static_cast<std::size_t>(k)];
    ++w.rows;
    return done;
}

}  // namespace shaker
