#include "daemon/control/harmonic_estimator.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calibration/accelerometer/transverse.hpp"

namespace shaker::control {

namespace {
constexpr int most_columns = 2 * max_harmonics + 3;
constexpr double largest_gap = 0.1;  // turns
// Times the second eigenvalue: above it the direction is defined by motion, not noise.
constexpr double one_direction = 100;
constexpr double same_direction = 0.95;  // cosine
constexpr int windows_to_turn = 3;       // in a row, until another direction counts as that of the shaker
using Eigen::Index;
}  // namespace

int periods_to_tell(double ratio, int harmonics) {
    if (!(ratio > 0)) return 1;
    // Above the last harmonic plus a quarter the nearest column is still the last harmonic.
    const double nearest = std::clamp(std::round(ratio), 0.0, static_cast<double>(harmonics));
    const double distance = std::abs(ratio - nearest);
    for (int n = 1; n <= 5; ++n)
        if (n * distance > 0.85) return n;
    return 0;
}

struct HarmonicEstimator::Work {
    EstimatorSettings s;
    Index columns;
    Eigen::MatrixXd basis;  // one row per sample
    Eigen::MatrixX3d a;
    Index rows = 0;
    std::int64_t window = -1;
    Eigen::Vector3d newest{0, 0, 0};      // direction that motion defined
    int agree = 0;                        // windows in a row with that direction
    double first = 0, last = 0, gap = 0;  // turns
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_columns, most_columns> normal, inverse;
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, most_columns, 3> right;
    Eigen::LLT<decltype(normal)> solver;

    explicit Work(const EstimatorSettings& settings)
        : s{settings},
          columns{2 * Index{s.harmonics} + 1 + (s.line > 0 ? 2 : 0)},
          basis{s.samples, columns},
          a{s.samples, 3} {}
    [[nodiscard]] bool complete() const {
        const double begin = static_cast<double>(window) * s.periods;
        const double edge = std::max(first - begin, begin + s.periods - last);
        return rows >= Index{least_samples(s.harmonics)} * s.periods && std::max(gap, edge) < largest_gap;
    }
    void add(double turns, const std::array<double, 3>& sample);
    [[nodiscard]] std::optional<PeriodEstimate> estimate();
    [[nodiscard]] Eigen::Vector3d strongest();
    void spread(PeriodEstimate& e, const Eigen::Vector3d& u);
};

void HarmonicEstimator::Work::add(double turns, const std::array<double, 3>& sample) {
    if (rows == basis.rows()) return;
    const std::complex<double> z = std::polar(1.0, two_pi * (turns - std::floor(turns)));
    std::complex<double> power = 1;
    basis(rows, 0) = 1;
    for (Index q = 1; q <= s.harmonics; ++q) {
        power *= z;
        basis(rows, 2 * q - 1) = power.imag();
        basis(rows, 2 * q) = power.real();
    }
    if (s.line > 0) {
        const double phase = two_pi * s.line * (turns - static_cast<double>(window * s.periods));
        basis(rows, columns - 2) = std::sin(phase);
        basis(rows, columns - 1) = std::cos(phase);
    }
    for (int k = 0; k < 3; ++k) a(rows, k) = sample[static_cast<std::size_t>(k)];
    ++rows;
}

// Principal direction of the sine and cosine vectors of harmonics 1 and 2: the direction of the shaker's
// motion in sensor axes. Once found it keeps its sign, also if two components are equally large. A step in
// one window, as of gravity when the sensor's lead comes off, is no direction.
Eigen::Vector3d HarmonicEstimator::Work::strongest() {
    const Eigen::Matrix3d scatter = right.middleRows(1, 4).transpose() * right.middleRows(1, 4);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen{scatter};
    Eigen::Vector3d u = eigen.eigenvectors().col(2);
    const Eigen::Vector3d before{s.before[0], s.before[1], s.before[2]};
    Index largest = 0;
    u.cwiseAbs().maxCoeff(&largest);
    if (before.isZero() ? u[largest] < 0 : u.dot(before) < 0) u = -u;
    if (eigen.eigenvalues()[2] > one_direction * eigen.eigenvalues()[1]) {
        agree = std::abs(u.dot(newest)) > same_direction ? agree + 1 : 1;
        newest = u;
        if (before.isZero() || std::abs(u.dot(before)) > same_direction || agree >= windows_to_turn)
            s.before = {u[0], u[1], u[2]};
    }
    return u;
}

// Residual of the fit and the errors of the amplitudes that follow from it.
void HarmonicEstimator::Work::spread(PeriodEstimate& e, const Eigen::Vector3d& u) {
    double squares = 0;
    for (Index i = 0; i < rows; ++i) {
        const double r = (a.row(i) - basis.row(i) * right).dot(u);
        squares += r * r;
    }
    const double variance = squares / static_cast<double>(std::max<Index>(1, rows - columns));
    e.residual = std::sqrt(variance);
    inverse.setIdentity(columns, columns);
    solver.solveInPlace(inverse);
    const Index n = 2 * Index{s.harmonics};
    double sum = 0;
    for (Index i = 0; i < n; ++i) {
        sum += inverse(i + 1, i + 1);
        for (Index j = 0; j < n; ++j)
            e.cov[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
                variance * inverse(i + 1, j + 1);
    }
    e.sd = std::sqrt(variance * sum / static_cast<double>(n));
}

std::optional<PeriodEstimate> HarmonicEstimator::Work::estimate() {
    if (!complete()) return std::nullopt;
    const auto b = basis.topRows(rows);
    normal.resize(columns, columns);
    normal.noalias() = b.transpose().lazyProduct(b);
    right.noalias() = b.transpose().lazyProduct(a.topRows(rows));
    solver.compute(normal);
    if (solver.info() != Eigen::Success) return std::nullopt;
    solver.solveInPlace(right);
    const Eigen::Vector3d given{s.axis[0], s.axis[1], s.axis[2]};
    const Eigen::Vector3d u = given.isZero() ? strongest() : given;
    const auto across = calibration::across_axes({u[0], u[1], u[2]});
    PeriodEstimate e;
    e.period = window * s.periods;
    e.periods = s.periods;
    e.samples = static_cast<int>(rows);
    e.axis = {u[0], u[1], u[2]};
    e.mean = {right(0, 0), right(0, 1), right(0, 2)};
    for (int q = 1; q <= s.harmonics; ++q) {
        const auto sine = right.row(2 * Index{q} - 1), cosine = right.row(2 * Index{q});
        e.along.at(q) = {sine.dot(u), cosine.dot(u)};
        for (std::size_t k = 0; k < 2; ++k) {
            const Eigen::Map<const Eigen::Vector3d> beside{across[k].data()};
            e.across[k].at(q) = {sine.dot(beside), cosine.dot(beside)};
        }
    }
    if (s.line > 0) e.line = {right.row(columns - 2).dot(u), right.row(columns - 1).dot(u)};
    spread(e, u);
    if (!std::isfinite(e.sd)) return std::nullopt;
    return e;
}

HarmonicEstimator::HarmonicEstimator(const EstimatorSettings& settings)
    : work_{std::make_unique<Work>(settings)} {}
HarmonicEstimator::~HarmonicEstimator() = default;
const std::array<double, 3>& HarmonicEstimator::direction() const noexcept { return work_->s.before; }
HarmonicEstimator::HarmonicEstimator(HarmonicEstimator&&) noexcept = default;
HarmonicEstimator& HarmonicEstimator::operator=(HarmonicEstimator&&) noexcept = default;

std::optional<PeriodEstimate> HarmonicEstimator::add(double turns, const std::array<double, 3>& a) {
    Work& w = *work_;
    const auto window = static_cast<std::int64_t>(std::floor(turns / w.s.periods));
    std::optional<PeriodEstimate> done;
    if (window != w.window) {
        if (w.window >= 0) done = w.estimate();
        w.window = window;
        w.rows = 0;
        w.first = turns;
        w.gap = 0;
    } else {
        w.gap = std::max(w.gap, turns - w.last);
    }
    w.last = turns;
    w.add(turns, a);
    return done;
}

}  // namespace shaker::control
