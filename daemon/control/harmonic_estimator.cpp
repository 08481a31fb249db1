#include "daemon/control/harmonic_estimator.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <string>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

constexpr int most_unknowns = 2 * max_harmonics + 1;
// Sizes bounded at compile time: Eigen then never allocates.
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_unknowns, most_unknowns>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_unknowns, 1>;

}  // namespace

struct HarmonicEstimator::Impl {
    int order;
    Eigen::Vector3d axis;
    Matrix normal, inverse;
    Vector right, row;
    double squares = 0;
    double first = 0, last = -1, widest = 0;  // turns
    int samples = 0;
    bool broken = true;  // the first period is not seen from its start
    HarmonicEstimate estimate;

    void clear() {
        normal.setZero();
        right.setZero();
        squares = widest = 0;
        samples = 0;
        broken = false;
    }
    [[nodiscard]] bool whole() const {
        const double usual = 1.0 / std::max(samples, 1);
        return !broken && samples > 2 * order + 2 && widest < 2.5 * usual && first + 1 - last < 2.5 * usual;
    }
    void finish() {
        estimate = {};
        estimate.samples = samples;
        if (!whole()) return;
        const Matrix full = normal.selfadjointView<Eigen::Lower>();
        const Eigen::LLT<Matrix> llt(full);
        if (llt.info() != Eigen::Success) return;
        const Vector p = llt.solve(right);
        inverse = llt.solve(Matrix::Identity(full.rows(), full.cols()));
        const double rest = std::max(0.0, squares - p.dot(right)) / (samples - 2 * order - 1);
        inverse *= rest;
        for (int q = 1; q <= order; ++q) {
            const int i = 2 * (q - 1);
            estimate.harmonics.at(q) = {p(i), p(i + 1)};
            estimate.sd[static_cast<std::size_t>(q - 1)] =
                std::sqrt((inverse(i, i) + inverse(i + 1, i + 1)) / 2);
        }
        estimate.offset_mps2 = p(p.size() - 1);
        estimate.rms_mps2 = std::sqrt(rest);
        estimate.valid = p.allFinite();
    }
    void take(double turns, const std::array<double, 3>& a) {
        const double y = axis.dot(Eigen::Vector3d(a[0], a[1], a[2]));
        if (!std::isfinite(y)) {
            broken = true;
            return;
        }
        const std::complex<double> z = std::polar(1.0, two_pi * turns);
        std::complex<double> zq = 1;
        for (Eigen::Index q = 0; q < order; ++q) {
            zq *= z;
            row(2 * q) = zq.imag();
            row(2 * q + 1) = zq.real();
        }
        row(row.size() - 1) = 1;
        normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
        right += y * row;
        squares += y * y;
        if (samples == 0) {
            first = turns;
        } else {
            widest = std::max(widest, turns - last);
        }
        ++samples;
    }
};

HarmonicEstimator::HarmonicEstimator(int order, const std::array<double, 3>& axis)
    : impl_(std::make_unique<Impl>()) {
    if (order < 1 || order > max_harmonics) {
        throw InputError("harmonics " + std::to_string(order) + "; allowed are 1 to " +
                         std::to_string(max_harmonics));
    }
    const Eigen::Vector3d direction(axis[0], axis[1], axis[2]);
    if (!(direction.norm() > 0) || !direction.allFinite()) {
        throw InputError("shaker axis is not a direction: its length must be finite and more than 0");
    }
    impl_->order = order;
    impl_->axis = direction.normalized();
    const int n = 2 * order + 1;
    impl_->normal = impl_->inverse = Matrix::Zero(n, n);
    impl_->right = impl_->row = Vector::Zero(n);
}

HarmonicEstimator::~HarmonicEstimator() = default;
HarmonicEstimator::HarmonicEstimator(HarmonicEstimator&&) noexcept = default;
HarmonicEstimator& HarmonicEstimator::operator=(HarmonicEstimator&&) noexcept = default;

bool HarmonicEstimator::add(double turns, const std::array<double, 3>& a) noexcept {
    Impl& s = *impl_;
    const double t = turns - std::floor(turns);
    const bool wrapped = s.last >= 0 && t < s.last;
    if (wrapped) {
        s.finish();
        s.clear();
    }
    s.take(t, a);
    s.last = t;
    return wrapped;
}

bool HarmonicEstimator::add(std::uint64_t phase, const std::array<double, 3>& a) noexcept {
    return add(std::ldexp(static_cast<double>(phase >> 11U), -53), a);
}

void HarmonicEstimator::gap() noexcept { impl_->broken = true; }

const HarmonicEstimate& HarmonicEstimator::estimate() const noexcept { return impl_->estimate; }

double HarmonicEstimator::covariance(int i, int j) const {
    const int n = 2 * impl_->order;
    if (i < 0 || j < 0 || i >= n || j >= n) {
        throw InputError("covariance of component " + std::to_string(i) + " with " + std::to_string(j) +
                         "; allowed are 0 to " + std::to_string(n - 1));
    }
    return impl_->inverse(i, j);
}

}  // namespace shaker
