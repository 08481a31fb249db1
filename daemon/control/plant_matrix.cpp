#include "daemon/control/plant_matrix.hpp"

#include <Eigen/Dense>
#include <string>

#include "drivers/errors.hpp"

namespace shaker::control {

namespace {
using Eigen::Index;
using Vector = Eigen::VectorXd;
constexpr int most_common_gains = 3;     // a further deviation is not one of gain
constexpr double least_singular = 1e-3;  // of the largest

template <class Unit>
Vector vector_of(const Harmonics<Unit>& h, Index k) {
    Vector v{2 * k};
    for (Index q = 0; q < k; ++q) {
        v[2 * q] = h.a[static_cast<std::size_t>(q)].real();
        v[2 * q + 1] = h.a[static_cast<std::size_t>(q)].imag();
    }
    return v;
}

template <class Unit>
Harmonics<Unit> harmonics_of(const Vector& v) {
    Harmonics<Unit> h;
    for (Index q = 0; q < v.size() / 2; ++q) h.a[static_cast<std::size_t>(q)] = {v[2 * q], v[2 * q + 1]};
    return h;
}

Eigen::Matrix2d rotation(std::complex<double> c) {
    Eigen::Matrix2d m;
    m << c.real(), -c.imag(), c.imag(), c.real();
    return m;
}
}  // namespace

struct PlantMatrix::Work {
    Index k;
    Eigen::MatrixXd j, inverse;
    Vector scale;  // |first response|, each twice
    int common_gains = 0;

    // Pseudo-inverse of j with scaled columns; nearly singular directions are left out.
    void invert() {
        Eigen::JacobiSVD<Eigen::MatrixXd> svd{j * scale.cwiseInverse().asDiagonal(),
                                              Eigen::ComputeThinU | Eigen::ComputeThinV};
        svd.setThreshold(least_singular);
        inverse =
            scale.cwiseInverse().asDiagonal() * svd.solve(Eigen::MatrixXd::Identity(2 * k, 2 * k)).eval();
    }
};

PlantMatrix::PlantMatrix(int harmonics, const std::array<std::complex<double>, max_harmonics>& response)
    : work_{std::make_unique<Work>()} {
    work_->k = harmonics;
    work_->j = Eigen::MatrixXd::Zero(2 * work_->k, 2 * work_->k);
    work_->scale = Vector::Zero(2 * work_->k);
    for (Index q = 0; q < work_->k; ++q) {
        const std::complex<double> h = response[static_cast<std::size_t>(q)];
        if (!(std::abs(h) > 0) || !std::isfinite(std::abs(h)))
            throw InputError{"response of the shaker at harmonic " + std::to_string(q + 1) +
                             " is zero or not finite; check the data sheet in [shaker]"};
        work_->j.block<2, 2>(2 * q, 2 * q) = rotation(h);
        work_->scale.segment<2>(2 * q).setConstant(std::abs(h));
    }
    work_->invert();
}
PlantMatrix::PlantMatrix(const PlantMatrix& other) : work_{std::make_unique<Work>(*other.work_)} {}
PlantMatrix& PlantMatrix::operator=(const PlantMatrix& other) {
    *work_ = *other.work_;
    return *this;
}
PlantMatrix::~PlantMatrix() = default;

Harmonics<Acceleration> PlantMatrix::motion(const Harmonics<Voltage>& volts) const {
    return harmonics_of<Acceleration>(work_->j * vector_of(volts, work_->k));
}

Harmonics<Voltage> PlantMatrix::drive(const Harmonics<Acceleration>& motion) const {
    return harmonics_of<Voltage>(work_->inverse * vector_of(motion, work_->k));
}

void PlantMatrix::scale(const std::array<std::complex<double>, max_harmonics>& factors) {
    for (Index q = 0; q < work_->k; ++q)
        work_->j.middleRows<2>(2 * q) =
            (rotation(factors.at(static_cast<std::size_t>(q))) * work_->j.middleRows<2>(2 * q)).eval();
    work_->invert();
}

std::complex<double> PlantMatrix::learn(const Harmonics<Voltage>& stepped,
                                        const Harmonics<Acceleration>& moved, double noise) {
    Work& w = *work_;
    const Vector du = vector_of(stepped, w.k), dy = vector_of(moved, w.k);
    if (!(dy.norm() > 5 * noise * std::sqrt(static_cast<double>(2 * w.k)))) return 1;
    const Harmonics<Acceleration> foretold = motion(stepped);
    std::complex<double> gain = 1, product = 0;
    double square = 0;
    for (std::size_t q = 0; q < static_cast<std::size_t>(w.k); ++q) {
        product += std::conj(foretold.a[q]) * moved.a[q];
        square += std::norm(foretold.a[q]);
    }
    if (square > 0 && w.common_gains < most_common_gains) {
        const std::complex<double> alpha = product / square;
        double misfit = 0;
        for (std::size_t q = 0; q < static_cast<std::size_t>(w.k); ++q)
            misfit += std::norm(moved.a[q] - alpha * foretold.a[q]);
        if (std::abs(alpha - 1.0) > 0.25 && std::abs(alpha) > 0.02 && std::sqrt(misfit) < 0.5 * dy.norm()) {
            gain = alpha;
            ++w.common_gains;
            for (Index q = 0; q < w.k; ++q)
                w.j.middleRows<2>(2 * q) = (rotation(alpha) * w.j.middleRows<2>(2 * q)).eval();
        }
    }
    // In volts scaled by the first responses: otherwise the harmonics with a strong response would
    // take the whole update.
    const Vector scaled = w.scale.cwiseProduct(du);
    const Vector direction = scaled.cwiseProduct(w.scale) / scaled.squaredNorm();
    w.j += (dy - w.j * du) * direction.transpose();
    w.invert();
    return gain;
}

}  // namespace shaker::control
